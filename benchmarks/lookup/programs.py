"""Programs whose first move is looked up, and the parameters they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from explicit_problems import double_integrator
from qp.chosen import chosen
from qp.sequence import Array, Sequence, two_sided

from qp import servo
from servogen.qp.parametric import ParametricQP, parameter_box
from servogen.qp.parametric_solver import ParametricSolver
from servogen.systems.servo_drive import tracking_problem

MOVES = (1, 2, 3, 4, 5)
# Parameters drawn at random beside those of the closed loops, so that all regions are met.
DRAWN = 400
# Theta farther than this from the closed loops' largest is not asked for.
BEYOND = 2.0


@dataclass(frozen=True)
class Program:
    """``qp`` has a box as domain, which PPOPT needs; ``free``: the same without, where it had none.

    theta: (T, p); moves: (T, nu) first moves of the optimum by a solver in float64.
    """

    name: str
    source: str
    qp: ParametricQP
    free: ParametricQP
    theta: Array
    moves: Array

    def asked(self) -> Sequence:
        """For the harness: f is theta, there are no rows, and the move is the answer."""
        count, p = self.theta.shape
        answer = np.zeros((count, p))
        answer[:, : self.moves.shape[1]] = self.moves
        none = np.zeros((count, 0))
        return Sequence(
            self.name, self.source, np.zeros((p, p)), np.zeros((0, p)), self.theta, none, none, 0,
            0, optimum=answer, active=np.zeros(count, dtype=int),
        )  # fmt: skip

    def online(self) -> Sequence:
        """The programs themselves, for solvers; variables in units of their bounds."""
        qp = self.free
        rows, w, s, _ = qp.all_rows()
        unit = np.where(np.isfinite(qp.upper), np.abs(qp.upper), 1.0)
        size = float(np.max(np.abs(qp.hessian * np.outer(unit, unit))))
        length = np.abs(rows * unit).max(axis=1)
        first, second = two_sided(rows * unit / length[:, None])
        high = (w + self.theta @ s.T) / length
        return Sequence(
            self.name, self.source, qp.hessian * np.outer(unit, unit) / size,
            (rows * unit / length[:, None])[first],
            (self.theta @ qp.linear.T + qp.constant) * unit / size, -high[:, second],
            high[:, first], per_step=0, staying=len(first),
        )  # fmt: skip


def programs(quick: bool = False, only: tuple[str, ...] = ()) -> Iterator[Program]:
    """
    Args:
        quick: short horizons, for trying the benchmark out.
        only: see ``chosen``.

    Raises:
        UnknownName: there is nothing of a name in ``only``; before anything is made.
    """
    horizon = 3 if quick else 5
    makers: dict[str, Callable[[], Program]] = {
        f"servo_drive_{moves}": partial(_driven, moves) for moves in (MOVES[:3] if quick else MOVES)
    }
    makers[f"double_integrator_{horizon}"] = partial(_integrated, horizon)
    wanted = chosen(makers, only)
    return (make() for name, make in makers.items() if name in wanted)


def _driven(moves: int) -> Program:
    drive = servo.drive()
    extension = "zero_order" if moves == 1 else "first_order"
    problem = tracking_problem(drive, trajectory=moves, extension=extension)
    qp, loop = problem.qp, servo.parameters(drive, problem)
    rng = np.random.default_rng(moves)
    half = BEYOND * np.max(np.abs(loop), axis=0)
    scale = 10.0 ** rng.uniform(-2.0, 0.0, (DRAWN, 1))
    theta = np.vstack([loop, half * scale * rng.uniform(-1.0, 1.0, (DRAWN, half.size))])
    rows, bounds = parameter_box(-1.01 * half, 1.01 * half)
    return Program(
        f"servo_drive_{moves}",
        f"servo drive, H_u = H_t = {moves}, two closed loops and {DRAWN} drawn parameters",
        replace(qp, domain_rows=rows, domain_bounds=bounds), qp, *_answered(qp, theta),
    )  # fmt: skip


def _integrated(horizon: int) -> Program:
    qp = double_integrator(horizon)
    theta = np.random.default_rng(9).uniform(-5.0, 5.0, (2 * DRAWN, 2))
    return Program(
        f"double_integrator_{horizon}",
        f"double integrator of MPT's manual, horizon {horizon}, states limited, drawn parameters",
        qp, qp, *_answered(qp, theta),
    )  # fmt: skip


def _answered(qp: ParametricQP, theta: Array) -> tuple[Array, Array]:
    """Those that have a solution, and their first moves."""
    solver = ParametricSolver(qp)
    found = [solver.solve(each) for each in theta]
    able = [i for i, each in enumerate(found) if each.feasible]
    return theta[able], np.array([found[i].z[: qp.first_move] for i in able])
