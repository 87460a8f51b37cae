"""The dual active-set method against an outside solver and against its own conditions."""

from __future__ import annotations

import daqp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from servogen.qp.parametric import ParametricQp
from servogen.qp.parametric_solver import ParametricSolver

MANY = settings(max_examples=150, deadline=None, derandomize=True)
SEEDS = st.integers(0, 2**32 - 1)


def random_program(seed: int, n: int, rows: int, p: int = 3) -> tuple[ParametricQp, np.ndarray]:
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(n, n)) * np.exp(generator.normal(size=n))
    hessian = root @ root.T + 1e-3 * np.eye(n)
    qp = ParametricQp(
        0.5 * (hessian + hessian.T),
        generator.normal(size=(n, p)),
        generator.normal(size=n),
        generator.normal(size=(rows, n)),
        generator.normal(size=rows) + 0.5,
        generator.normal(size=(rows, p)),
    )
    return qp, 3.0 * generator.normal(size=p)


def outside(qp: ParametricQp, theta: np.ndarray) -> tuple[np.ndarray, bool]:
    """DAQP's answer, and whether it found one."""
    upper = qp.w + qp.S @ theta
    lower = np.full_like(upper, -1e30)
    z, _, flag, _ = daqp.solve(
        np.array(qp.H),
        qp.F @ theta + qp.f,
        np.array(qp.G),
        upper,
        lower,
        np.zeros(qp.rows, dtype=np.int32),
        primal_tol=1e-10,
        dual_tol=1e-10,
    )
    return np.asarray(z), flag == 1


@MANY
@given(seed=SEEDS, n=st.integers(1, 8), rows=st.integers(0, 20))
def test_equals_an_outside_solver(seed: int, n: int, rows: int) -> None:
    qp, theta = random_program(seed, n, rows)
    found = ParametricSolver(qp).solve(theta)
    if rows == 0:
        np.testing.assert_allclose(found.z, -np.linalg.solve(qp.H, qp.F @ theta + qp.f), rtol=1e-6)
        return
    z, feasible = outside(qp, theta)
    assert found.feasible == feasible
    if feasible:
        np.testing.assert_allclose(found.z, z, atol=1e-7 * (1.0 + np.max(np.abs(z))))


@MANY
@given(seed=SEEDS, n=st.integers(1, 8), rows=st.integers(1, 20))
def test_the_answer_is_optimal_or_there_is_none(seed: int, n: int, rows: int) -> None:
    qp, theta = random_program(seed, n, rows)
    found = ParametricSolver(qp).solve(theta)
    bound = qp.w + qp.S @ theta
    if not found.feasible:
        free = [(None, None)] * n
        answer = linprog(np.zeros(n), A_ub=qp.G, b_ub=bound, bounds=free, method="highs")
        assert answer.status == 2
        return
    gradient = qp.H @ found.z + qp.F @ theta + qp.f + qp.G.T @ found.dual
    size = np.abs(qp.H) @ np.abs(found.z) + np.abs(qp.F @ theta) + np.abs(qp.f)
    assert np.all(np.abs(gradient) <= 1e-9 * (1.0 + size))
    assert np.all(qp.G @ found.z <= bound + 1e-9 * (1.0 + np.abs(bound)))
    assert np.all(found.dual >= 0.0)
    inactive = np.setdiff1d(np.arange(rows), found.active)
    assert not np.any(found.dual[inactive])


def test_rows_twice_over_do_not_lead_in_circles() -> None:
    qp, theta = random_program(7, 5, 10)
    twice = ParametricQp(
        qp.H, qp.F, qp.f, np.vstack([qp.G, qp.G]), np.tile(qp.w, 2), np.vstack([qp.S, qp.S])
    )
    once, both = ParametricSolver(qp).solve(theta), ParametricSolver(twice).solve(theta)
    assert once.active
    np.testing.assert_allclose(once.z, both.z, atol=1e-9)


def test_a_row_of_zeros_is_kept_or_broken_by_the_parameter_alone() -> None:
    qp = ParametricQp([[1.0]], [[1.0]], [0.0], [[0.0]], [1.0], [[-1.0]])
    assert ParametricSolver(qp).solve(np.array([0.5])).feasible
    assert not ParametricSolver(qp).solve(np.array([2.0])).feasible


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"H": -np.eye(2)}, "not positive definite"),
        ({"H": [[1.0, 0.5], [0.0, 1.0]]}, "not symmetric"),
        ({"F": np.zeros((3, 1))}, "shape"),
        ({"w": [np.inf]}, "not finite"),
        ({"lower": [0.0, 0.0]}, "lower is of shape"),
    ],
)
def test_what_is_no_program_is_refused(change: dict[str, object], told: str) -> None:
    parts: dict[str, object] = {
        "H": np.eye(2),
        "F": np.ones((2, 1)),
        "f": np.zeros(2),
        "G": np.ones((1, 2)),
        "w": [1.0],
        "S": np.zeros((1, 1)),
    }
    with pytest.raises(ValueError, match=told):
        ParametricQp(**(parts | change))
