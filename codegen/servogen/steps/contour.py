"""Receding-horizon LQ contour control, paper 2, as a system of the line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_declaration import declare_contour_lq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.contour_table_design import TableQuality, table_quality
from servogen.controllers.design import Declaration
from servogen.emit.package import CPackage
from servogen.precision import Precision
from servogen.progress import Progress
from servogen.project.contour_load import ContourProject
from servogen.reports import ContourReportData, make_contour_report
from servogen.sil.contour_scenarios import contour_suite
from servogen.sil.harness import Repeating
from servogen.sil.scenarios import Scenario
from servogen.steps.contour_run import ContourSimulation, simulate
from servogen.steps.contour_study import ContourStudyResult, study
from servogen.steps.system import ClosedLoop, Findings, LoopEnd, Proof
from servogen.systems.contour_loop import run_contour
from servogen.systems.contour_machine import ContourMachine, contour_design, contour_machine
from servogen.systems.contour_proofs import contour_claims, design_spectrum
from servogen.systems.contour_rows import judge_contour

# Of its velocity a contour may ask an axis for so much without a word.
MUCH = 0.75
PROOFS = {"contour_stability": "Stability on straight contours"}


@dataclass(frozen=True)
class ContourSystem:
    """A judged machine with the contour controller that will be built; see ``System``."""

    machine: ContourMachine

    @property
    def project(self) -> ContourProject:
        return self.machine.project

    @cached_property
    def design(self) -> ContourLqDesign:
        return contour_design(self.machine)

    @cached_property
    def quality(self) -> TableQuality | None:
        """Of gains per angle, where they are tabulated."""
        return None if self.design.table is None else table_quality(self.design)

    @property
    def figures(self) -> Mapping[str, object]:
        """Sizes of the law, and how fast the frozen closed loop is."""
        design = self.design
        modulus, _, _ = design_spectrum(design).worst(design.preview)
        return {
            "preview": design.preview,
            "points_that_slide": 0 if design.table else design.count,
            "directions_tabulated": design.table.entries if design.table else 0,
            "largest_modulus": self.quality.modulus if self.quality else modulus,
            "samples": self.machine.task.samples,
            "axes": {
                name: {
                    "order": axis.model.order,
                    "velocity_per_command_m_per_s": gain,
                    "filter_decay": axis.observer.decay,
                }
                for name, axis, gain in zip(
                    design.names, design.axes, self.machine.gains, strict=True
                )
            },
        }

    @property
    def notes(self) -> tuple[str, ...]:
        told = design_spectrum(self.design).warning(self.design.preview)
        near = (f"controller.contour.terminal: {told}",) if told else ()
        return (*near, *hardly_any_left(self.machine))

    @property
    def cheaper(self) -> str:
        return 'a smaller controller.contour.preview, or controller.contour.form = "tabulated"'

    @property
    def proofs(self) -> tuple[Proof, ...]:
        name = "contour_stability"
        return (Proof(name, PROOFS[name], lambda _, __: contour_claims(self.design)),)

    def in_precision(self, precision: Precision) -> ContourLqDesign:
        """The same design in another precision."""
        if precision is self.machine.precision:
            return self.design
        return contour_design(self.machine, precision)

    def declarations(self, precision: Precision) -> tuple[Declaration, ...]:
        return (declare_contour_lq(self.in_precision(precision)),)

    def scenarios(self, precision: Precision, seed: int, count: int) -> Iterator[Scenario]:
        return contour_suite(self.in_precision(precision), seed, count)

    def loops(self, precision: Precision) -> tuple[ClosedLoop, ...]:
        design, machine = self.in_precision(precision), self.machine
        task = machine.task

        def run(own: Repeating, periods: int | None, advance: Callable[[], None]) -> LoopEnd:
            count = task.samples if periods is None else min(periods, task.samples)
            found = run_contour(
                design, own, machine.axes, task.motion, count, machine.encoder_m, task.moving,
                advance,
            )  # fmt: skip
            if count < task.samples:
                return LoopEnd(count, False)
            row = judge_contour(design.prefix, found, task, machine.limits)
            faults = (f"inputs refused in {row.refused} samples",) if row.refused else ()
            return LoopEnd(count, True, faults)

        return (
            ClosedLoop(
                "closed loop", design.prefix, "samples", task.samples, lambda: ContourLq(design),
                run,
            ),
        )  # fmt: skip

    def simulate(self, package: CPackage | None, progress: Progress) -> ContourSimulation:
        return simulate(self.machine, self.design, package, progress)

    def study(self, progress: Progress) -> ContourStudyResult:
        return study(self.machine, progress)

    def page(self, found: Findings[ContourSimulation, ContourStudyResult]) -> str:
        return make_contour_report(
            ContourReportData(
                machine=self.machine,
                design=self.design,
                run=found.simulated.run,
                row=found.simulated.row,
                faults=tuple(found.simulated.faults),
                notes=self.notes,
                study=None if found.study is None else found.study.found,
                sil=found.sil,
                wcet=found.wcet,
                build=found.build,
                certificate=found.certificate,
            )
        )


def hardly_any_left(machine: ContourMachine) -> tuple[str, ...]:
    """A sentence for each axis that its contour asks for nearly all of its velocity."""
    step = np.max(np.abs(np.diff(machine.task.motion.points, axis=0)), axis=0)
    shares = step / machine.project.sampling.sample_time_s / (machine.gains * machine.limits)
    return tuple(
        f"machine.{name}.command_limit: the contour asks {name} for {share:.0%} of the velocity "
        "that it gives, which leaves little to correct by: commands may be cut at corners"
        for name, share in zip(machine.names, shares.tolist(), strict=True)
        if share > MUCH
    )


def prepare_contour(project: ContourProject, progress: Progress) -> ContourSystem:
    """Axes, contour and design of a project.

    Raises:
        InputError: whatever is wrong with the project.
    """
    with progress.task("Axes, contour, tables of the law"):
        system = ContourSystem(contour_machine(project))
        _ = system.design  # judged here, not where it is first used
    return system
