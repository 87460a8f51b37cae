"""From a project to the machine and the design that every step starts from."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.emit.package import CPackage, emit_package
from servogen.errors import CheckFailed
from servogen.precision import Precision
from servogen.progress import Progress
from servogen.project import Project
from servogen.systems.judgement import check_project, of_the_project
from servogen.systems.two_stage import (
    Machine,
    Tuning,
    design_cascade,
    project_tuning,
    with_cap,
)
from servogen.wcet.allowance import Allowance, iteration_allowance
from servogen.wcet.package import PackageCount, count_package
from servogen.wcet.targets import Target, load_target

# The entry point that takes its time, anywhere inside the slow period: what the budget is for.
SLOW = "plan"


@dataclass(frozen=True)
class Prepared:
    """A judged machine with the tuning that will be built; what is costly is made once."""

    machine: Machine
    tuning: Tuning
    _packages: dict[Precision, CPackage] = field(default_factory=dict, repr=False, compare=False)
    _counts: dict[Precision, PackageCount] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def design(self) -> CascadeDesign:
        return design_cascade(self.machine, self.tuning)

    @property
    def package(self) -> CPackage:
        return self.package_in(self.machine.precision)

    def in_precision(self, precision: Precision) -> CascadeDesign:
        """The same design in another precision."""
        if precision is self.machine.precision:
            return self.design
        return design_cascade(self.machine, self.tuning, precision=precision)

    def package_in(self, precision: Precision) -> CPackage:
        """What is emitted in a precision."""
        if precision not in self._packages:
            self._packages[precision] = package_of(self.in_precision(precision))
        return self._packages[precision]

    def counts_in(self, precision: Precision) -> PackageCount:
        """The worst case of what is emitted in a precision."""
        if precision not in self._counts:
            self._counts[precision] = count_emitted(self.package_in(precision))
        return self._counts[precision]


def package_of(design: CascadeDesign) -> CPackage:
    """Emit a cascade."""
    return emit_package(design.prefix, declare_parts(design))


def check_target(project: Project) -> Target:
    """Read the description of the processor.

    Raises:
        InputError: there is none of that name, it is faulty, or has no cycles for the precision.
    """
    with of_the_project(project):
        target = load_target(project.target.name, project.file.parent)
    precision = project.output.precision
    if precision not in target.cycles:
        known = " or ".join(f'"{name}"' for name in target.cycles)
        expected = f"{known}, all that target {target.name} has cycles for"
        raise project.error("output.precision", precision, expected)
    return target


def prepare(project: Project, progress: Progress) -> Prepared:
    """Plants, sets, path and design of a project; the cap from the target if asked for.

    Raises:
        InputError: whatever is wrong with the project.
        CheckFailed: ``iteration_cap = "target"`` and not one iteration fits.
    """
    check_target(project)
    with progress.task("Plants, admissible sets, path"):
        parts = check_project(project)
    machine = Machine(project, parts.plants, parts.sets, parts.timed)
    tuning = project_tuning(project)
    if project.controller.solver.iteration_cap == "target" and tuning.horizon:
        tuning = with_cap(tuning, _allowed_cap(machine, tuning))
    return Prepared(machine, tuning)


def _allowed_cap(machine: Machine, tuning: Tuning) -> int:
    """The largest cap whose own count fits: an iteration's share of the cheap turns of a cycle
    depends on how many there are, so what was counted at one cap is confirmed at the next."""
    target = project_target(machine.project)
    confirmed = False
    while True:
        package = package_of(design_cascade(machine, tuning))
        allowance = allow(machine, count_slow_step(package), target)
        if not allowance.largest_cap:
            raise CheckFailed(f"not one iteration fits the target: {allowance.sentence()}")
        if confirmed and allowance.fits:
            return tuning.solver.cap
        most = tuning.solver.cap - 1 if confirmed else allowance.largest_cap
        tuning = with_cap(tuning, min(allowance.largest_cap, most))
        confirmed = True


def project_target(project: Project, name: str | None = None) -> Target:
    """The target named, or the project's."""
    return load_target(name or project.target.name, project.file.parent)


@contextmanager
def written(package: CPackage) -> Iterator[Path]:
    """The package's files in a temporary folder that goes away with the block."""
    folder = Path(tempfile.mkdtemp(prefix="servogen-c-"))
    try:
        for name, text in package.files.items():
            (folder / name).write_text(text, encoding="utf-8")
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def entry_points(package: CPackage) -> list[str]:
    """Names of every function a user may call, by controller."""
    names = []
    for d in package.declarations:
        names.append(f"{d.prefix}_init")
        names += [f"{d.prefix}_{op.name}" for op in d.operations]
    return names


def count_emitted(package: CPackage) -> PackageCount:
    """Worst-case counts of every entry point, read from the C."""
    with written(package) as folder:
        return count_package(
            [folder / name for name in package.sources], [folder], entry_points(package)
        )


def count_slow_step(package: CPackage) -> PackageCount:
    """The same for the cascade's long part alone."""
    with written(package) as folder:
        return count_package(
            [folder / name for name in package.sources], [folder], [f"{package.name}_{SLOW}"]
        )


def allow(machine: Machine, counts: PackageCount, target: Target) -> Allowance:
    """What the slow step may use of the target, both axes together."""
    return iteration_allowance(
        counts.entry_points[f"{machine.project.name}_{SLOW}"],
        target,
        counts.precision,
        machine.slow_period_s,
        machine.project.target.share,
    )
