"""Small strictly convex programs solved exactly, for one parameter after the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.precision import FloatArray
from servogen.qp.nearest import nearest
from servogen.qp.parametric import ParametricQP
from servogen.qp.tolerances import DualMethodTolerances


@dataclass(frozen=True)
class Optimum:
    """``z`` (n,) and the multipliers ``dual`` (r,) of all rows (``ParametricQP.all_rows``), not
    negative; ``active``: those that hold with equality by the method, in ascending order.
    ``feasible`` False: no z keeps all rows (but see ``Nearest.kept`` for those at tiny angles), and
    ``z`` is the optimum of those that were active last; or the parameter is outside the domain."""

    z: FloatArray
    dual: FloatArray
    active: tuple[int, ...]
    feasible: bool


class ParametricSolver:
    """One program's factors, for many parameters."""

    def __init__(self, qp: ParametricQP, tol: DualMethodTolerances | None = None) -> None:
        self.qp = qp
        self._tol = tol or DualMethodTolerances()
        self.rows, self._w, self._s, _ = qp.all_rows()
        self._factor = np.linalg.cholesky(qp.hessian)
        rows = scipy.linalg.solve_triangular(self._factor, self.rows.T, lower=True).T
        length = np.linalg.norm(rows, axis=1)
        # a row of zeros bounds nothing: it is kept or broken by theta alone
        self._length = np.where(length > 0.0, length, 1.0)
        self._rows = rows / self._length[:, None]
        linear = scipy.linalg.solve_triangular(
            self._factor, np.column_stack([qp.linear, qp.constant]), lower=True
        )
        self._linear, self._offset = linear[:, :-1], linear[:, -1]

    def solve(self, theta: FloatArray) -> Optimum:
        """The optimum for one parameter (p,).

        Raises:
            NotSolved: the steps allowed are used up, which rounding alone can cause.
        """
        rows = self._rows
        bound = (self._w + self._s @ theta) / self._length
        # v = L'z: the cost is half the squared distance from v to its unconstrained optimum.
        free: FloatArray = -(self._linear @ theta + self._offset)
        scale = np.abs(rows) @ np.abs(free) + np.abs(bound)
        found = nearest(rows, bound, free, self._tol.violation * scale, self._tol)
        multipliers = np.zeros(rows.shape[0])
        active = list(found.active)
        multipliers[active] = found.multipliers / self._length[active]
        z = scipy.linalg.solve_triangular(self._factor, found.v, lower=True, trans="T")
        return Optimum(z, multipliers, found.active, found.kept and self._in_domain(theta))

    def _in_domain(self, theta: FloatArray) -> bool:
        rows, bounds = self.qp.domain_rows, self.qp.domain_bounds
        scale = np.abs(rows) @ np.abs(theta) + np.abs(bounds)
        return bool(np.all(rows @ theta - bounds <= self._tol.violation * scale))
