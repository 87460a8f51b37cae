"""Projection on a polyhedron against DAQP."""

from ctypes import c_int

import daqp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.qp.nearest import Nearest, nearest
from servogen.qp.tolerances import DualMethodTolerances


def project(g: np.ndarray, b: np.ndarray) -> Nearest:
    """The point nearest to the origin."""
    return nearest(g, b, np.zeros(g.shape[1]), 1e-11, DualMethodTolerances())


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
