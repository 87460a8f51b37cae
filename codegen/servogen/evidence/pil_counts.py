"""Instructions executed against operations counted, call for call and in the worst case.

Three counts of each call meet here. *Static*: the worst case read from the C. *Counted*: what the
counting twin of the C did on the host in this very call. *Executed*: instructions of the processor.
For every call, executed <= counted <= static.

A compiler may put a cheaper operation that gives the same bits in the place of another: for x / 4
x * 0.25, for x * 2 x + x, for x * -1 -x. So the bound is not held class by class but from the
dearest class on: divisions; divisions and multiplications; these and additions; these and sign
changes. Comparisons, conversions and square roots are held each by itself.

An entry point is straight-line where its arithmetic does not depend on the data, that is where
every call counted as much as the worst case has. There all of it must be executed: divisions,
multiplications and additions together are equal, and class by class where the compiler sees no
constants (the kernels of ``pil_kernels``). Elsewhere a compiler does a little less (a product that
both ways of a decision need), never more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servogen.evidence.pil_map import ARITHMETIC, COLUMNS
from servogen.evidence.pil_run import Rows
from servogen.wcet.operations import CLASSES, OperationCounts

EXACT = ("add", "mul", "div", "sqrt")
# Instructions of every call that are no operation of the C: the marks, the call, its arguments,
# saved registers, the return. They matter where an entry point does next to nothing.
CALL = 20
# From the dearest on: each class is held together with all before it.
LADDER = ("div", "mul", "add", "neg")


@dataclass(frozen=True)
class EntryPoint:
    """One entry point on one processor.

    Attributes:
        calls: so many were counted.
        instructions: of the call with the most.
        operations: all classes of the static worst case together.
        factor: the largest ratio, over the calls, of instructions beyond ``CALL`` to operations
            counted.
        straight: see the head of the module.
        executed, counted, static: class -> of the call with the most of it; classes that are
            zero in all three are left out.
    """

    name: str
    calls: int
    instructions: int
    operations: int
    factor: float
    straight: bool
    executed: Mapping[str, int]
    counted: Mapping[str, int]
    static: Mapping[str, int]

    def to_json(self) -> dict[str, object]:
        return {
            "calls": self.calls,
            "instructions": self.instructions,
            "static_operations": self.operations,
            "instructions_per_static_operation": round(self.instructions / self.operations, 3),
            "largest_factor_of_a_call": round(self.factor, 3),
            "straight_line": self.straight,
            "executed": dict(self.executed),
            "counted": dict(self.counted),
            "static": dict(self.static),
        }


def compare_counts(
    name: str,
    counted: Rows,
    executed: Rows,
    static: OperationCounts,
    limit: float,
    each: bool = False,
) -> tuple[EntryPoint, list[str]]:
    """One entry point's calls, (calls, classes) each, and what is wrong with them.

    Args:
        limit: instructions of a call, beyond ``CALL``, for each operation counted in it.
        each: straight-line code in which every class must be equal by itself.
    """
    worst = static.as_dict()
    ours = {c: _column(counted, CLASSES.index(c)) for c in CLASSES}
    theirs = {c: _column(executed, COLUMNS.index(c)) for c in COLUMNS}
    straight = all((ours[c] == worst[c]).all() for c in EXACT)
    faults = [
        f"{name}: a run counted {ours[c].max()} {c}, the static count is {worst[c]}"
        for c in CLASSES
        if ours[c].max() > worst[c]
    ]
    if each and not straight:
        faults.append(f"{name}: straight-line code counted differently from call to call")
    for classes, exactly in _rungs(straight, each):
        found = _judge(_sum(theirs, classes), _sum(ours, classes), " + ".join(classes), exactly)
        faults += [f"{name}: {found}"] if found else []
    if theirs["fused"].any():
        faults.append(f"{name}: {theirs['fused'].max()} fused multiply-adds in one call")
    ratios = np.maximum(theirs["total"] - CALL, 0) / np.maximum(_sum(ours, CLASSES), 1)
    if ratios.max() > limit:
        faults.append(
            f"{name}: {ratios.max():.2f} instructions for each operation counted, "
            f"the stated factor is {limit:g}"
        )
    shown = [c for c in ARITHMETIC if worst[c] or ours[c].any() or theirs[c].any()]
    point = EntryPoint(
        name, len(ratios), int(theirs["total"].max()), sum(worst.values()),
        float(ratios.max()), straight,
        {c: int(theirs[c].max()) for c in shown},
        {c: int(ours[c].max()) for c in shown},
        {c: worst[c] for c in shown},
    )  # fmt: skip
    return point, faults


def _rungs(straight: bool, each: bool) -> list[tuple[tuple[str, ...], bool]]:
    """What is compared as one sum, and whether it must be equal."""
    alone = [((c,), straight and c in EXACT) for c in ARITHMETIC if each or c not in LADDER]
    sums = [(LADDER[: i + 1], straight and c == "add") for i, c in enumerate(LADDER)]
    return [*sums, *alone]


def _judge(
    executed: NDArray[np.int64], counted: NDArray[np.int64], what: str, exactly: bool
) -> str:
    """A sentence about the call that is farthest off; empty if none is."""
    more = executed - counted
    at = int(more.argmax())
    if more[at] > 0:
        return f"{executed[at]} {what} executed in one call, the C has {counted[at]}"
    at = int(more.argmin())
    if exactly and more[at] < 0:
        return (
            f"{executed[at]} {what} executed in one call of straight-line code, "
            f"the C has {counted[at]}"
        )
    return ""


def _sum(columns: Mapping[str, NDArray[np.int64]], names: Sequence[str]) -> NDArray[np.int64]:
    total: NDArray[np.int64] = np.sum([columns[n] for n in names], axis=0)
    return total


def compare_all(
    names: Sequence[str],
    which: NDArray[np.integer],
    counted: Rows,
    executed: Rows,
    static: Mapping[str, OperationCounts],
    limit: float,
    kernels: str = "",
) -> tuple[list[EntryPoint], list[str]]:
    """All entry points that were called, in the order of ``names``, and the faults.

    Args:
        which: (calls,) index into ``names`` of each call.
        kernels: how the names of those begin that must be equal class by class.
    """
    if not len(which) == len(counted) == len(executed):
        return [], [
            f"{len(which)} calls were made, {len(counted)} counted on the host and "
            f"{len(executed)} on the board"
        ]
    points, faults = [], []
    for number, name in enumerate(names):
        mask = which == number
        if not mask.any():
            faults.append(f"{name} was never called")
            continue
        each = bool(kernels) and name.startswith(kernels)
        point, found = compare_counts(
            name, counted[mask], executed[mask], static[name], limit, each
        )
        points.append(point)
        faults += found
    if not any(p.straight and sum(p.static[c] for c in EXACT if c in p.static) for p in points):
        faults.append("no straight-line entry point with arithmetic: nothing was held to equality")
    return points, faults


def _column(rows: Rows, index: int) -> NDArray[np.int64]:
    return rows[:, index].astype(np.int64)
