"""Projection on a polyhedron against DAQP."""

from ctypes import c_int

import daqp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.explicit.tolerances import QP_DEPENDENT
from servogen.qp.nearest import Nearest, _activate, nearest
from servogen.qp.tolerances import DualMethodTolerances

TOLERANCES = DualMethodTolerances()


def project(g: np.ndarray, b: np.ndarray, tol: DualMethodTolerances = TOLERANCES) -> Nearest:
    """The point nearest to the origin."""
    return nearest(g, b, np.zeros(g.shape[1]), 1e-11, tol)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), rows=st.integers(1, 16))
def test_projection_is_daqps(seed: int, n: int, rows: int) -> None:
    """Feasible and infeasible sets; the multipliers belong to the active rows."""
    generator = np.random.default_rng(seed)
    g = generator.normal(size=(rows, n))
    g /= np.linalg.norm(g, axis=1, keepdims=True)
    b = generator.uniform(-1.0, 0.6, rows)
    s, _, flag, _ = daqp.solve(
        np.eye(n), np.zeros(n), g, b, np.full(rows, -1e30), np.zeros(rows, dtype=c_int),
        primal_tol=1e-11, dual_tol=1e-12,
    )  # fmt: skip
    found = project(g, b)
    assert found.kept == (flag == 1)
    if not found.kept:
        return
    np.testing.assert_allclose(found.v, s, atol=1e-8)
    active = list(found.active)
    assert active == sorted(active)
    assert np.all(found.multipliers >= 0.0)
    np.testing.assert_allclose(found.v, -found.multipliers @ g[active], atol=1e-9)


def test_more_active_rows_than_needed_at_a_corner() -> None:
    """Three lines through one point: two of them, independent, are named."""
    g = np.array([[1.0, 0.0], [0.0, 1.0], [np.sqrt(0.5), np.sqrt(0.5)]])
    found = project(g, np.array([-1.0, -1.0, -np.sqrt(2.0)]))
    assert found.kept
    np.testing.assert_allclose(found.v, [-1.0, -1.0], atol=1e-12)
    assert len(found.active) <= 2


def test_empty_set_and_no_rows() -> None:
    assert project(np.array([[1.0], [-1.0]]), np.array([-1.0, -1.0])).kept is False
    free = project(np.zeros((0, 3)), np.zeros(0))
    assert free.kept
    assert free.active == ()
    assert free.v == pytest.approx([0.0, 0.0, 0.0])


def corner(angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and bounds of v_1 <= 0 and a row against it, and the point that keeps both."""
    rows = np.array([[1.0, 0.0], [-1.0, angle]])
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    bounds = np.array([0.0, -1e-8])
    return rows, bounds, np.array([0.0, bounds[1] / rows[1, 1]])


@pytest.mark.parametrize("dependent", [TOLERANCES.dependent, QP_DEPENDENT])
def test_rows_at_angles_below_the_tolerance_count_as_parallel(dependent: float) -> None:
    """One point or another keeps them in either case."""
    tol = DualMethodTolerances(dependent=dependent)
    for share in (1.1, 2.0, 30.0):
        rows, bounds, point = corner(share * np.sqrt(dependent))
        found = project(rows, bounds, tol)
        assert found.kept
        assert found.active == (0, 1)
        # the multipliers lose digits by the square of the angle, the point by the angle
        np.testing.assert_allclose(found.v, point, atol=1e-15 / np.sqrt(dependent))
    for share in (0.9, 0.3):
        rows, bounds, point = corner(share * np.sqrt(dependent))
        assert np.all(rows @ point <= bounds + 1e-20)
        found = project(rows, bounds, tol)
        assert not found.kept
        assert len(found.active) == 1


def test_a_corner_is_met_to_the_last_digits_from_far_away() -> None:
    """What is left of z_unc beside n active rows is nothing; one projection leaves its rounding."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        rows = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        point = rng.normal(size=3)
        found = nearest(rows, rows @ point, 1e10 * rows.sum(axis=0), 1e-6, TOLERANCES)
        assert found.kept
        assert len(found.active) == 3
        np.testing.assert_allclose(found.v, point, atol=1e-13)


def test_multipliers_that_vanish_together_are_not_negative() -> None:
    """Two vanish at the same step, but for a rounding: one leaves, and the other's share of the
    entering row is a rounding of nothing then, by which nothing may be divided."""
    for seed in range(500):
        rng = np.random.default_rng(seed)
        cosine, dual = rng.uniform(0.1, 0.9), rng.uniform(0.5, 2.0)
        sine = np.sqrt(1.0 - cosine * cosine)
        rows = np.array([[1.0, 0.0], [-cosine, sine], [sine, cosine]])
        duals = np.array([dual, cosine * dual])
        v = -duals @ rows[:2]
        bounds = np.append(rows[:2] @ v, rows[2] @ v - 0.3)
        found = _activate(2, rows, v, bounds, [0, 1], duals, TOLERANCES)
        assert found is not None
        assert np.all(found[1] >= 0.0), seed
