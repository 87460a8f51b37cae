"""From a project to the machine and the design that every step starts from."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.emit.package import CPackage, emit_package
from servogen.errors import CheckFailed
from servogen.precision import Precision
from servogen.progress import Progress
from servogen.project import Project
from servogen.steps.counted import budgets, count_emitted, emit_counted, periodic
from servogen.systems.judgement import check_project, of_the_project
from servogen.systems.two_stage import (
    Machine,
    Tuning,
    design_cascade,
    project_tuning,
    with_cap,
)
from servogen.wcet.package import PackageCount
from servogen.wcet.targets import Target, load_target


@dataclass(frozen=True)
class Prepared:
    """A judged machine with the tuning that will be built; what is costly is made once."""

    machine: Machine
    tuning: Tuning
    _emitted: dict[Precision, tuple[CPackage, PackageCount]] = field(
        default_factory=dict, repr=False, compare=False
    )

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
        """What is emitted in a precision, with its counts in the heads."""
        return self._emit(precision)[0]

    def counts_in(self, precision: Precision) -> PackageCount:
        """The worst case of what is emitted in a precision."""
        return self._emit(precision)[1]

    def _emit(self, precision: Precision) -> tuple[CPackage, PackageCount]:
        if precision not in self._emitted:
            design = self.in_precision(precision)
            self._emitted[precision] = emit_counted(design.prefix, declare_parts(design))
        return self._emitted[precision]


def package_of(design: CascadeDesign) -> CPackage:
    """Emit a cascade that is run and thrown away, uncounted."""
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
    """The largest cap with which every budget holds: an iteration's share of the cheap turns of a
    cycle depends on how many there are, so what was counted at one cap is confirmed at the next."""
    target, share = project_target(machine.project), machine.project.target.share
    confirmed = False
    while True:
        package = package_of(design_cascade(machine, tuning))
        counts = count_emitted(package, periodic(package))
        capped = [b for b in budgets(package, counts, target, share) if b.largest_cap is not None]
        tightest = min(capped, key=lambda b: b.largest_cap or 0)
        if not tightest.largest_cap:
            raise CheckFailed(f"not one iteration fits the target: {tightest.sentence()}")
        if confirmed and all(b.fits for b in capped):
            return tuning.solver.cap
        most = tuning.solver.cap - 1 if confirmed else tightest.largest_cap
        tuning = with_cap(tuning, min(tightest.largest_cap, most))
        confirmed = True


def project_target(project: Project, name: str | None = None) -> Target:
    """The target named, or the project's."""
    return load_target(name or project.target.name, project.file.parent)
