"""A program with data that are affine in a parameter, as the active-set method meets it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from servogen.explicit.errors import ExplicitError
from servogen.plants.statespace import FloatArray, read_only
from servogen.precision import Precision
from servogen.qp.active_set_factor import WorkingSet
from servogen.qp.active_set_tables import ActiveSetTables, active_set_tables
from servogen.qp.dual_active_set import ActiveSetResult, solve
from servogen.qp.parametric import ParametricQP
from servogen.qp.row_tables import ColumnRows, StageRows, column_rows
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise


@dataclass(frozen=True)
class IterationProgram:
    """min 1/2 z'Hz + f'z subject to low <= A z + E x <= high; f, x, low, high affine in theta.

    Matrices of p + 1 columns act on (theta, 1). A bound that is not there is infinite in its last
    column.

    Attributes:
        tables: H^-1 and A as the method has them; its cap is not looked at.
        free: (N, p + 1) the optimum without rows.
        low, high: (m, p + 1) bounds of the rows.
        start: (n, p + 1) state x of the plant behind the rows; None: at rest.
        domain_rows, domain_bounds: (q, p) D and (q,) d of the set {D theta <= d}, bounded.
    """

    tables: ActiveSetTables
    free: FloatArray
    low: FloatArray
    high: FloatArray
    domain_rows: FloatArray
    domain_bounds: FloatArray
    start: FloatArray | None = None

    @property
    def parameters(self) -> int:
        """p."""
        return int(self.free.shape[1]) - 1

    def rows(self) -> FloatArray:
        """A (m, N) in float64, its numbers those of the tables."""
        return _written(self.tables)[0]

    def sizes(self) -> tuple[FloatArray, FloatArray]:
        """(m, N) and (m, n): on |z| and on |x|, the sizes of the terms that rows are summed of."""
        return _written(self.tables, np.abs)

    def rows_at_free(self) -> FloatArray:
        """(m, p + 1) the rows at the optimum without rows."""
        on_variables, on_start = _written(self.tables)
        result: FloatArray = on_variables @ self.free
        return result if self.start is None else result + on_start @ self.start

    def solve(self, theta: FloatArray, work: WorkingSet, cap: int) -> ActiveSetResult:
        """One call of the method itself, in the tables' precision, with another cap."""
        tables = replace(self.tables, cap=cap)
        given = np.append(theta, 1.0)

        def at(on_theta: FloatArray) -> FloatArray:
            linear: FloatArray = on_theta[:, :-1] @ theta
            result: FloatArray = (linear + on_theta[:, -1]).astype(tables.inverse.dtype)
            return result

        start = None if self.start is None else (self.start @ given).astype(tables.inverse.dtype)
        return solve(tables, work, at(self.free), at(self.low), at(self.high), start)

    def box(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest theta, (p,) each, over the set.

        Raises:
            ExplicitError: the set is empty or unbounded.
        """
        try:
            reach = [
                maximise(self.domain_rows, self.domain_bounds, sign * unit).value
                for sign in (-1.0, 1.0)
                for unit in np.eye(self.parameters)
            ]
        except SetError as error:
            raise ExplicitError("domain", None, "a bounded set with a point in it") from error
        if not np.all(np.isfinite(reach)):
            raise ExplicitError("domain", "unbounded", "a bounded set of parameters")
        low, high = np.split(np.array(reach), 2)
        return read_only(-low), read_only(high)


def iteration_program(
    qp: ParametricQP, precision: Precision, cap: int, accept: float
) -> IterationProgram:
    """A ``ParametricQP`` as ``design_qp_solver`` would have its rows: of unit length in the metric
    of H. Rows of G have an upper side alone; of bounds of variables both sides are one row.

    Raises:
        ExplicitError: a program without rows.
    """
    n, p = qp.variables, qp.parameters
    bounded = np.flatnonzero(np.isfinite(qp.upper) | np.isfinite(qp.lower))
    written = np.vstack([qp.rows, np.eye(n)[bounded]])
    if not written.shape[0]:
        raise ExplicitError("rows", 0, "at least one: without rows nothing is iterated")
    norm = np.sqrt(np.einsum("ij,ij->i", written, np.linalg.solve(qp.hessian, written.T).T))
    rows = written / norm[:, None]
    low, high = np.zeros((rows.shape[0], p + 1)), np.zeros((rows.shape[0], p + 1))
    m = qp.rows.shape[0]
    high[:m] = np.column_stack([qp.bounds_parameter, qp.bounds])
    low[:m, p] = -np.inf
    high[m:, p], low[m:, p] = qp.upper[bounded], qp.lower[bounded]
    on_theta, constant = qp.unconstrained()
    tables = active_set_tables(
        qp.hessian, rows, column_rows(rows, precision.dtype), accept, cap, precision,
        unit=True,
    )  # fmt: skip
    return IterationProgram(
        tables=tables,
        free=np.column_stack([on_theta, constant]),
        low=low / norm[:, None],
        high=high / norm[:, None],
        domain_rows=qp.domain_rows,
        domain_bounds=qp.domain_bounds,
    )


def _written(
    tables: ActiveSetTables, of: Callable[[FloatArray], FloatArray] = np.asarray
) -> tuple[FloatArray, FloatArray]:
    """A (m, N), and E (m, n) of the plant behind it (n = 0 without), in float64; ``of`` is applied
    to the tables."""
    rows = tables.rows
    assert isinstance(rows, StageRows | ColumnRows)
    numbers: dict[str, Any] = {one.name: getattr(rows, one.name) for one in fields(rows)}
    wide = {k: of(v.astype(np.float64)) for k, v in numbers.items() if isinstance(v, np.ndarray)}
    exact: StageRows | ColumnRows = replace(rows, **{**numbers, **wide})
    on_variables = np.array([exact.product(unit) for unit in np.eye(exact.variables)]).T
    if isinstance(exact, ColumnRows):
        return on_variables, np.zeros((exact.count, 0))
    still = np.zeros(exact.variables)
    on_start = np.array([exact.product(still, unit) for unit in np.eye(exact.order)]).T
    return on_variables, on_start
