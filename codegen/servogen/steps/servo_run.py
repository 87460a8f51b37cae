"""``servogen simulate`` of a servo drive: its reference, and a pull on the load, judged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

from servogen.controllers.design import Reference
from servogen.controllers.pid import Pid
from servogen.controllers.pid_design import PidDesign
from servogen.controllers.servo_parts import ServoParts
from servogen.emit.package import CPackage
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.servo_drive import ServoDrive
from servogen.systems.servo_loop import DriveRun, Loop, MpcLoop, PidLoop
from servogen.systems.servo_task import (
    Task,
    TaskRow,
    judge_task,
    pull_task,
    reference_task,
    run_task,
)

SCHEMA = "servogen.simulate_servo/1"


@dataclass(frozen=True)
class ServoSimulation:
    """Runs with their rows: every task under the MPC, then under the PID if there is one."""

    runs: tuple[tuple[TaskRow, DriveRun], ...]
    inside: str

    @property
    def rows(self) -> list[TaskRow]:
        return [row for row, _ in self.runs]

    @property
    def faults(self) -> list[str]:
        """One sentence for each check that failed."""
        return [fault for row in self.rows for fault in row.faults]

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        first = self.rows[0]
        beside = [row for row in self.rows if row.controller == "PID" and row.task == first.task]
        pid = f", {beside[0].largest_error_deg:.4g} deg with the PID" if beside else ""
        lines = [
            f"simulate  {first.samples} samples of the {first.task} with the {self.inside} inside: "
            f"largest error {first.largest_error_deg:.4g} deg{pid}, "
            f"{first.largest_current_ma:.4g} mA"
        ]
        for row in self.rows:
            lines.append(
                f"          {row.controller}, {row.task}: largest error "
                f"{row.largest_error_deg:.4g} deg, mean {row.mean_error_deg:.4g}, "
                f"at the end {row.last_error_deg:.2g}"
            )
            for b in row.bounds:
                mark = "" if b.violation == 0.0 else f", over by {b.violation:.3g}"
                kind = "" if b.enforced else " (reported, not enforced)"
                lines.append(
                    f"            {b.name} at {b.where}: {b.worst:.6g} of {b.limit:.6g} {b.unit}"
                    f"{mark}{kind}"
                )
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "inside": self.inside,
            "runs": [task_json(row) for row in self.rows],
        }


def task_json(row: TaskRow) -> dict[str, object]:
    """A judged run for programs."""
    return {
        "controller": row.controller,
        "task": row.task,
        "passed": row.passed,
        "samples": row.samples,
        "largest_error_deg": row.largest_error_deg,
        "mean_error_deg": row.mean_error_deg,
        "last_error_deg": row.last_error_deg,
        "largest_current_ma": row.largest_current_ma,
        "statuses": row.statuses,
        "constraints": [
            {**asdict(b), "violation": b.violation, "passed": b.passed} for b in row.bounds
        ],
    }


def tasks(servo: ServoDrive) -> list[Task]:
    """What the project asks of the axis, and the pull if its drive allows one."""
    pull = pull_task(servo)
    return [reference_task(servo), *([pull] if pull is not None else [])]


def simulate(
    servo: ServoDrive, parts: ServoParts, package: CPackage | None, progress: Progress
) -> ServoSimulation:
    """Every task under each controller.

    Args:
        package: the C inside; None: the references of ``parts``.
    """
    found: list[tuple[TaskRow, DriveRun]] = []
    asked = tasks(servo)
    with _controllers(parts, package) as make:
        for controller in make:
            for task in asked:
                with progress.task(f"{controller}, {task.name}", total=task.samples) as bar:
                    run = run_task(servo, task, make[controller](), watch=bar.advance)
                found.append((judge_task(servo, controller, task, run), run))
    return ServoSimulation(tuple(found), "Python reference" if package is None else "compiled C")


@contextmanager
def _controllers(
    parts: ServoParts, package: CPackage | None
) -> Iterator[dict[str, Callable[[], Loop]]]:
    """Makers of a fresh loop for each controller."""
    taken, pid = parts.mpc.problem.horizons.trajectory, parts.pid

    def made(
        mpc: Callable[[], Reference], own: Callable[[], Reference]
    ) -> dict[str, Callable[[], Loop]]:
        found: dict[str, Callable[[], Loop]] = {"MPC": lambda: MpcLoop(mpc(), taken)}
        if pid is not None:
            found["PID"] = lambda: PidLoop(own())
        return found

    if package is None:
        yield made(parts.controller, lambda: Pid(_there(pid)))
        return
    by_prefix = {d.prefix: d for d in package.declarations}
    with built(package) as module:
        yield made(
            lambda: CompiledController(module, by_prefix[parts.mpc.prefix]),
            lambda: CompiledController(module, by_prefix[_there(pid).prefix]),
        )


def _there(pid: PidDesign | None) -> PidDesign:
    assert pid is not None
    return pid
