"""DAQP on a parametric program of ours, parameter by parameter."""

from __future__ import annotations

from ctypes import c_int

import daqp
import numpy as np

from servogen.qp.parametric import ParametricQP

TOLERANCE = 1e-12  # of the constraints, which are scaled to a bound of about one


def first_moves(problem: ParametricQP, thetas: np.ndarray) -> np.ndarray:
    """(N, nu) by DAQP; NaN where it finds no feasible point. ``thetas``: (N, p)."""
    nu = problem.first_move
    found = np.full((thetas.shape[0], nu), np.nan)
    scale = _scale(problem)
    hessian = np.ascontiguousarray(problem.hessian * np.outer(scale, scale))
    size = np.max(np.diag(hessian))
    hessian /= size
    bounded = np.isfinite(problem.lower) & np.isfinite(problem.upper)
    assert np.all(bounded | (np.isinf(problem.lower) & np.isinf(problem.upper)))
    rows = problem.rows * scale
    length = np.linalg.norm(rows, axis=1) if rows.size else np.ones(0)
    rows = np.ascontiguousarray(rows / length[:, None])
    low, high = problem.lower / scale, problem.upper / scale
    senses = np.zeros(low.size + length.size, dtype=c_int)
    # far out the terms of F theta cancel: their sum is not to be the oracle's error
    wide = thetas.astype(np.longdouble) @ problem.linear.T.astype(np.longdouble)
    linear = ((wide + problem.constant) * scale / size).astype(np.float64)
    limits = (thetas @ problem.bounds_parameter.T + problem.bounds) / length
    big = 1e30
    low, high = np.maximum(low, -big), np.minimum(high, big)
    for i in range(thetas.shape[0]):
        upper = np.concatenate([high, limits[i]])
        lower = np.concatenate([low, np.full(length.size, -big)])
        z, _, flag, _ = daqp.solve(
            hessian, linear[i], rows, upper, lower, senses,
            primal_tol=TOLERANCE, dual_tol=TOLERANCE,
        )  # fmt: skip
        if flag == 1:
            found[i] = np.asarray(z)[:nu] * scale[:nu]
    return found


def _scale(problem: ParametricQP) -> np.ndarray:
    """Half ranges of the bounded variables, 1 for the others."""
    half = 0.5 * (problem.upper - problem.lower)
    return np.where(np.isfinite(half), half, 1.0)
