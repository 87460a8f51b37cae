"""A quadratic program as a controller of its own: the active-set back end, bare."""

from __future__ import annotations

from dataclasses import dataclass

from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
)
from servogen.controllers.iteration_parts import active_set_parts
from servogen.precision import Precision
from servogen.qp.dual_active_set import ActiveSetTables
from servogen.qp.row_tables import ColumnRows, StageRows


@dataclass(frozen=True)
class QpSolverDesign:
    """min 1/2 z'Hz + f'z subject to low <= A z <= high, f and the bounds given at every call.

    Attributes:
        largest: no input is beyond it; a bound that is not there is this far out.
    """

    prefix: str
    precision: Precision
    tables: ActiveSetTables
    largest: float


def declare_qp_solver(design: QpSolverDesign) -> Declaration:
    """Names, sizes, tables and ports."""
    t, rows = design.tables, design.tables.rows
    n, m, far = rows.variables, rows.count, design.largest
    parts = active_set_parts(t)
    rest: tuple[StateField, ...] = ()
    if isinstance(rows, StageRows):
        rest = (StateField("start", "the plant behind the rows is at rest", "ORDER"),)
        layout: tuple[Dimension, ...] = (
            Dimension("ORDER", rows.order, "states of the plant behind the rows"),
            Dimension("ROWS_PER_STEP", rows.per_step, "rows of one step"),
            Dimension("TERMINAL_ROWS", rows.terminal.shape[0], "rows of the last state"),
        )
    else:
        assert isinstance(rows, ColumnRows)
        layout = (
            Dimension("ROWS_PER_STEP", rows.per_step, "rows of one step; 0: no horizon moves"),
            Dimension("TERMINAL_ROWS", rows.staying, "rows of no step"),
        )
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
        tables=parts.tables,
        state=(
            *parts.state,
            *rest,
            StateField("free", "unconstrained optimum", "VARIABLES"),
            StateField("rows", "A z", "ROWS"),
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
