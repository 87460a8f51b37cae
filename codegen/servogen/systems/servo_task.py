"""The project's own tasks, its reference and a pull on the load, under either controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import Status
from servogen.plants.two_mass import MILLIAMPERES
from servogen.precision import FloatArray
from servogen.project.limits import Limits
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
CURRENT_KEY = "controller.mpc.current_limit_ma"
TRACKING_KEY = "target.tracking_error_limit_deg"
TURN_KEY, RANGE_KEY = "axis.turn_deg", "axis.position_range_deg"


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
    low, high = servo.project.controller.mpc.current_limit_ma
    limit = high if high > 0.0 else low  # against the side that has any
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

    start = servo.project.reference.start_deg

    def rest(time_s: FloatArray) -> FloatArray:
        return np.full_like(time_s, start)

    return Task("pull on the load", rest, PULL_RUN, load)


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
        return [*self.broken, *(self._told(b) for b in self.bounds if _aim(b) and not b.passed)]

    @property
    def broken(self) -> list[str]:
        """Those of them about limits that a controller has to keep, however well it tracks."""
        found = [self._told(b) for b in self.bounds if not _aim(b) and not b.passed]
        bad = {name: count for name, count in self.statuses.items() if name != Status.OK.name}
        told = ", ".join(f"{name} {count}" for name, count in bad.items())
        who = f"{self.controller}, {self.task}"
        return [*found, *([f"{who}: not every status is OK: {told}"] if bad else [])]

    def _told(self, bound: Bound) -> str:
        return f"{self.controller}, {self.task}: {bound.fault}"

    @property
    def passed(self) -> bool:
        return not self.faults


def _aim(bound: Bound) -> bool:
    return bound.key in (TRACKING_KEY, TURN_KEY, RANGE_KEY)


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
    fine = f"{project.sampling.current_sample_time_s * 1e6:g} us"
    samples = f"{project.sampling.sample_time_s * 1e6:g} us"
    current, change = settings.current_limit_ma, settings.current_step_limit_ma
    found = _sides("current", "mA", run.current, current, fine, True, CURRENT_KEY)
    if change is not None:
        held = np.append(0.0, run.current[:: servo.ratio])
        # a step may round: its limit is added to the last current
        slack = 2.0**-23 * max(-current[0], current[1])
        limits = (change[0] - slack, change[1] + slack)
        key = "controller.mpc.current_step_limit_ma"
        found += _sides("change of current", "mA", np.diff(held), limits, samples, mpc, key)
    if settings.position_bound_deg is not None:
        # the program keeps the position that it predicts, so what the plant does is reported
        limits, key = settings.position_bound_deg, "controller.mpc.position_bound_deg"
        found += _sides("position", "deg", run.output, limits, samples, False, key)
    if task.load is None:
        worst, (limit_deg, key) = float(np.max(np.abs(run.error))), _tracking_limit(servo)
        found.append(Bound("tracking error", "deg", worst, limit_deg, samples, mpc, key=key))
    return found


def _tracking_limit(servo: ServoDrive) -> tuple[float, str]:
    """The project's own, or that beyond which an axis is lost: half a turn, after which it would go
    the other way, or all of its range."""
    asked, axis = servo.project.target.tracking_error_limit_deg, servo.project.axis
    if asked is not None:
        return asked, TRACKING_KEY
    if axis.turn_deg > 0.0:
        return 0.5 * axis.turn_deg, TURN_KEY
    return axis.position_range_deg, RANGE_KEY


def _sides(
    name: str, unit: str, values: FloatArray, limits: Limits, where: str, enforced: bool, key: str
) -> list[Bound]:
    """Limits that are the same to either side are one bound, others two."""
    low, high = limits
    if low == -high:
        worst = float(np.max(np.abs(values)))
        return [Bound(name, unit, worst, high, where, enforced, key=key)]
    most, least = float(np.max(values)), float(np.min(values))
    return [
        Bound(f"highest {name}", unit, most, high, where, enforced, key=key),
        Bound(f"lowest {name}", unit, least, low, where, enforced, below=True, key=key),
    ]
