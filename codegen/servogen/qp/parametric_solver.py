"""Small strictly convex programs solved exactly: the dual method of Goldfarb and Idnani.

It starts at the unconstrained optimum and makes one violated row active after the other; every
iterate is optimal for its active rows, so the first one that keeps all rows is the answer, and a
row that no multiplier can reach proves that there is none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.precision import FloatArray
from servogen.qp.parametric import ParametricQp
from servogen.qp.tolerances import DualMethodTolerances


@dataclass(frozen=True)
class Optimum:
    """``z`` (n,) and the multipliers ``dual`` (r,) of the rows, not negative; ``active``: the rows
    that hold with equality by the method, in ascending order. ``feasible`` False: no z keeps all
    rows, and ``z`` is the optimum of those that were active last."""

    z: FloatArray
    dual: FloatArray
    active: tuple[int, ...]
    feasible: bool


class ParametricSolver:
    """One program's factors, for many parameters."""

    def __init__(self, qp: ParametricQp, tol: DualMethodTolerances | None = None) -> None:
        self.qp = qp
        self._tol = tol or DualMethodTolerances()
        self._factor = np.linalg.cholesky(qp.H)
        rows = scipy.linalg.solve_triangular(self._factor, qp.G.T, lower=True).T
        length = np.linalg.norm(rows, axis=1)
        # a row of zeros bounds nothing: it is kept or broken by theta alone
        self._length = np.where(length > 0.0, length, 1.0)
        self._rows = rows / self._length[:, None]
        linear = scipy.linalg.solve_triangular(
            self._factor, np.column_stack([qp.F, qp.f]), lower=True
        )
        self._linear, self._offset = linear[:, :-1], linear[:, -1]

    def solve(self, theta: FloatArray) -> Optimum:
        """The optimum for one parameter (p,).

        Raises:
            RuntimeError: the steps allowed are used up.
        """
        rows = self._rows
        bound = (self.qp.w + self.qp.S @ theta) / self._length
        # v = L'z: the cost is half the squared distance from v to its unconstrained optimum.
        free: FloatArray = -(self._linear @ theta + self._offset)
        v = free
        scale = np.abs(rows) @ np.abs(v) + np.abs(bound)
        active: list[int] = []
        dual: FloatArray = np.zeros(0)
        for _ in range(self._tol.steps * (rows.shape[0] + rows.shape[1]) + 1):
            excess = rows @ v - bound - self._tol.violation * scale
            excess[active] = -np.inf
            if rows.shape[0] == 0 or np.max(excess) <= 0.0:
                return self._answer(v, active, dual, True)
            worst = int(np.argmax(excess))
            found = self._activate(worst, v, bound, active, dual)
            if found is None:
                return self._answer(v, active, dual, False)
            active, dual = found
            v = self._optimum_on(active, free, bound)
        raise RuntimeError("the active-set method did not end")

    def _activate(
        self, row: int, v: FloatArray, bound: FloatArray, active: list[int], dual: FloatArray
    ) -> tuple[list[int], FloatArray] | None:
        """Raise the multiplier of ``row`` until it holds, dropping rows whose multipliers vanish;
        None where it cannot be made to hold."""
        rows, own = self._rows, 0.0
        active, dual = list(active), dual.copy()
        while True:
            step, fall = _project(rows[row], rows[active])
            reach = float(step @ rows[row])  # squared length of what the active rows leave
            full = np.inf
            if reach > self._tol.dependent:
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

    def _optimum_on(self, active: list[int], free: FloatArray, bound: FloatArray) -> FloatArray:
        """The point nearest to ``free`` where the active rows hold: made anew from them, since the
        steps that led there leave their roundings, which steep multipliers enlarge."""
        orthogonal, triangular = np.linalg.qr(self._rows[active].T)
        beside = free - orthogonal @ (orthogonal.T @ free)
        beside = beside - orthogonal @ (orthogonal.T @ beside)
        inside = scipy.linalg.solve_triangular(triangular, bound[active], trans="T")
        result: FloatArray = beside + orthogonal @ inside
        return result

    def _answer(
        self, v: FloatArray, active: list[int], dual: FloatArray, feasible: bool
    ) -> Optimum:
        multipliers = np.zeros(self._rows.shape[0])
        multipliers[active] = dual / self._length[active]
        z = scipy.linalg.solve_triangular(self._factor, v, lower=True, trans="T")
        return Optimum(z, multipliers, tuple(sorted(active)), feasible)


def _project(row: FloatArray, active: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``row`` less its projection on the active rows, and the projection's coefficients."""
    if active.shape[0] == 0:
        return row, np.zeros(0)
    orthogonal, triangular = np.linalg.qr(active.T)
    inside = orthogonal.T @ row
    return row - orthogonal @ inside, scipy.linalg.solve_triangular(triangular, inside)
