"""The emitted C and its counts: each controller's head states what the counter read from it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from servogen.controllers.design import Declaration
from servogen.emit.package import CPackage, emit_package
from servogen.errors import CheckFailed
from servogen.wcet.allowance import Allowance, Task, allowances
from servogen.wcet.memory import Memory, occupied
from servogen.wcet.package import PackageCount, count_package
from servogen.wcet.targets import Target


@contextmanager
def written(package: CPackage) -> Iterator[Path]:
    """The package's files in a temporary folder that goes away with the block."""
    folder = Path(tempfile.mkdtemp(prefix="servogen-c-"))
    try:
        package.write(folder)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def entry_points(package: CPackage) -> list[str]:
    """Names of every function a user may call, by controller."""
    names = []
    for d in package.declarations:
        names.append(f"{d.prefix}_init")
        names += [f"{d.prefix}_{op.name}" for op in d.entries]
    return names


def periodic(package: CPackage) -> list[str]:
    """Names of those that are called once in a period."""
    return [
        f"{d.prefix}_{op.name}" for d in package.declarations for op in d.operations if op.period_s
    ]


def count_emitted(package: CPackage, names: Sequence[str] | None = None) -> PackageCount:
    """Worst-case counts of entry points (default: of all), read from the C."""
    with written(package) as folder:
        return count_package(
            [folder / name for name in package.sources],
            [folder],
            entry_points(package) if names is None else names,
            types=_structures(package),
        )


def emit_counted(name: str, declarations: tuple[Declaration, ...]) -> tuple[CPackage, PackageCount]:
    """The package with its counts in the heads of its files.

    Made twice: what is counted is a draft without them, and comments change no count.
    """
    counts = count_emitted(emit_package(name, declarations))
    return emit_package(name, declarations, counts), counts


def budgets(
    package: CPackage, counts: PackageCount, target: Target, share: float
) -> list[Allowance]:
    """What the periodic entry points use of the target, the longest window first; then the same
    with every controller that replaces another in its place."""
    found = []
    for instead in ["", *(d.prefix for d in package.declarations if d.replaces)]:
        tasks = _tasks(_running(package.declarations, instead), counts)
        own = allowances(tasks, target, counts.precision, share)
        found += [replace(budget, instead=instead) for budget in own]
    return found


def allowed_cap(
    package_at: Callable[[int], CPackage], start: int, target: Target, share: float
) -> int:
    """The largest iteration cap with which every budget holds.

    An iteration's share of the cheap turns of a cycle depends on how many there are, so what was
    counted at one cap is confirmed at the next.

    Args:
        package_at: the package with a cap. start: the cap that the count starts from.

    Raises:
        CheckFailed: not one iteration fits.
    """
    cap, confirmed = start, False
    while True:
        package = package_at(cap)
        counts = count_emitted(package, periodic(package))
        capped = [b for b in budgets(package, counts, target, share) if b.largest_cap is not None]
        tightest = min(capped, key=lambda b: b.largest_cap or 0)
        if not tightest.largest_cap:
            raise CheckFailed(f"not one iteration fits the target: {tightest.sentence()}")
        if confirmed and all(b.fits for b in capped):
            return cap
        cap = min(tightest.largest_cap, cap - 1 if confirmed else tightest.largest_cap)
        confirmed = True


def _running(declarations: Sequence[Declaration], instead: str) -> list[Declaration]:
    """Those that run together: without the ones that replace others, or with ``instead`` for the
    one that it replaces and what only that one uses."""
    gone = {d.prefix for d in declarations if d.replaces and d.prefix != instead}
    gone |= {d.replaces for d in declarations if d.prefix == instead}
    for d in reversed(declarations):  # those that use others come after them
        users = {user.prefix for user in declarations if d.prefix in user.uses}
        if users and users <= gone:
            gone.add(d.prefix)
    return [d for d in declarations if d.prefix not in gone]


def memory(package: CPackage, counts: PackageCount, target: Target) -> Memory:
    """What the package occupies of the target's memory.

    The state of a controller that another one uses is inside of that one's.
    """
    used = {name for d in package.declarations for name in d.uses}
    outer = [d for d in package.declarations if d.prefix not in used]
    size = counts.type_bytes
    return occupied(
        _tasks(package.declarations, counts),
        {f"{d.prefix}_t": size[f"{d.prefix}_t"] for d in outer},
        {name: size[name] for d in outer for name in _arguments(d)},
        counts.table_bytes,
        target,
    )


def _tasks(declarations: Iterable[Declaration], counts: PackageCount) -> list[Task]:
    return [
        Task(
            f"{d.prefix}_{op.name}",
            counts.entry_points[f"{d.prefix}_{op.name}"],
            op.period_s,
            op.deadline_s or op.period_s,
        )
        for d in declarations
        for op in d.operations
        if op.period_s
    ]


def _structures(package: CPackage) -> list[str]:
    names = []
    for d in package.declarations:
        names += [f"{d.prefix}_t", *_arguments(d)]
    return names


def _arguments(declaration: Declaration) -> list[str]:
    """Names of the structures that the caller of its periodic entry points holds."""
    names = []
    for op in declaration.operations:
        if op.period_s:
            names += [f"{declaration.prefix}_{op.name}_in"] if op.inputs else []
            names += [f"{declaration.prefix}_{op.name}_out"] if op.outputs else []
    return names
