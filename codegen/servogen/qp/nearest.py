"""The point of a polyhedron nearest to another one: the dual method of Goldfarb and Idnani (1983).

Every strictly convex program takes this form with v = L'z, H = L L'. The method starts at the
unconstrained optimum and makes one violated row active after the other, letting go those whose
multiplier would turn negative; every iterate is optimal for its active rows, so the first one that
keeps all rows is the answer, and a row that no multiplier can reach proves that there is none, to
within the angle below which rows count as parallel. It serves few calls and many digits: the factor
is made anew at every step, which the method that is emitted (``dual_active_set``) cannot afford.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.precision import FloatArray
from servogen.qp.errors import NotSolved
from servogen.qp.tolerances import DualMethodTolerances


@dataclass(frozen=True)
class Nearest:
    """The point ``v`` (n,), the active rows in ascending order, linearly independent, and their
    multipliers, not negative. ``kept`` False: a row that the active ones leave nothing of cannot be
    kept beside them, and ``v`` is nearest for those that were active last. Then no point keeps all
    rows, or only one in a corner of rows at an angle below the square root of
    ``DualMethodTolerances.dependent``: such rows count as parallel."""

    v: FloatArray
    active: tuple[int, ...]
    multipliers: FloatArray
    kept: bool


def nearest(
    rows: FloatArray,
    bound: FloatArray,
    free: FloatArray,
    excess: FloatArray | float,
    tol: DualMethodTolerances,
) -> Nearest:
    """The point of {rows v <= bound} nearest to ``free`` (n,).

    Args:
        rows: (m, n), of unit length or zero; bound: (m,).
        excess: (m,) or one number, by which a row may be violated and counts as kept.

    Raises:
        NotSolved: the steps allowed are used up, which rounding alone can cause.
    """
    v = free
    active: list[int] = []
    dual: FloatArray = np.zeros(0)
    for _ in range(tol.steps * (rows.shape[0] + rows.shape[1]) + 1):
        beyond = rows @ v - bound - excess
        beyond[active] = -np.inf
        if rows.shape[0] == 0 or np.max(beyond) <= 0.0:
            return _sorted(v, active, dual, True)
        found = _activate(int(np.argmax(beyond)), rows, v, bound, active, dual, tol)
        if found is None:
            return _sorted(v, active, dual, False)
        active, dual = found
        v = _on(rows[active], bound[active], free)
    raise NotSolved("the active-set method did not end: the program's rows are too badly scaled")


def _sorted(v: FloatArray, active: list[int], dual: FloatArray, kept: bool) -> Nearest:
    order = np.argsort(active)
    return Nearest(v, tuple(active[i] for i in order), dual[order], kept)


def _activate(
    row: int, rows: FloatArray, v: FloatArray, bound: FloatArray, active: list[int],
    dual: FloatArray, tol: DualMethodTolerances,
) -> tuple[list[int], FloatArray] | None:  # fmt: skip
    """Raise the multiplier of ``row`` until it holds, dropping rows whose multipliers vanish;
    None where it cannot be made to hold."""
    active, dual, own = list(active), dual.copy(), 0.0
    while True:
        step, fall = _split(rows[row], rows[active])
        reach = float(step @ rows[row])  # squared length of what the active rows leave
        full = np.inf
        if reach > tol.dependent:
            full = max(float(rows[row] @ v - bound[row]), 0.0) / reach
        falling = np.flatnonzero(fall > 0.0)
        ratios = dual[falling] / fall[falling]
        partial = float(np.min(ratios)) if falling.size else np.inf
        length = min(full, partial)
        if not np.isfinite(length):
            return None
        if np.isfinite(full):
            v = v - length * step
        dual = np.maximum(dual - length * fall, 0.0)
        own += length
        if full <= partial:
            return [*active, row], np.append(dual, own)
        leaving = int(falling[np.argmin(ratios)])
        del active[leaving]
        dual = np.delete(dual, leaving)


def _on(active: FloatArray, bound: FloatArray, free: FloatArray) -> FloatArray:
    """The point nearest to ``free`` where the active rows hold: made anew from them, since the
    steps that led there leave their roundings, which steep multipliers enlarge."""
    orthogonal, triangular = np.linalg.qr(active.T)
    beside = free - orthogonal @ (orthogonal.T @ free)
    beside = beside - orthogonal @ (orthogonal.T @ beside)
    inside = scipy.linalg.solve_triangular(triangular, bound, trans="T")
    result: FloatArray = beside + orthogonal @ inside
    return result


def _split(row: FloatArray, active: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``row`` less its projection on the active rows, and the projection's coefficients."""
    if active.shape[0] == 0:
        return row, np.zeros(0)
    orthogonal, triangular = np.linalg.qr(active.T)
    inside = orthogonal.T @ row
    return row - orthogonal @ inside, scipy.linalg.solve_triangular(triangular, inside)
