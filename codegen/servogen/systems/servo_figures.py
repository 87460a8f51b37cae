"""What the charts of paper 5 show, in kind: data for the report.

Figures 5 and 6 are ``largest_error``'s runs, 7 and 8 ``tracking_table``; here are the plans along
the horizon (9, 10), the trapezoid of speed (14, 15) and the disturbance (16).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.prediction import Extension
from servogen.plants.two_mass import MILLIAMPERES
from servogen.precision import FloatArray, IntArray
from servogen.project.servo_schema import MatricesDrive
from servogen.qp.parametric_solver import ParametricSolver
from servogen.systems.servo_drive import ServoDrive
from servogen.systems.servo_loop import DriveRun, Loop, run_drive
from servogen.systems.servo_motion import reference_motion
from servogen.systems.servo_study import FAST, ideal_track, mpc_loop

WATERFALL_HORIZON = 4
REST_S = 0.1  # standing still after the motion, so that the end is seen
# The pull on the load: a third more than the motor holds at its limit, for a tenth of a second.
PULL_BEGIN_S, PULL_END_S, PULL_RUN_S = 0.25, 0.35, 0.7
PULL_SHARE = 4.0 / 3.0


@dataclass(frozen=True)
class Waterfall:
    """Figures 9, 10: ``current`` (K,) given and ``plan`` (K, H_u) foreseen at each of K samples,
    over the last cycle; ``gap``: mean distance, mA, from the plan's last input to what was given
    when its time came."""

    time_s: FloatArray
    current: FloatArray
    plan: FloatArray
    gap: float


def waterfall(servo: ServoDrive, extension: Extension) -> Waterfall:
    """Predicted and given currents of one cycle at 10 Hz, H_t = H_u = 4."""
    track = ideal_track(servo, FAST, WATERFALL_HORIZON, extension)
    last = FAST.last(servo.drive.sample_time_s)
    current, plan = track.current[-last:], track.plan[-last:]
    reach = WATERFALL_HORIZON - 1
    gap = float(np.mean(np.abs(plan[:-reach, -1] - current[reach:])))
    return Waterfall(track.time_s[-last:], current, plan, gap)


def profile_run(servo: ServoDrive, loop: Loop) -> DriveRun:
    """Figures 14 and 15: the project's own reference on the machine, through its encoder."""
    motion, lasts = reference_motion(servo.project.reference)
    return run_drive(servo, loop, motion, round((lasts + REST_S) / servo.drive.sample_time_s))


@dataclass(frozen=True)
class Disturbance:
    """Figure 16. ``pattern`` (K, H_u): which inputs of the plan are at a bound; ``law`` (K,): a
    number for each first-move law in the order of appearance, 1 the one without bounds;
    ``torque``: the pull, N m."""

    run: DriveRun
    pattern: IntArray
    law: IntArray
    torque: float


def disturbance_run(servo: ServoDrive) -> Disturbance:
    """The axis is pulled from its place by more than the current limit can hold, and let go.

    Raises:
        InputError: a drive given by matrices, on which no torque acts.
    """
    drive = servo.project.drive
    if isinstance(drive, MatricesDrive):
        raise servo.project.error("drive.model", drive.model, '"two_mass", for a pull on the load')
    loop = mpc_loop(servo)
    controller = loop.controller
    solver = ParametricSolver(controller.design.problem.qp)
    limit = float(controller.design.input_bounds.upper[0])
    torque = -PULL_SHARE * limit * drive.torque_constant_n_m_per_a / MILLIAMPERES
    patterns: list[IntArray] = []

    def watch() -> None:
        found = solver.solve(controller.theta.astype(np.float64))
        rows = np.sign(controller.design.problem.qp.G[list(found.active)])
        patterns.append(np.sum(rows, axis=0).astype(np.int64))

    run = run_drive(
        servo,
        loop,
        np.zeros_like,
        round(PULL_RUN_S / servo.drive.sample_time_s),
        lambda t: torque if PULL_BEGIN_S <= t < PULL_END_S else 0.0,
        watch,
    )
    pattern = np.array(patterns)
    return Disturbance(run, pattern, law_numbers(pattern), torque)


def law_numbers(pattern: IntArray) -> IntArray:
    """(K,) a number per first-move law: patterns whose first input is at a bound share one law."""
    known: dict[tuple[int, ...], int] = {(0,) * pattern.shape[1]: 1}
    numbers = []
    for row in pattern.tolist():
        key = tuple(row) if row[0] == 0 else (row[0],)
        numbers.append(known.setdefault(key, len(known) + 1))
    return np.array(numbers)
