"""The two-stage machine of paper 1 as a system of the line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servogen.controllers.cascade import Cascade
from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.controllers.design import Declaration
from servogen.emit.package import CPackage, emit_package
from servogen.errors import CheckFailed
from servogen.precision import Precision
from servogen.progress import Progress
from servogen.project import Project
from servogen.reports import ReportData, make_report
from servogen.sil.harness import Repeating
from servogen.sil.scenarios import Scenario, suite
from servogen.steps.counted import allowed_cap
from servogen.steps.system import ClosedLoop, Findings, LoopEnd, Proof
from servogen.steps.target import project_target
from servogen.steps.two_stage_iterations import iterations_finding
from servogen.steps.two_stage_run import SimulateResult, simulate
from servogen.steps.two_stage_study import StudyResult, compare
from servogen.systems.claims import Claim
from servogen.systems.closed_loop import Stalled, run_closed_loop
from servogen.systems.design_proofs import set_claims, terminal_claims
from servogen.systems.judgement import check_project
from servogen.systems.metrics import bounds, contour_error
from servogen.systems.two_stage import Machine, Tuning, design_cascade, project_tuning, with_cap

PROOFS = {
    "sets": "Admissible sets proved",
    "terminal": "Terminal condition",
    "iterations": "Worst case of the iterations",
}


@dataclass(frozen=True)
class TwoStage:
    """A judged machine with the tuning that will be built; see ``steps.system.System``."""

    machine: Machine
    tuning: Tuning

    @property
    def project(self) -> Project:
        return self.machine.project

    @cached_property
    def design(self) -> CascadeDesign:
        return design_cascade(self.machine, self.tuning)

    @property
    def figures(self) -> Mapping[str, object]:
        return {"iteration_cap": self.tuning.solver.cap if self.tuning.horizon else 0}

    @property
    def notes(self) -> tuple[str, ...]:
        return ()

    @property
    def cheaper(self) -> str:
        return "a smaller controller.solver.iteration_cap or controller.mpc.horizon"

    @property
    def proofs(self) -> tuple[Proof, ...]:
        alone = "" if self.tuning.horizon else "this controller solves no program"
        return (
            Proof("sets", PROOFS["sets"], lambda _, __: self._sets()),
            Proof("terminal", PROOFS["terminal"], lambda _, __: self._terminal(), alone),
            Proof(
                "iterations",
                PROOFS["iterations"],
                lambda _, __: (),
                alone,
                lambda bench, progress: iterations_finding(
                    self.machine, self.design.mpc or (), bench, progress
                ),
            ),
        )

    def in_precision(self, precision: Precision) -> CascadeDesign:
        """The same design in another precision."""
        if precision is self.machine.precision:
            return self.design
        return design_cascade(self.machine, self.tuning, precision=precision)

    def declarations(self, precision: Precision) -> tuple[Declaration, ...]:
        return declare_parts(self.in_precision(precision))

    def scenarios(self, precision: Precision, seed: int, count: int) -> Iterator[Scenario]:
        return suite(self.in_precision(precision), seed, count)

    def loops(self, precision: Precision) -> tuple[ClosedLoop, ...]:
        design, machine = self.in_precision(precision), self.machine

        def run(cascade: Repeating, periods: int | None, advance: Callable[[], None]) -> LoopEnd:
            try:
                ended = run_closed_loop(machine, cascade, periods, advance)
            except Stalled as stalled:
                told = f"the closed loop in {precision.name} stalled: {stalled}"
                raise CheckFailed(told) from stalled
            faults = tuple(bound.fault for bound in bounds(ended) if not bound.passed)
            return LoopEnd(ended.periods, ended.complete, faults)

        total = int(np.ceil(len(machine.timed.points) / machine.ratio))
        prefix = design.prefix
        return (
            ClosedLoop("closed loop", prefix, "slow periods", total, lambda: Cascade(design), run),
        )

    def simulate(self, package: CPackage | None, progress: Progress) -> SimulateResult:
        return simulate(self.machine, self.design, package, progress)

    def study(self, progress: Progress) -> StudyResult:
        return compare(self.machine, self.tuning, progress)

    def page(self, found: Findings[SimulateResult, StudyResult]) -> str:
        run = found.simulated.run
        return make_report(
            ReportData(
                machine=self.machine,
                run=run,
                row=found.simulated.row,
                contour_error=contour_error(run),
                design=self.design,
                study=found.study.rows if found.study else None,
                sil=found.sil,
                wcet=found.wcet,
                build=found.build,
                certificate=found.certificate,
            )
        )

    def _sets(self) -> list[Claim]:
        """Invariance and admissibility of O-infinity, and points just outside of it."""
        machine = self.machine
        sets = (machine.sets.x, machine.sets.y)
        inter = machine.project.controller.governor.inter_sample_rows
        return [
            claim
            for i, axis in enumerate("xy")
            for claim in set_claims(
                axis, sets[i], machine.slow[i], machine.slow_period_s, machine.limits[i], inter
            )
        ]

    def _terminal(self) -> list[Claim]:
        """(16g) and (17) of every program."""
        machine, mpc = self.machine, self.design.mpc
        if mpc is None:
            return []
        sets = (machine.sets.x, machine.sets.y)
        return [
            claim
            for i, axis in enumerate("xy")
            for claim in terminal_claims(
                axis, mpc[i], sets[i], self.tuning.weights, machine.limits[i]
            )
        ]


def prepare_two_stage(project: Project, progress: Progress) -> TwoStage:
    """Plants, sets, path and design of a project; the cap from the target if asked for.

    Raises:
        InputError: whatever is wrong with the project.
        CheckFailed: ``iteration_cap = "target"`` and not one iteration fits.
    """
    with progress.task("Plants, admissible sets, path"):
        parts = check_project(project)
    machine = Machine(project, parts.plants, parts.sets, parts.timed)
    tuning = project_tuning(project)
    if project.controller.solver.iteration_cap == "target" and tuning.horizon:
        tuning = with_cap(tuning, _allowed_cap(machine, tuning))
    return TwoStage(machine, tuning)


def _allowed_cap(machine: Machine, tuning: Tuning) -> int:
    def package_at(cap: int) -> CPackage:
        design = design_cascade(machine, with_cap(tuning, cap))
        return emit_package(design.prefix, declare_parts(design))

    target = project_target(machine.project)
    return allowed_cap(package_at, tuning.solver.cap, target, machine.project.target.share)
