"""What a controller declares for the iteration that solves its quadratic program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from servogen.controllers.design import Constant, Dimension, StateField, Table
from servogen.precision import FloatArray
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.qp.pqp import PqpTables
from servogen.qp.row_tables import ColumnRows, StageRows
from servogen.qp.tolerances import QpTolerances

# Of every output, where its coefficients that are not zero are, and of what; -1: one.
Terms = list[list[tuple[int, str]]]
_SCRATCH = "workspace, no meaning between calls"


@dataclass(frozen=True)
class IterationParts:
    """Parts of a ``Declaration``; ``told`` names the method."""

    told: str
    dimensions: tuple[Dimension, ...] = ()
    constants: tuple[Constant, ...] = ()
    tables: tuple[Table, ...] = ()
    state: tuple[StateField, ...] = ()
    facts: Mapping[str, object] = field(default_factory=dict)


def pqp_parts(pqp: PqpTables, tol: QpTolerances) -> IterationParts:
    """Of PQP (20)-(21) on the condensed program of a tracking MPC."""
    rows, (lines, m) = pqp.rows, pqp.columns.shape
    assert isinstance(rows, StageRows)
    assert rows.inputs == 1
    assert rows.bounds.size + rows.outer.size == 0
    filled, stride = 4 * -(-lines // 4), 4 * -(-m // 4)
    columns = np.pad(pqp.columns, ((0, filled - lines), (0, stride - m)))
    plant = _plant(rows)
    return IterationParts(
        told="PQP (20)-(21)",
        dimensions=(
            Dimension("VARIABLES", rows.variables, "of the program"),
            Dimension("STRIDE", stride, "ROWS, filled up to a multiple of four"),
            Dimension("LINES", filled, "columns of the bound on |D|, filled up likewise"),
            Dimension("BLOCKS", pqp.blocks, "of four steps whose rows share columns"),
            *plant.dimensions,
            Dimension("PERIOD", pqp.period, "turns of an acceleration cycle"),
        ),
        constants=(
            Constant("gap_limit", tol.gap, "duality gap accepted"),
            Constant("clamp", tol.clamp, "share of a dual an extrapolation must keep"),
            Constant("room", 1.0 - tol.clamp, "share it may take"),
            Constant("least_step", float(pqp.least_step), "less than any two duals differ"),
            Constant("least_curvature", float(pqp.least_curvature), "of a line search"),
            Constant("longest", float(pqp.longest), "line search"),
            Constant("weight", tol.weight, "share of the largest dual that counts"),
        ),
        tables=(
            *plant.tables,
            Table("inverse", pqp.inverse, "H^-1"),
            Table("columns", columns, "bound on |D|, D = A H^-1 A'"),
            Table("at_floor", np.pad(pqp.at_floor, (0, stride - m)), "what it gives at 2 floor"),
            Table("root_diagonal", pqp.root_diagonal, "of D_ii: weight of a row in its column"),
            Table("diagonal", pqp.diagonal, "D_ii"),
            Table("inverse_diagonal", pqp.inverse_diagonal, "1 / D_ii"),
            Table("phi_diagonal", pqp.phi_diagonal, "phi D_ii of (20)"),
            Table("floor", pqp.floor, "smallest dual of a warm start"),
            Table("vanish", pqp.vanish, "smallest dual"),
            Table("ceiling", pqp.ceiling, "largest dual"),
        ),
        state=(
            StateField("upper", "duals of the upper sides", "ROWS"),
            StateField("lower", "duals of the lower sides", "ROWS"),
            *(
                StateField(name, _SCRATCH, size)
                for name, size in (
                    ("slack_upper", "ROWS"),
                    ("slack_lower", "ROWS"),
                    ("change", "ROWS"),
                    ("absolute_sum", "STRIDE"),
                    ("shared", "LINES"),
                    ("scratch", "ROWS"),
                    ("last_upper", "ROWS"),
                    ("last_lower", "ROWS"),
                    ("last_change", "ROWS"),
                )
            ),
        ),
        facts={
            **plant.facts,
            "active_set": False,
            "period": pqp.coordinates,
            "extrapolates": pqp.extrapolates,
        },
    )


def active_set_parts(tables: ActiveSetTables, scale: FloatArray | None = None) -> IterationParts:
    """Of the dual active-set method on rows of either kind.

    The host declares the constant ``tolerance`` (``accept``), ROWS, ITERATION_CAP, ROWS_PER_STEP,
    TERMINAL_ROWS and, with rows of a plant, ORDER; and the state ``waited``, where the tables say
    that a call can be gone on with: above zero, the last one is. ``scale``: of a table of that name
    that it declares too, which the bounds it hands over are to be multiplied with; None: with
    nothing.
    """
    rows = tables.rows
    n = rows.variables
    inverse = -(tables.inverse[np.tril_indices(n)] if tables.triangle else tables.inverse)
    assert isinstance(rows, StageRows | ColumnRows)
    own = _stages(rows) if isinstance(rows, StageRows) else _columns(rows, scale)
    # of no more rows than variables none is left to enter a full set, and no line of it is needed
    last = n if rows.count > n else max(n - 1, 1)
    return IterationParts(
        told="dual active-set method",
        dimensions=(
            Dimension("VARIABLES", n, "of the program"),
            Dimension(
                "FACTOR", last * (last + 1) // 2, "L of the working set, and the row that enters"
            ),
            *([Dimension("VECTORS", n * n, "-H^-1 a of the working set")] if tables.stores else []),
            Dimension("KEEP", tables.keep, "a working set of so many rows stays as it is"),
            *own.dimensions,
        ),
        constants=(
            Constant("dependent", float(tables.dependent), "of a'H^-1 a: pivots that are rounding"),
            Constant("rounding", float(tables.rounding), "the same where there is no other way"),
            Constant("doubt", float(tables.doubt), "squared reaches: points so far away are none"),
            Constant("falls", float(tables.falls), "of its norm: a row falls with another one"),
            Constant("large", float(tables.large), "bound of what the iteration works with"),
            Constant("small", float(tables.small), "bound of what it divides by"),
        ),
        tables=(
            Table("minus_inverse", inverse, "-H^-1: the unconstrained optimum on f"),
            *own.tables,
        ),
        state=(
            StateField("dual", "multipliers of the working set", "VARIABLES"),
            StateField("missed", "what its rows miss of their bounds", "VARIABLES"),
            StateField("pivots", "1 / D", "VARIABLES"),
            *([] if tables.unit else [StateField("square", "a'H^-1 a", "VARIABLES")]),
            StateField("factor", "L below its diagonal, line after line", "FACTOR"),
            *([StateField("vectors", "-H^-1 a", "VECTORS")] if tables.stores else []),
            StateField("row", "rows of the working set", "VARIABLES", type="int32_t"),
            StateField("side", "1 upper, -1 lower", "VARIABLES", type="int32_t"),
            *(
                [StateField("slot", "where their vectors are", "VARIABLES", type="int32_t")]
                if tables.stores
                else []
            ),
            StateField("size", "rows in the working set", type="int32_t"),
            *(
                [
                    StateField("pending", "1: the row after them is to enter", type="int32_t"),
                    StateField("refining", "as it was at the cap", type="int32_t"),
                    StateField("forced", "likewise", type="int32_t"),
                    StateField("stalled", "likewise", type="int32_t"),
                ]
                if tables.resumes
                else []
            ),
        ),
        facts={
            "active_set": True,
            "scaled": scale is not None,
            "stores": tables.stores,
            "triangle": tables.triangle,
            "unit": tables.unit,
            "last": last,
            "resumes": tables.resumes,
            **own.facts,
        },
    )


def _stages(rows: StageRows) -> IterationParts:
    responses = np.vstack([rows.impulse, rows.terminal_rows])
    plant = _plant(rows)
    return replace(
        plant,
        tables=(
            *plant.tables,
            Table("responses", responses, "of the rows to the inputs before, from the last one on"),
            Table("bound_factors", rows.bounds, "of the variables, as rows"),
        ),
    )


def _plant(rows: StageRows) -> IterationParts:
    """What it takes to run the plant, forwards and backwards."""
    n = rows.order
    coefficients: list[float] = []

    def terms(matrix: FloatArray, state: str) -> Terms:
        found = []
        names = [f"{state}{j}" for j in range(n)] + [f"u{j}" for j in range(rows.inputs)]
        for line in matrix.astype(np.float64):
            own = []
            for value, name in zip(line, names, strict=True):
                if value == 1.0:
                    own.append((-1, name))
                elif value != 0.0:
                    own.append((len(coefficients), name))
                    coefficients.append(float(value))
            found.append(own)
        return found

    bounds = terms(np.hstack([np.zeros((rows.bounds.size, n)), _diagonal(rows)]), "x")
    plant = {
        "bounds": bounds,
        "stage": terms(rows.stage, "x"),
        "inner": terms(rows.inner, "x"),
        "outer": terms(rows.outer, "y"),
    }
    return IterationParts(
        told="",
        dimensions=(
            Dimension("STEPS", rows.steps, "of the horizon"),
            Dimension("INPUTS", rows.inputs, "variables of one step"),
            Dimension("BOUNDS", rows.bounds.size, "rows of a step that are its variables"),
            Dimension("LIMITED", rows.limited, "states that are rows"),
        ),
        tables=(
            Table("plant", np.array(coefficients), "one step of the plant behind A, line by line"),
            Table("terminal_columns", rows.terminal.T, "terminal rows, transposed"),
        ),
        facts={
            "stages": True,
            "alone": False,
            "plant": plant,
            "backwards": _backwards(rows, plant),
        },
    )


def _backwards(rows: StageRows, plant: Mapping[str, Terms]) -> Terms:
    """The lines of the states and rows inside a step, by what their coefficients multiply."""
    names = [f"x{j}" for j in range(rows.order)] + [f"u{j}" for j in range(rows.inputs)]
    lines = plant["stage"] + plant["inner"]
    return [
        [(at, f"w{o}") for o, line in enumerate(lines) for at, name in line if name == wanted]
        for wanted in names
    ]


def _diagonal(rows: StageRows) -> FloatArray:
    """(bounds, inputs)."""
    wide = np.zeros((rows.bounds.size, rows.inputs))
    np.fill_diagonal(wide, rows.bounds)
    return wide


def _columns(rows: ColumnRows, scale: FloatArray | None) -> IterationParts:
    n, dense = rows.columns.shape
    # a bound of one variable by itself, z_i <= b, is scaled as its row is
    shared = scale is not None and np.array_equal(rows.bounds, scale[: rows.bounds.size])
    starts = [*range(0, n - n % 4, 4), *range(n - n % 4, n)]
    ends = [*starts[1:], n]
    # four columns side by side share one pass over the rows, from the first one's beginning on
    packed = [
        rows.columns[start:end, rows.first[start] :].ravel()
        for start, end in zip(starts, ends, strict=True)
    ]
    first = np.array([rows.first[start] for start in starts])
    return IterationParts(
        told="",
        dimensions=(
            Dimension("BOUNDS", rows.bounds.size, "rows that are variables, the first ones"),
            Dimension("OTHERS", dense, "rows that are not"),
            Dimension("INPUTS", rows.inputs, "variables of one step"),
        ),
        tables=(
            Table("columns", np.concatenate(packed), "their columns, four at a time"),
            *([Table("first", first, "where these begin", integer=True)] if dense else []),
            *([] if shared else [Table("bound_factors", rows.bounds, "of the variables, as rows")]),
        ),
        facts={
            "stages": False,
            "alone": dense == 0,
            "first": [int(i) for i in first],
            "factors": "scale" if shared else "bound_factors",
        },
    )
