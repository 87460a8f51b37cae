"""The servo drive of paper 5 as a system of the line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from servogen.controllers.design import Declaration
from servogen.controllers.pid import Pid
from servogen.controllers.servo_parts import ServoParts
from servogen.emit.package import CPackage
from servogen.emit.read_back import read_back
from servogen.explicit.choose import Choice
from servogen.precision import PRECISIONS, Precision
from servogen.progress import Progress
from servogen.project.servo_load import ServoProject
from servogen.reports import ServoReportData, make_servo_report
from servogen.sil.harness import Repeating
from servogen.sil.scenarios import Scenario
from servogen.sil.servo_scenarios import servo_suite
from servogen.steps.servo_run import ServoSimulation, simulate, tasks
from servogen.steps.servo_study import ServoStudy, study
from servogen.steps.system import ClosedLoop, Findings, LoopEnd, Proof
from servogen.systems.claims import Claim
from servogen.systems.servo_drive import ServoDrive, lookup_choice, servo_drive, servo_parts
from servogen.systems.servo_loop import Loop, MpcLoop, PidLoop
from servogen.systems.servo_moves import move_claims
from servogen.systems.servo_proofs import region_claims, tree_claims
from servogen.systems.servo_tables import Emitted, edge_claims, table_claims
from servogen.systems.servo_task import Task, judge_task, reference_task, run_task

PROOFS = {"regions": "Critical regions cover", "tree": "Lookup proved"}


@dataclass(frozen=True)
class ServoSystem:
    """A judged drive with its explicit solution; see ``steps.system.System``."""

    servo: ServoDrive
    choice: Choice

    @property
    def project(self) -> ServoProject:
        return self.servo.project

    @property
    def precision(self) -> Precision:
        """What is shipped."""
        return PRECISIONS[self.project.output.precision]

    @cached_property
    def parts(self) -> ServoParts:
        return servo_parts(self.servo, self.choice)

    @property
    def figures(self) -> Mapping[str, object]:
        """The form of the lookup, why, and all that were looked at."""
        return {
            "lookup": self.choice.chosen.name,
            "reason": self.choice.reason,
            "forms": [
                {
                    "name": form.name,
                    "note": form.note,
                    "regions": None if form.solution is None else len(form.solution.regions),
                    "laws": None if form.solution is None else form.solution.laws.count,
                    "nodes": None if form.tree is None else form.tree.nodes,
                    "depth": None if form.tree is None else form.tree.depth,
                    "multiply_adds": None if form.count is None else form.count.multiply_adds,
                    "additions": None if form.count is None else form.count.additions,
                    "comparisons": None if form.count is None else form.count.comparisons,
                    "sign_changes": None if form.count is None else form.count.sign_changes,
                    "table_numbers": None if form.count is None else form.count.numbers,
                }
                for form in self.choice.forms
            ],
        }

    @property
    def notes(self) -> tuple[str, ...]:
        return ()

    @property
    def cheaper(self) -> str:
        return "a smaller controller.mpc.control_horizon or trajectory_horizon"

    @property
    def proofs(self) -> tuple[Proof, ...]:
        solved = any(form.solution is not None for form in self.choice.forms)
        no_regions = "" if solved else "no form of the lookup enumerates regions"
        return (
            Proof("regions", PROOFS["regions"], self._regions, no_regions),
            Proof("tree", PROOFS["tree"], self._tree),
        )

    def in_precision(self, precision: Precision) -> ServoParts:
        """The same design in another precision."""
        if precision is self.precision:
            return self.parts
        return servo_parts(self.servo, self.choice, precision=precision)

    def declarations(self, precision: Precision) -> tuple[Declaration, ...]:
        return self.in_precision(precision).declarations()

    def scenarios(self, precision: Precision, seed: int, count: int) -> Iterator[Scenario]:
        return servo_suite(self.in_precision(precision), seed, count)

    def loops(self, precision: Precision) -> tuple[ClosedLoop, ...]:
        parts = self.in_precision(precision)
        taken, pid = parts.mpc.problem.horizons.trajectory, parts.pid
        found = [
            ClosedLoop(
                name,
                parts.mpc.prefix,
                "samples",
                task.samples,
                parts.controller,
                self._run("MPC", task, lambda own: MpcLoop(own, taken)),
            )
            for name, task in self._loop_names()
        ]
        if pid is not None:
            task = reference_task(self.servo)
            run = self._run("PID", task, PidLoop)
            found.append(
                ClosedLoop(
                    "closed loop of the PID", pid.prefix, "samples", task.samples,
                    lambda: Pid(pid), run,
                )
            )  # fmt: skip
        return tuple(found)

    def _loop_names(self) -> list[tuple[str, Task]]:
        return [
            ("closed loop" if i == 0 else f"closed loop, {task.name}", task)
            for i, task in enumerate(tasks(self.servo))
        ]

    def _run(
        self, controller: str, task: Task, loop: Callable[[Repeating], Loop]
    ) -> Callable[[Repeating, int | None, Callable[[], None]], LoopEnd]:
        def run(own: Repeating, periods: int | None, advance: Callable[[], None]) -> LoopEnd:
            done = run_task(self.servo, task, loop(own), periods, advance)
            row = judge_task(self.servo, controller, task, done)
            return LoopEnd(row.samples, row.samples == task.samples, tuple(row.broken))

        return run

    def simulate(self, package: CPackage | None, progress: Progress) -> ServoSimulation:
        return simulate(self.servo, self.parts, package, progress)

    def study(self, progress: Progress) -> ServoStudy:
        return study(self.servo, progress)

    def page(self, found: Findings[ServoSimulation, ServoStudy]) -> str:
        return make_servo_report(
            ServoReportData(
                servo=self.servo,
                parts=self.parts,
                choice=self.choice,
                runs=found.simulated.runs,
                study=None if found.study is None else found.study.found,
                sil=found.sil,
                wcet=found.wcet,
                build=found.build,
                certificate=found.certificate,
            )
        )

    def _regions(self, packages: Sequence[CPackage], progress: Progress) -> list[Claim]:
        return region_claims(self.choice, self.parts.mpc.problem.qp, progress)

    def _tree(self, packages: Sequence[CPackage], progress: Progress) -> list[Claim]:
        """Of trees or clips, of the tables in the C, and of what they give in either precision."""
        problem, prefix = self.parts.mpc.problem.qp, self.parts.lookup.prefix
        texts = [read_back(package, prefix) for package in packages]
        emitted = [Emitted(own.precision, own.tables, own.dimensions) for own in texts]
        claims = tree_claims(self.choice, problem, progress)
        for own in emitted:
            claims += table_claims(self.choice.chosen, problem, own)
        claims += edge_claims(problem, emitted)
        for precision in PRECISIONS.values():
            if precision.is_float32 and not self.precision.is_float32:
                continue  # steep laws beside position bounds are what float64 is chosen for
            design = self.in_precision(precision).lookup
            claims += move_claims(problem, self.choice, design, progress)
        return claims


def prepare_servo(project: ServoProject, progress: Progress) -> ServoSystem:
    """Plants, program and explicit solution of a project.

    Raises:
        InputError: whatever is wrong with the project.
    """
    servo = servo_drive(project)
    system = ServoSystem(servo, lookup_choice(servo, progress=progress))
    _ = system.parts  # what the design refuses is said before anything is emitted
    return system
