"""The extended command governor of paper 4 as a system of the line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_declaration import declare_governor_parts
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Declaration
from servogen.emit.package import CPackage, emit_package
from servogen.errors import CheckFailed
from servogen.precision import Precision
from servogen.progress import Progress
from servogen.project.governor_load import GovernorProject
from servogen.project.governor_schema import LEAST_CAP
from servogen.reports import GovernorReportData, make_governor_report
from servogen.sil.governor_scenarios import governor_suite
from servogen.sil.harness import Repeating
from servogen.sil.scenarios import Scenario
from servogen.steps.counted import allowed_cap
from servogen.steps.governor_run import GovernorSimulation, simulate
from servogen.steps.governor_study import GovernorStudyResult, study
from servogen.steps.system import ClosedLoop, Findings, LoopEnd, Proof
from servogen.steps.target import project_target
from servogen.systems.claims import Claim
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor import (
    GovernorMachine,
    governor_design,
    governor_machine,
)
from servogen.systems.command_governor_faults import long_axes
from servogen.systems.command_governor_motion import motion_declarations, motion_designs
from servogen.systems.command_governor_proofs import extended_claims
from servogen.systems.command_governor_rows import judge_governed
from servogen.systems.command_governor_study import run_machine

# R over Q. Along the bundled drawing's pattern float32 moved the plan on in 18 % of the steps at a
# share of 0.01, 5 % at 0.1, 2 % at 1, 0.5 % at 10, none at 100, and was a tenth faster for it.
FLOAT32_SHARE = 10.0

# What gives a plan more of them.
ROOM = (
    "take a larger target.share, fewer controller.governor.points_ahead or a shorter "
    "controller.governor.horizon"
)

PROOFS = {"extended_sets": "Extended sets proved"}


@dataclass(frozen=True)
class GovernorSystem:
    """A judged machine with the governor that will be built; see ``steps.system.System``."""

    machine: GovernorMachine

    @property
    def project(self) -> GovernorProject:
        return self.machine.project

    @cached_property
    def design(self) -> CommandGovernorDesign:
        return governor_design(self.machine)

    @property
    def figures(self) -> Mapping[str, object]:
        """Sizes of the sets and programs."""
        return {
            "points": len(self.machine.points),
            "points_ahead": self.design.window,
            "iteration_cap": self.machine.cap,
            "axes": {
                name: {
                    "inequalities": target.inequalities,
                    "non_redundant": 2 * len(target.sources),
                    "last_instant": target.last_instant,
                    "variables": axis.program.variables,
                    "rows": axis.program.rows.count,
                    "settle_m": axis.program.settle_m,
                }
                for name, target, axis in zip(
                    "xy", self.machine.sets, self.design.axes, strict=True
                )
            },
        }

    @property
    def notes(self) -> tuple[str, ...]:
        return (*self._weight_note, *self._ahead_note, *long_axes(self.project))

    @property
    def _weight_note(self) -> tuple[str, ...]:
        governor = self.project.controller.governor
        share = governor.weight_reference / governor.weight_auxiliary
        if not self.machine.precision.is_float32 or share >= FLOAT32_SHARE:
            return ()
        return (
            f"controller.governor.weight_reference = {governor.weight_reference:g} is small for "
            "float32: plans may often not be improved and the one before be moved on, which keeps "
            f"every limit; {FLOAT32_SHARE * governor.weight_auxiliary:g} or more is as fast",
        )

    @property
    def _ahead_note(self) -> tuple[str, ...]:
        asked, window = self.project.controller.governor.points_ahead, self.design.window
        if asked == "all" or asked <= window:
            return ()
        return (
            f"controller.governor.points_ahead = {asked} is more than a plan can use: it is given "
            f"{window}, (horizon + 1) M + 1",
        )

    @property
    def cheaper(self) -> str:
        return "a smaller controller.solver.iteration_cap or controller.governor.horizon"

    @property
    def proofs(self) -> tuple[Proof, ...]:
        return (Proof("extended_sets", PROOFS["extended_sets"], lambda _, __: self._sets()),)

    def in_precision(self, precision: Precision) -> CommandGovernorDesign:
        """The same design in another precision."""
        if precision is self.machine.precision:
            return self.design
        return governor_design(self.machine, precision)

    def declarations(self, precision: Precision) -> tuple[Declaration, ...]:
        own = declare_governor_parts(self.in_precision(precision))
        return (*motion_declarations(self.project, precision), *own)

    def scenarios(self, precision: Precision, seed: int, count: int) -> Iterator[Scenario]:
        motions = motion_designs(self.project, precision)
        return governor_suite(self.in_precision(precision), motions, seed, count)

    def loops(self, precision: Precision) -> tuple[ClosedLoop, ...]:
        design, machine = self.in_precision(precision), self.machine

        def run(own: Repeating, periods: int | None, advance: Callable[[], None]) -> LoopEnd:
            try:
                ended = run_machine(machine, design, own, periods, advance)
            except Stalled as stalled:
                told = f"the closed loop in {precision.name} stalled: {stalled}"
                raise CheckFailed(told) from stalled
            row = judge_governed(design.prefix, machine, ended, precision=precision)
            return LoopEnd(row.periods, row.complete, tuple(row.broken))

        total = int(np.ceil(len(machine.points) / machine.ratio))
        return (
            ClosedLoop(
                "closed loop", design.prefix, "slow periods", total,
                lambda: CommandGovernor(design), run,
            ),
        )  # fmt: skip

    def simulate(self, package: CPackage | None, progress: Progress) -> GovernorSimulation:
        return simulate(self.machine, self.design, package, progress)

    def study(self, progress: Progress) -> GovernorStudyResult:
        return study(self.machine, progress)

    def page(self, found: Findings[GovernorSimulation, GovernorStudyResult]) -> str:
        return make_governor_report(
            GovernorReportData(
                machine=self.machine,
                design=self.design,
                run=found.simulated.run,
                row=found.simulated.row,
                faults=tuple(found.simulated.faults),
                study=None if found.study is None else found.study.found,
                sil=found.sil,
                wcet=found.wcet,
                build=found.build,
                certificate=found.certificate,
            )
        )

    def _sets(self) -> list[Claim]:
        """Invariance and admissibility of P-tilde."""
        names = "x" if self.machine.alike else "xy"
        return [
            claim
            for name, target, slow in zip(names, self.machine.sets, self.machine.slow, strict=False)
            for claim in extended_claims(name, target, slow)
        ]


def prepare_governor(project: GovernorProject, progress: Progress) -> GovernorSystem:
    """Stages, sets, path, minimal motion and design of a project.

    Raises:
        InputError: whatever is wrong with the project, and a drawing that the governor might not
            finish.
        CheckFailed: ``iteration_cap = "target"`` and fewer iterations fit than a plan needs.
    """
    with progress.task("Stages, extended sets, path, minimal motion"):
        machine = governor_machine(project)
    if project.controller.solver.iteration_cap == "target":
        machine = replace(machine, cap=_allowed_cap(machine))
    return GovernorSystem(machine)


def _allowed_cap(machine: GovernorMachine) -> int:
    def package_at(cap: int) -> CPackage:
        system = GovernorSystem(replace(machine, cap=cap))
        return emit_package(machine.project.name, system.declarations(machine.precision))

    target = project_target(machine.project)
    try:
        cap = allowed_cap(package_at, machine.cap, target, machine.project.target.share)
    except CheckFailed as error:
        raise CheckFailed(f"{error}: {ROOM}") from error
    if cap < LEAST_CAP:
        raise CheckFailed(
            f"the target's share of the period has room for {cap} of the {LEAST_CAP} iterations "
            f"that a plan needs at least to get on: {ROOM}"
        )
    return cap
