"""The dual active-set method against an outside solver and against its own conditions."""

from __future__ import annotations

from dataclasses import replace

import daqp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from servogen.qp.parametric import ParametricQP, parametric_qp
from servogen.qp.parametric_solver import ParametricSolver

MANY = settings(max_examples=150, deadline=None, derandomize=True)
SEEDS = st.integers(0, 2**32 - 1)


def random_program(seed: int, n: int, rows: int, p: int = 3) -> tuple[ParametricQP, np.ndarray]:
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(n, n)) * np.exp(generator.normal(size=n))
    hessian = root @ root.T + 1e-3 * np.eye(n)
    qp = parametric_qp(
        0.5 * (hessian + hessian.T),
        generator.normal(size=(n, p)),
        constant=generator.normal(size=n),
        rows=generator.normal(size=(rows, n)),
        bounds=generator.normal(size=rows) + 0.5,
        bounds_parameter=generator.normal(size=(rows, p)),
        upper=np.where(generator.random(n) < 0.3, 1.0, np.inf),
    )
    return qp, 3.0 * generator.normal(size=p)


def outside(qp: ParametricQP, theta: np.ndarray) -> tuple[np.ndarray, bool]:
    """DAQP's answer, and whether it found one."""
    g, w, s, _ = qp.all_rows()
    upper = w + s @ theta
    lower = np.full_like(upper, -1e30)
    z, _, flag, _ = daqp.solve(
        np.array(qp.hessian),
        qp.linear @ theta + qp.constant,
        g,
        upper,
        lower,
        np.zeros(w.size, dtype=np.int32),
        primal_tol=1e-10,
        dual_tol=1e-10,
    )
    return np.asarray(z), flag == 1


@MANY
@given(seed=SEEDS, n=st.integers(1, 8), rows=st.integers(0, 20))
def test_equals_an_outside_solver(seed: int, n: int, rows: int) -> None:
    qp, theta = random_program(seed, n, rows)
    found = ParametricSolver(qp).solve(theta)
    if not qp.all_rows()[1].size:
        slope, offset = qp.unconstrained()
        np.testing.assert_allclose(found.z, slope @ theta + offset, rtol=1e-6)
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
    g, w, s, _ = qp.all_rows()
    bound = w + s @ theta
    if not found.feasible:
        free = [(None, None)] * n
        answer = linprog(np.zeros(n), A_ub=g, b_ub=bound, bounds=free, method="highs")
        assert answer.status == 2
        return
    gradient = qp.hessian @ found.z + qp.linear @ theta + qp.constant + g.T @ found.dual
    size = np.abs(qp.hessian) @ np.abs(found.z) + np.abs(qp.linear @ theta) + np.abs(qp.constant)
    assert np.all(np.abs(gradient) <= 1e-9 * (1.0 + size))
    assert np.all(g @ found.z <= bound + 1e-9 * (1.0 + np.abs(bound)))
    assert np.all(found.dual >= 0.0)
    inactive = np.setdiff1d(np.arange(w.size), found.active)
    assert not np.any(found.dual[inactive])


def test_rows_twice_over_do_not_lead_in_circles() -> None:
    qp, theta = random_program(7, 5, 10)
    twice = replace(
        qp,
        rows=np.vstack([qp.rows, qp.rows]),
        bounds=np.tile(qp.bounds, 2),
        bounds_parameter=np.vstack([qp.bounds_parameter, qp.bounds_parameter]),
    )
    once, both = ParametricSolver(qp).solve(theta), ParametricSolver(twice).solve(theta)
    assert once.active
    np.testing.assert_allclose(once.z, both.z, atol=1e-9)


def test_the_same_row_in_other_units_is_kept_to_a_rounding() -> None:
    """Divided by their lengths they are the same but for the last digit, and none is kept by the
    point of another one but for that."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        rows, bounds = rng.normal(size=(3, 4)), -rng.random(3)
        units = np.array([1.0, 1.0 / 3.0, 7.0])[:, None]
        qp = parametric_qp(
            np.eye(4), np.zeros((4, 1)), rows=np.vstack(units[:, :, None] * rows),
            bounds=np.ravel(units * bounds),
        )  # fmt: skip
        assert ParametricSolver(qp).solve(np.zeros(1)).feasible, seed


def test_a_row_of_zeros_is_kept_or_broken_by_the_parameter_alone() -> None:
    qp = parametric_qp([[1.0]], [[1.0]], rows=[[0.0]], bounds=[1.0], bounds_parameter=[[-1.0]])
    assert ParametricSolver(qp).solve(np.array([0.5])).feasible
    assert not ParametricSolver(qp).solve(np.array([2.0])).feasible
