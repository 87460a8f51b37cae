"""A quadratic program as a controller of its own: the active-set back end, bare."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Table,
)
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
    dimensions = [
        Dimension("VARIABLES", n, "N"),
        Dimension("ROWS", m, "two-sided rows"),
        Dimension("FACTOR", n * (n + 1), "L with the row that enters"),
        Dimension("VECTORS", n * n, "H^-1 a of the working set"),
        Dimension("ITERATION_CAP", t.cap, "iterations at the most"),
        Dimension("KEEP", min(t.keep, n + 1), "a working set of so many rows stays as it is"),
    ]
    tables = [
        Table("inverse", t.inverse, "H^-1"),
        Table("norm", t.norm, "square root of a'H^-1 a"),
    ]
    if isinstance(rows, StageRows):
        terminal = rows.terminal.shape[0]
        dimensions += [
            Dimension("ORDER", rows.order, "states of the plant behind the rows"),
            Dimension("STAGE_OUTPUTS", rows.stage.shape[0], "next state and further rows"),
            Dimension("LIMITED", rows.limited, "states that are rows"),
            Dimension("ROWS_PER_STEP", rows.per_step, "rows of one step"),
            Dimension("TERMINAL_ROWS", terminal, "rows of the last state"),
        ]
        responses = np.vstack([rows.impulse, rows.terminal_rows[:, ::-1]])
        tables += [
            Table("stage_columns", rows.stage.T, "one step of the plant, transposed"),
            Table("terminal_columns", rows.terminal.T, "terminal rows, transposed"),
            Table("responses", responses, "of the rows to an input, by delay"),
        ]
    else:
        assert isinstance(rows, ColumnRows)
        dimensions += [
            Dimension("ROWS_PER_STEP", rows.per_step, "rows of one step; 0: no horizon moves"),
            Dimension("TERMINAL_ROWS", rows.staying, "rows of no step"),
        ]
        tables += [
            Table("columns", rows.columns, "A, transposed"),
            Table("first", np.array(rows.first), "where a column begins", integer=True),
        ]
    return Declaration(
        kind="qp",
        prefix=design.prefix,
        summary="Quadratic program by a dual active-set method with an updated factor",
        precision=design.precision,
        sample_time_s=0.0,
        dimensions=tuple(dimensions),
        constants=(
            Constant("accept", float(t.accept), "violation of a bound accepted"),
            Constant("dependent", float(t.dependent), "of norm^2: what is left of a row is rounding"),
            Constant("falls", float(t.falls), "of its norm: a row falls with another"),
        ),
        tables=tuple(tables),
        state=(
            StateField("dual", "multipliers of the working set", "VARIABLES"),
            StateField("missed", "what its rows miss of their bounds", "VARIABLES"),
            StateField("pivots", "1 / D", "VARIABLES"),
            StateField("factor", "L", "FACTOR"),
            StateField("vectors", "H^-1 a", "VECTORS"),
            StateField("free", "unconstrained optimum", "VARIABLES"),
            StateField("rows", "A z", "ROWS"),
            StateField("z", "the last answer", "VARIABLES"),
            StateField("row", "rows of the working set", "VARIABLES", type="int32_t"),
            StateField("side", "1 upper, -1 lower", "VARIABLES", type="int32_t"),
            StateField("slot", "where their vectors are", "VARIABLES", type="int32_t"),
            StateField("size", "rows in the working set", type="int32_t"),
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
        facts={"stages": isinstance(rows, StageRows)},
    )
