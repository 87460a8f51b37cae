"""INFEASIBLE is said of no program that a point solves: tight ones, small angles, float32."""

from __future__ import annotations

from collections.abc import Iterator

import daqp
import numpy as np
import pytest

from servogen.controllers.design import Status
from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_design import QpSolverDesign, design_qp_solver
from servogen.precision import PRECISIONS

ACCEPT = {"float64": 1e-9, "float32": 1e-4}
CAP = 200


def made(precision: str, hessian: np.ndarray, rows: np.ndarray) -> QpSolverDesign:
    return design_qp_solver("tight", PRECISIONS[precision], hessian, rows, CAP, ACCEPT[precision])


def solved(
    solver: QpSolver, linear: object, low: object, high: object
) -> tuple[Status, np.ndarray]:
    status, out = solver.call("step", {"linear": linear, "low": low, "high": high})  # type: ignore[dict-item]
    return status, np.asarray(out["z"], dtype=float)


@pytest.mark.parametrize(
    ("precision", "angle"),
    [("float32", e) for e in (1e-2, 9e-3, 5e-3, 1e-3)]
    + [("float64", e) for e in (1e-4, 2e-5, 9e-6, 5e-6, 1e-6)],
)
def test_rows_at_a_small_angle_meet_far_away(precision: str, angle: float) -> None:
    """x <= 1 and -x + angle y <= -2: y = -1 / angle."""
    solver = QpSolver(made(precision, np.eye(2), np.array([[1.0, 0.0], [-1.0, angle]])))
    solver.call("reset")
    status, z = solved(solver, [0.0, 0.0], [-1e6, -1e6], [1.0, -2.0])
    assert status is Status.OK
    np.testing.assert_allclose(
        z, [1.0, -1.0 / angle], rtol=1e-4 if precision == "float32" else 1e-8
    )


def programs(seed: int) -> Iterator[tuple[np.ndarray, ...]]:
    """H, A, f, low, high; a known point keeps all rows, often the only one."""
    rng = np.random.default_rng(seed)
    for k in range(12):
        n = int(rng.integers(2, 9))
        m = int(rng.integers(n, 25))
        root = rng.normal(size=(n, n))
        hessian = root @ root.T / n + (0.01 if k % 2 else 1.0) * np.eye(n)
        rows = rng.normal(size=(m, n))
        if k % 3 == 1:
            rows = np.round(1.2 * rows)
            rows[~rows.any(axis=1), 0] = 1.0
        for turn in range(50):
            linear = rng.normal(size=n) * 10.0 ** rng.uniform(-1.0, 2.0)
            middle = rows @ np.round(rng.normal(size=n))
            match turn % 3:
                case 0:
                    low, high = middle, middle
                case 1:
                    low, high = np.zeros(m), 1.0 * rng.integers(0, 2, m)
                case _:
                    low, high = middle - rng.integers(0, 2, m), middle + rng.integers(0, 2, m)
            yield hessian, rows, linear, low, high


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_programs_with_hardly_a_point_are_solved_or_not_judged(precision: str) -> None:
    """One after the other, so that every set begins with another program's."""
    seen = {status: 0 for status in Status}
    last: tuple[np.ndarray, ...] = ()
    for hessian, rows, linear, low, high in programs(7):
        if not last or last[0] is not hessian:
            solver = QpSolver(made(precision, hessian, rows))
            solver.call("reset")
            last = (hessian,)
        status, z = solved(solver, linear, low, high)
        seen[status] += 1
        if status is Status.OK:
            scale = solver.design.scale.astype(float)
            assert (
                np.max(np.maximum(rows @ z - high, low - rows @ z) * scale) <= 3 * ACCEPT[precision]
            )
            best = daqp.solve(hessian, linear, rows, high, low, np.zeros(len(low), dtype=np.int32))
            cost = 0.5 * z @ hessian @ z + linear @ z
            # a bound passed by what is accepted costs that times its multiplier
            spent = 3 * ACCEPT[precision] * np.sum(np.abs(best[3]["lam"]) / scale)
            room = (1e-8 if precision == "float64" else 1e-3) * (1.0 + abs(best[1]))
            if best[2] == 1:
                assert abs(cost - best[1]) <= spent + room
    assert seen[Status.INFEASIBLE] == 0
    assert seen[Status.OK] >= (590 if precision == "float64" else 540), seen


def test_a_set_that_contradicts_is_not_the_next_beginning() -> None:
    """Bounds that no z keeps, then ones that zero does, without a reset between them."""
    for hessian, rows, linear, low, high in programs(8):
        solver = QpSolver(made("float64", hessian, rows))
        solver.call("reset")
        apart = np.where(np.arange(len(low)) % 2 == 0, 50.0, -50.0)
        if solved(solver, linear, low + apart, high + apart)[0] is Status.INFEASIBLE:
            assert solver.work.size == 0
        assert solved(solver, linear, -np.ones(len(low)), np.ones(len(low)))[0] is Status.OK
