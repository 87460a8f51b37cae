"""A quadratic program as a controller of its own: the active-set back end, bare."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.arithmetic import cast
from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Table,
)
from servogen.controllers.iteration_parts import active_set_parts
from servogen.controllers.qp_solver_check import (
    LARGEST,
    check_accept,
    check_layout,
    check_options,
    check_plant,
    check_reach,
    check_scale,
    metric,
)
from servogen.precision import FloatArray, Precision
from servogen.qp.active_set_tables import ActiveSetTables, active_set_tables
from servogen.qp.arguments import matrix
from servogen.qp.errors import ProgramError
from servogen.qp.row_tables import ColumnRows, RowTables, StageRows, column_rows


@dataclass(frozen=True)
class QpSolverDesign:
    """min 1/2 z'Hz + f'z subject to low <= A z <= high, f and the bounds given at every call.

    Attributes:
        scale: (m,) what the bounds are multiplied with: the tables' rows are A's times this.
    """

    prefix: str
    precision: Precision
    tables: ActiveSetTables
    scale: FloatArray


def design_qp_solver(
    prefix: str,
    precision: Precision,
    hessian: FloatArray,
    rows: FloatArray,
    cap: int,
    accept: float,
    per_step: int = 0,
    staying: int = 0,
    bounds: int = 0,
    inputs: int = 0,
) -> QpSolverDesign:
    """A program with any rows.

    They are scaled to unit length in the metric of H, sqrt(a'H^-1 a) = 1, so that ``accept`` is a
    distance in which the cost is measured, whatever the units of variables and rows.

    Args:
        prefix: of every name in C.
        hessian: (N, N), symmetric and positive definite; rows: (m, N), none zero.
        cap: iterations, 1 to 100000. accept: violation accepted, of scaled rows.
        bounds: so many of the first rows bound variable 0, 1, ... by itself.
        per_step, staying, inputs: see ``ColumnRows``.

    Raises:
        ProgramError: an argument cannot be used, or not with the others. Of H's eigenvalues with a
            unit diagonal the smallest must be above ``CONVEXITY`` of the largest, and what the
            largest inputs lead to must be numbers in the precision.
    """
    accept = check_options(prefix, precision, cap, accept)
    h, inverse = metric(hessian, precision)
    given = matrix("rows", rows)
    if given.shape[1] != len(h):
        raise ProgramError("rows", f"of {given.shape[1]} columns", f"{len(h)}, as H")
    if not np.all(np.any(given, axis=1)):
        i = int(np.flatnonzero(~np.any(given, axis=1))[0])
        raise ProgramError(f"rows[{i}]", "zero", "a row that holds a variable")
    check_layout((given.shape[0], len(h)), per_step, staying, bounds, inputs)
    unit = 1.0 / np.sqrt(np.diag(h))
    solved = np.linalg.solve(h * np.outer(unit, unit), (given * unit).T).T
    norm = np.sqrt(np.einsum("ij,ij->i", given * unit, solved))
    check_scale(norm, precision)
    check_accept(accept, 1.0 / norm, precision)
    written = given / norm[:, None]
    check_reach(written, inverse, precision)
    own = column_rows(written, precision.dtype, per_step, staying, bounds, inputs)
    tables = active_set_tables(h, written, own, accept, cap, precision, unit=True)
    return QpSolverDesign(prefix, precision, tables, cast(1.0 / norm, precision))


def design_plant_qp_solver(
    prefix: str,
    precision: Precision,
    hessian: FloatArray,
    rows: StageRows,
    cap: int,
    accept: float,
) -> QpSolverDesign:
    """A program whose rows are a plant's, made by ``stage_rows``; none is scaled.

    Args:
        hessian: (N, N), symmetric and positive definite.
        cap: iterations. accept: violation accepted.

    Raises:
        ProgramError: as ``design_qp_solver``.
    """
    accept = check_options(prefix, precision, cap, accept)
    h, inverse = metric(hessian, precision)
    check_plant(rows, len(h), precision)
    check_accept(accept, np.ones(1), precision)
    written = np.zeros((rows.count, rows.variables))
    for i in range(rows.count):
        own = rows.row(i)
        written[i, : own.size] = own
    check_reach(matrix("rows", written), inverse, precision)
    tables = active_set_tables(h, written, rows, accept, cap, precision)
    return QpSolverDesign(prefix, precision, tables, cast(np.ones(rows.count), precision))


def declare_qp_solver(design: QpSolverDesign) -> Declaration:
    """Names, sizes, tables and ports."""
    t, rows = design.tables, design.tables.rows
    n, m, far = rows.variables, rows.count, LARGEST[design.precision.name]
    scaled = bool(np.any(design.scale != 1.0))
    parts = active_set_parts(t, design.scale if scaled else None)
    layout, rest = _layout(rows)
    return Declaration(
        kind="qp",
        prefix=design.prefix,
        summary="Quadratic program by a dual active-set method with an updated factor",
        precision=design.precision,
        sample_time_s=0.0,
        dimensions=(
            Dimension("ROWS", m, "two-sided rows"),
            Dimension("ITERATION_CAP", t.cap, "iterations at the most"),
            *layout,
            *parts.dimensions,
        ),
        constants=(
            Constant("tolerance", float(t.accept), "violation of a bound accepted"),
            *parts.constants,
        ),
        tables=(
            *parts.tables,
            *([Table("scale", design.scale, "of the bounds")] if scaled else []),
        ),
        state=(
            *parts.state,
            *rest,
            StateField("free", "unconstrained optimum", "VARIABLES"),
            *([] if parts.facts["alone"] else [StateField("rows", "A z", "ROWS")]),
            StateField("z", "the last answer", "VARIABLES"),
            StateField("ready", "1 after reset", type="int32_t"),
        ),
        operations=(
            Operation("reset", "Forget the working set.", returns_status=False),
            Operation(
                "step",
                "Solve; at the cap or where no point keeps all rows the last answer stands.",
                inputs=(
                    Port("linear", "1", "f", size=n, low=-far, high=far),
                    Port("low", "1", "lower bounds", size=m, low=-far, high=far),
                    Port("high", "1", "upper bounds", size=m, low=-far, high=far),
                ),
                outputs=(
                    Port("z", "1", "optimum", size=n),
                    Port("iterations", "1", "0: none needed", integer=True, low=0, high=t.cap),
                ),
            ),
        ),
        facts=parts.facts,
    )


def _layout(rows: RowTables) -> tuple[tuple[Dimension, ...], tuple[StateField, ...]]:
    """What the kind of rows adds to the dimensions and to the state."""
    if isinstance(rows, StageRows):
        return (
            Dimension("ORDER", rows.order, "states of the plant behind the rows"),
            Dimension("ROWS_PER_STEP", rows.per_step, "rows of one step"),
            Dimension("TERMINAL_ROWS", rows.terminal.shape[0], "rows of the last state"),
        ), (StateField("start", "the plant behind the rows is at rest", "ORDER"),)
    assert isinstance(rows, ColumnRows)
    return (
        Dimension("ROWS_PER_STEP", rows.per_step, "rows of one step; 0: no horizon moves"),
        Dimension("TERMINAL_ROWS", rows.staying, "rows of no step"),
    ), ()
