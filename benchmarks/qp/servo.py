"""The bundled servo drive: the program of its MPC in closed loop, for several control horizons."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qp.sequence import Array, Sequence
from servogen.controllers.design import Status
from servogen.controllers.prediction import Extension
from servogen.controllers.servo_mpc import ServoMpc, SolvedMove
from servogen.controllers.tracking_qp import TrackingQp
from servogen.precision import PRECISIONS
from servogen.project.servo_load import load_servo_project
from servogen.systems.servo_drive import ServoDrive, mpc_design, servo_drive, tracking_problem
from servogen.systems.servo_loop import MpcLoop
from servogen.systems.servo_task import PULL_BEGIN, pull_task, reference_task, run_task

FILE = Path(__file__).parents[2] / "examples" / "servo_drive" / "servogen.toml"

# Samples of each of the two tasks.
STRETCH = 400


class Recorder:
    """A first move that keeps the parameters it was asked for."""

    def __init__(self, problem: TrackingQp) -> None:
        self._inner = SolvedMove(problem, PRECISIONS["float64"])
        self.parameters: list[Array] = []

    def __call__(self, theta: Array) -> tuple[Status, Array]:
        self.parameters.append(np.array(theta, dtype=np.float64))
        return self._inner(theta)


def drive() -> ServoDrive:
    return servo_drive(load_servo_project(FILE))


def parameters(servo: ServoDrive, problem: TrackingQp) -> Array:
    """(K, p) theta of the closed loop: the start of the project's reference, and the pull on the
    load from a little before it to a little after."""
    design = mpc_design(servo, problem, PRECISIONS["float64"])
    found = []
    for task, begin, end in (
        (reference_task(servo), 0, STRETCH),
        (pull_task(servo), PULL_BEGIN - 50, PULL_BEGIN - 50 + STRETCH),
    ):
        assert task is not None
        recorder = Recorder(problem)
        loop = MpcLoop(ServoMpc(design, recorder), problem.horizons.trajectory)
        run_task(servo, task, loop, end)
        found.append(np.array(recorder.parameters)[begin:])
    return np.vstack(found)


def closed_loop(moves: int) -> Sequence:
    """``moves``: H_u and H_t; a first-order hold of the reference for all but one."""
    servo = drive()
    extension: Extension = "first_order" if moves > 1 else "zero_order"
    problem = tracking_problem(servo, trajectory=moves, extension=extension)
    theta = parameters(servo, problem)
    qp = problem.qp
    limit = np.maximum(np.abs(qp.lower), np.abs(qp.upper))
    count = len(theta)
    return Sequence(
        name=f"servo_drive_{moves}",
        source=f"closed loops of the bundled servo drive, H_u = H_t = {moves}",
        hessian=qp.hessian * np.outer(limit, limit) / _size(qp.hessian, limit),
        rows=np.eye(moves),
        linear=(theta @ qp.linear.T + qp.constant) * limit / _size(qp.hessian, limit),
        low=np.tile(qp.lower / limit, (count, 1)),
        high=np.tile(qp.upper / limit, (count, 1)),
        per_step=1,
        staying=0,
    )


def _size(hessian: Array, limit: Array) -> float:
    """So that H is of size one in units of the limits."""
    return float(np.max(np.abs(hessian) * np.outer(limit, limit)))
