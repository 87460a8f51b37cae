"""The project's own tasks, its reference and a pull on the load, under either controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import Status
from servogen.plants.two_mass import MILLIAMPERES
from servogen.project.servo_schema import MatricesDrive
from servogen.systems.metrics import Bound
from servogen.systems.servo_drive import ServoDrive
from servogen.systems.servo_loop import DriveRun, Load, Loop, Motion, run_drive
from servogen.systems.servo_motion import reference_motion

REST_S = 0.1  # standing still after the motion, so that the end is seen
# The pull on the load: a third more than the motor holds at its limit, for a tenth of a second
# where a sample lasts 500 us. In samples, so that slower and faster axes have as much of it.
PULL_BEGIN, PULL_END, PULL_RUN = 500, 700, 1400
PULL_SHARE = 4.0 / 3.0


@dataclass(frozen=True)
class Task:
    """What an axis is asked for. ``load``: N m on the load at a time; None: none."""

    name: str
    motion: Motion
    samples: int
    load: Load | None = None


def reference_task(servo: ServoDrive) -> Task:
    """The project's reference and a rest after it (Figures 14 and 15)."""
    motion, lasts = reference_motion(servo.project.reference)
    return Task("reference", motion, round((lasts + REST_S) / servo.drive.sample_time_s))


def pull_torque(servo: ServoDrive) -> float | None:
    """N m, more than the current limit can hold; None for a drive given by matrices, on which no
    torque acts."""
    drive = servo.project.drive
    if isinstance(drive, MatricesDrive):
        return None
    limit = servo.project.controller.mpc.current_limit_ma
    return -PULL_SHARE * limit * drive.torque_constant_n_m_per_a / MILLIAMPERES


def pull_task(servo: ServoDrive) -> Task | None:
    """The axis is pulled from its place by more than the limit can hold, and let go (Figure 16)."""
    torque = pull_torque(servo)
    if torque is None:
        return None
    period = servo.drive.sample_time_s
    begin, end = (PULL_BEGIN - 0.5 / servo.ratio) * period, (PULL_END - 0.5 / servo.ratio) * period

    def load(time_s: float) -> float:
        return torque if begin <= time_s < end else 0.0

    return Task("pull on the load", np.zeros_like, PULL_RUN, load)


def run_task(
    servo: ServoDrive,
    task: Task,
    loop: Loop,
    samples: int | None = None,
    watch: Callable[[], None] | None = None,
) -> DriveRun:
    """The task on the machine, through its encoder; the first ``samples`` of it or (None) all."""
    taken = task.samples if samples is None else min(samples, task.samples)
    return run_drive(servo, loop, task.motion, taken, task.load, watch)


@dataclass(frozen=True)
class TaskRow:
    """A run, judged.

    Attributes:
        controller: ``MPC`` or ``PID``; task: its name.
        largest_error_deg, mean_error_deg: of output less reference at the samples.
        last_error_deg: at the last sample.
        largest_current_ma: at the current loop's samples.
        statuses: samples by the name of their status.
    """

    controller: str
    task: str
    samples: int
    largest_error_deg: float
    mean_error_deg: float
    last_error_deg: float
    largest_current_ma: float
    bounds: tuple[Bound, ...]
    statuses: dict[str, int]

    @property
    def faults(self) -> list[str]:
        """One sentence for each check that failed."""
        who = f"{self.controller}, {self.task}"
        found = [
            f"{who}: {b.name} at {b.where} reached {b.worst:.6g} of {b.limit:.6g} {b.unit}"
            for b in self.bounds
            if not b.passed
        ]
        bad = {name: count for name, count in self.statuses.items() if name != Status.OK.name}
        told = ", ".join(f"{name} {count}" for name, count in bad.items())
        return [*found, *([f"{who}: not every status is OK: {told}"] if bad else [])]

    @property
    def passed(self) -> bool:
        return not self.faults


def judge_task(servo: ServoDrive, controller: str, task: Task, run: DriveRun) -> TaskRow:
    """A run as a row. The MPC's limits are enforced; what the PID does beside it is reported, but
    for its current."""
    error = np.abs(run.error)
    names = [Status(int(s)).name for s in run.status]
    return TaskRow(
        controller=controller,
        task=task.name,
        samples=int(run.time_s.size),
        largest_error_deg=float(np.max(error)),
        mean_error_deg=float(np.mean(error)),
        last_error_deg=float(error[-1]),
        largest_current_ma=float(np.max(np.abs(run.current))),
        bounds=tuple(_bounds(servo, controller == "MPC", task, run)),
        statuses={name: names.count(name) for name in sorted(set(names))},
    )


def _bounds(servo: ServoDrive, mpc: bool, task: Task, run: DriveRun) -> list[Bound]:
    project = servo.project
    settings = project.controller.mpc
    most = float(np.max(np.abs(run.current)))
    fine = f"{project.sampling.current_sample_time_s * 1e6:g} us"
    found = [Bound("current", "mA", most, settings.current_limit_ma, fine, True)]
    samples = f"{project.sampling.sample_time_s * 1e6:g} us"
    if settings.current_step_limit_ma is not None:
        held = np.append(0.0, run.current[:: servo.ratio])
        step = float(np.max(np.abs(np.diff(held))))
        limit = settings.current_step_limit_ma
        # a step may round: its limit is added to the last current
        slack = 2.0**-23 * settings.current_limit_ma
        found.append(Bound("change of current", "mA", step, limit + slack, samples, mpc))
    if settings.position_bound_deg is not None:
        # the program keeps the position that it predicts, so what the plant does is reported
        reached = float(np.max(np.abs(run.output)))
        found.append(Bound("position", "deg", reached, settings.position_bound_deg, samples, False))
    limit_deg = project.target.tracking_error_limit_deg
    if limit_deg is not None and task.load is None:
        worst = float(np.max(np.abs(run.error)))
        found.append(Bound("tracking error", "deg", worst, limit_deg, samples, mpc))
    return found
