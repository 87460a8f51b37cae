"""Closed loops of a servo drive: the ideal one of the paper's study, and the one on the machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servogen.controllers.design import Status, Value
from servogen.controllers.pid import Pid
from servogen.controllers.servo_mpc import ServoMpc
from servogen.controllers.tracking_qp import TrackingQp
from servogen.plants.sampled import Sampled
from servogen.precision import FloatArray, IntArray
from servogen.qp.parametric_solver import ParametricSolver
from servogen.systems.servo_drive import ServoDrive

# Degrees at a time in seconds; takes and gives arrays.
Motion = Callable[[FloatArray], FloatArray]
# N m on the load at a time in seconds.
Load = Callable[[float], float]


@dataclass(frozen=True)
class Track:
    """A run under perfect knowledge. K samples.

    time_s, reference, output, current: (K,); plan: (K, H_u) of inputs at each sample; pattern:
    (K, H_u) which of them is at its upper (1) or lower (-1) bound.
    """

    time_s: FloatArray
    reference: FloatArray
    output: FloatArray
    current: FloatArray
    plan: FloatArray
    pattern: IntArray

    @property
    def error(self) -> FloatArray:
        """(K,) output less reference."""
        result: FloatArray = self.output - self.reference
        return result


class _Law:
    """The plan for a parameter: where the unconstrained one keeps all rows it is the optimum, which
    a matrix tells; else the program is solved."""

    def __init__(self, problem: TrackingQp) -> None:
        self._qp = problem.qp
        self._free = -np.linalg.solve(problem.qp.H, problem.qp.F)
        self._solver = ParametricSolver(problem.qp)

    def __call__(self, theta: FloatArray) -> tuple[FloatArray, IntArray]:
        qp, plan = self._qp, self._free @ theta
        pattern = np.zeros(plan.size, dtype=np.int64)
        if np.all(qp.G @ plan <= qp.w + qp.S @ theta):
            return plan, pattern
        found = self._solver.solve(theta)
        for row in found.active:
            pattern += np.sign(qp.G[row]).astype(np.int64)
        return found.z, pattern


def track_ideal(problem: TrackingQp, drive: Sampled, motion: Motion, samples: int) -> Track:
    """The MPC on ``drive`` (one input, one output), with its whole state known, from rest.

    References are those of the samples ahead, r(i|k) = motion((k+i) T).
    """
    law, layout = _Law(problem), problem.layout
    period, taken = drive.sample_time_s, problem.horizons.trajectory
    wanted = motion(np.arange(samples + taken) * period)
    state, before = np.zeros(drive.order), np.zeros(drive.order)
    theta, current = np.zeros(layout.size), 0.0
    outputs, currents, plans, patterns = [], [], [], []
    for k in range(samples):
        output = float((drive.c @ state)[0])
        theta[layout.increment] = state - before
        theta[layout.previous] = current
        theta[layout.reference] = wanted[k + 1 : k + 1 + taken] - output
        if problem.constraints.signal is not None:
            theta[layout.signal] = output
        plan, pattern = law(theta)
        current = float(plan[0])
        before, state = state, drive.a @ state + drive.b[:, 0] * current
        outputs.append(output)
        currents.append(current)
        plans.append(plan)
        patterns.append(pattern)
    return Track(
        np.arange(samples) * period,
        wanted[:samples],
        np.array(outputs),
        np.array(currents),
        np.array(plans),
        np.array(patterns),
    )


class Loop(Protocol):
    """A controller as the loop on the machine calls it."""

    taken: int

    def reset(self, position: float) -> Status: ...

    def sample(self, position: float, ahead: FloatArray) -> Status:
        """Every T: the measurement and the reference now and ``taken`` samples ahead."""

    def current(self) -> float:
        """Every period of the current loop: what the drive is given, mA."""


class MpcLoop:
    """The MPC's reference step; its current is held between samples."""

    def __init__(self, controller: ServoMpc) -> None:
        self.controller = controller
        self.taken = controller.design.problem.horizons.trajectory
        self._current = 0.0

    def reset(self, position: float) -> Status:
        return self.controller.call("reset", {"position": position})[0]

    def sample(self, position: float, ahead: FloatArray) -> Status:
        given: dict[str, Value] = {"position": position, "reference": ahead[1:]}
        status, out = self.controller.call("step", given)
        self._current = float(out["current"])
        return status

    def current(self) -> float:
        return self._current


class PidLoop:
    """The cascaded PID's reference step."""

    taken = 0

    def __init__(self, controller: Pid) -> None:
        self.controller = controller

    def reset(self, position: float) -> Status:
        return self.controller.call("reset", {"position": position})[0]

    def sample(self, position: float, ahead: FloatArray) -> Status:
        return self.controller.call("step", {"position": position, "reference": ahead[0]})[0]

    def current(self) -> float:
        return float(self.controller.call("filter_step")[1]["current"])


@dataclass(frozen=True)
class DriveRun:
    """A run on the machine. K samples of position control, M of the current loop in each.

    time_s, reference, output (motor angle, not wrapped), status: (K,); fine_time_s, current,
    fine_output: (K M,).
    """

    time_s: FloatArray
    reference: FloatArray
    output: FloatArray
    status: IntArray
    fine_time_s: FloatArray
    fine_output: FloatArray
    current: FloatArray

    @property
    def error(self) -> FloatArray:
        """(K,) output less reference."""
        result: FloatArray = self.output - self.reference
        return result


def run_drive(
    servo: ServoDrive,
    loop: Loop,
    motion: Motion,
    samples: int,
    load: Load | None = None,
    watch: Callable[[], None] | None = None,
) -> DriveRun:
    """The drive at the current loop's rate, seen through its encoder, from rest at motion(0).

    On an axis that comes round, encoder and references are told modulo a turn.

    Args:
        watch: called after every sample of position control.
    """
    axis, fine = servo.project.axis, servo.fine
    period = servo.drive.sample_time_s
    wanted = motion(np.arange(samples + loop.taken + 1) * period)
    # plants of drives are at rest wherever they stand: the start is added to what they show
    start, state = float(wanted[0]), np.zeros(fine.order)
    told = _modulo(wanted, axis.turn_deg)
    loop.reset(_encoder(start, axis.encoder_resolution_deg, axis.turn_deg))
    outputs, statuses, fine_outputs, currents = [], [], [], []
    for k in range(samples):
        output = start + float((fine.c @ state)[0])
        seen = _encoder(output, axis.encoder_resolution_deg, axis.turn_deg)
        statuses.append(int(loop.sample(seen, told[k : k + loop.taken + 1])))
        outputs.append(output)
        for j in range(servo.ratio):
            fine_outputs.append(start + float((fine.c @ state)[0]))
            currents.append(loop.current())
            torque = load((k + j / servo.ratio) * period) if load else 0.0
            state = fine.a @ state + fine.b @ np.array([currents[-1], torque])
        if watch is not None:
            watch()
    return DriveRun(
        np.arange(samples) * period,
        wanted[:samples],
        np.array(outputs),
        np.array(statuses),
        np.arange(samples * servo.ratio) * fine.sample_time_s,
        np.array(fine_outputs),
        np.array(currents),
    )


def _modulo(angles: FloatArray, turn: int) -> FloatArray:
    result: FloatArray = np.mod(angles, turn) if turn else angles
    return result


def _encoder(angle: float, resolution: float, turn: int) -> float:
    counted = np.round(angle / resolution) * resolution
    return float(np.mod(counted, turn)) if turn else float(counted)
