"""Design of one axis's tracking MPC (16): the condensed program, its tables, its declaration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

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
from servogen.controllers.iteration_parts import IterationParts, active_set_parts, pqp_parts
from servogen.plants.statespace import Discrete, StateSpace, discretise
from servogen.precision import FloatArray, Precision
from servogen.qp.active_set_tables import ActiveSetTables, active_set_tables
from servogen.qp.condense import CondensedQp, TrackingWeights, condense
from servogen.qp.pqp import PqpTables, pqp_tables
from servogen.qp.row_tables import StageRows, stage_rows
from servogen.qp.tolerances import QpTolerances, tolerances
from servogen.sets.admissible import AdmissibleSet
from servogen.sets.constraints import AxisLimits

# A measured state further out than this share of the limits is a sensor fault, not a state: the
# stage can pass its limits between samples, but not by a factor.
POSITION_FACTOR = 1.5
RATE_FACTOR = 4.0
# States beyond the acceleration have no limit to compare with; this keeps float32 finite.
FURTHER_STATE_LIMIT = 1e12


@dataclass(frozen=True)
class SolverSettings:
    """``cap`` iterations, ``phi`` of (20), ``period`` of the acceleration cycle (0: none),
    relative ``gap_tolerance`` and ``margin``: see ``qp.tolerances``. ``method``: who iterates; the
    active set has no use for ``phi``, ``period`` and ``gap_tolerance``."""

    cap: int
    phi: float
    period: int
    gap_tolerance: float
    margin: float
    method: Literal["pqp", "active_set"] = "pqp"


@dataclass(frozen=True)
class MpcDesign:
    """One axis's tracking MPC: the program, its tables in the target precision, its plant.

    ``solver``: the tables of the method that is emitted.
    """

    prefix: str
    precision: Precision
    plant: Discrete
    limits: AxisLimits
    horizon: int
    qp: CondensedQp
    tol: QpTolerances
    solver: PqpTables | ActiveSetTables
    plan_state: FloatArray  # (n-1, N) transposed: z_unc on x'
    plan_reference: FloatArray  # (N+1, N) transposed: z_unc on r - p

    @property
    def rows(self) -> int:
        """Two-sided rows."""
        return int(self.qp.rows_command.shape[0])


def design_mpc(
    prefix: str,
    precision: Precision,
    slow: StateSpace,
    sample_time_s: float,
    horizon: int,
    weights: TrackingWeights,
    limits: AxisLimits,
    admissible: AdmissibleSet,
    solver: SolverSettings,
    inter_sample_rows: int = 0,
) -> MpcDesign:
    """Condense (16) and round its tables once to ``precision``."""
    qp = condense(slow, sample_time_s, horizon, weights, limits, admissible, inter_sample_rows)
    tol = tolerances(
        precision, solver.margin, solver.gap_tolerance, qp.hessian, limits.fast_range_m
    )
    rows = stage_rows(qp.stage, qp.stage_terminal, horizon, 3, precision.dtype)
    return MpcDesign(
        prefix=prefix,
        precision=precision,
        plant=discretise(slow, sample_time_s),
        limits=limits,
        horizon=horizon,
        qp=qp,
        tol=tol,
        solver=_solver_tables(qp, rows, solver, tol, precision),
        plan_state=cast(-np.linalg.solve(qp.hessian, qp.gradient_state).T, precision),
        plan_reference=cast(-np.linalg.solve(qp.hessian, qp.gradient_reference).T, precision),
    )


def _solver_tables(
    qp: CondensedQp, rows: StageRows, solver: SolverSettings, tol: QpTolerances,
    precision: Precision,
) -> PqpTables | ActiveSetTables:  # fmt: skip
    if solver.method == "active_set":
        return active_set_tables(
            qp.hessian, qp.rows_command, rows, tol.accept, solver.cap, precision
        )
    return pqp_tables(
        qp.hessian, qp.rows_command, rows, solver.phi, solver.period, solver.cap, tol,
        precision.dtype, qp.rows_per_step, rows.variables,
    )  # fmt: skip


def state_ports(name: str, order: int, limits: AxisLimits) -> tuple[Port, ...]:
    """The measured state as one port per component, so that each has its unit and range."""
    base = (
        ("position", "m", limits.position_m * POSITION_FACTOR),
        ("velocity", "m/s", limits.velocity_m_per_s * RATE_FACTOR),
        ("acceleration", "m/s^2", limits.acceleration_m_per_s2 * RATE_FACTOR),
    )
    ports = [
        Port(f"{name}{label}", unit, f"slow stage {label}", low=-bound, high=bound)
        for label, unit, bound in base
    ]
    for i in range(3, order):
        ports.append(
            Port(
                f"{name}state_{i}",
                f"m/s^{i}",
                f"slow stage state {i}",
                low=-FURTHER_STATE_LIMIT,
                high=FURTHER_STATE_LIMIT,
            )
        )
    return tuple(ports)


def state_bounds(order: int, limits: AxisLimits) -> FloatArray:
    """(order,) the largest magnitudes that ``state_ports`` declares. A model that runs on without a
    measurement keeps to them: it stays finite whatever it is told and however long it runs."""
    return np.array([port.high for port in state_ports("", order, limits)], dtype=np.float64)


def _iteration_parts(design: MpcDesign) -> IterationParts:
    parts = (
        active_set_parts(design.solver)
        if isinstance(design.solver, ActiveSetTables)
        else pqp_parts(design.solver, design.tol)
    )
    workspace = (
        ("relative", "REFERENCES"),
        ("start", "ORDER"),
        ("free_plan", "HORIZON"),
        ("correction", "HORIZON"),
        ("scratch_plan", "HORIZON"),
        ("below", "ROWS"),
        ("above", "ROWS"),
        ("rows", "ROWS"),
    )
    scratch = (
        StateField(name, "workspace, no meaning between calls", size) for name, size in workspace
    )
    return replace(
        parts,
        tables=(*parts.tables, Table("start_scale", 1.0 / design.qp.state_scale, "states to rows")),
        state=(*parts.state, *scratch),
    )


def declare_mpc(design: MpcDesign) -> Declaration:
    """Names, sizes, tables and ports of one axis's MPC."""
    n, horizon, m = design.plant.order, design.horizon, design.rows
    iteration = _iteration_parts(design)
    lim, tol = design.limits, design.tol
    reach = lim.position_m * POSITION_FACTOR
    state = state_ports("", n, lim)
    bounds = tuple(
        Port(
            name,
            "m",
            f"{what} bound of the position at the slow samples 1..N ahead",
            size=horizon,
            low=-reach,
            high=reach,
        )
        for name, what in (("low", "lower"), ("high", "upper"))
    )
    reference = Port(
        "reference",
        "m",
        "r_0..r_N, the points reached at the slow samples 0..N ahead",
        size=horizon + 1,
        low=-lim.position_m,
        high=lim.position_m,
    )
    command = Port(
        "command", "m", "slow stage position command for this period", low=-reach, high=reach
    )
    iterations = Port(
        "iterations",
        "1",
        "iterates evaluated; 0: none needed",
        integer=True,
        low=0,
        high=design.solver.cap,
    )
    return Declaration(
        kind="mpc",
        prefix=design.prefix,
        summary=f"Tracking MPC (16) of one axis: condensed QP (19), {iteration.told}, Corollary 1",
        precision=design.precision,
        sample_time_s=design.plant.sample_time_s,
        dimensions=(
            Dimension("ORDER", n, "states of the slow stage"),
            Dimension("HORIZON", horizon, "N"),
            Dimension("REFERENCES", horizon + 1, "r_0..r_N"),
            Dimension("ROWS", m, "two-sided rows of (19b)"),
            Dimension("ROWS_PER_STEP", design.qp.rows_per_step, "position, velocity, ..."),
            Dimension("TERMINAL_ROWS", design.qp.terminal_rows, "of (16g), not implied"),
            Dimension("ITERATION_CAP", design.solver.cap, "iterations at the most"),
            *iteration.dimensions,
        ),
        constants=(
            Constant("position_scale", 1.0 / lim.fast_range_m, "1/m: positions to rows"),
            Constant("command_limit", reach, "m: no command beyond it"),
            Constant("margin", tol.margin, "the bounds are drawn in by this share"),
            Constant("tolerance", tol.accept, "violation of the drawn-in bounds accepted"),
            *iteration.constants,
        ),
        tables=(
            Table("a_columns", design.plant.a.T, "A of (11), transposed"),
            Table("b", design.plant.b, "B of (11)"),
            Table("bound", state_bounds(n, lim), "largest state expected"),
            Table("plan_state", design.plan_state, "z_unc on (v, a, ...), transposed"),
            Table("plan_reference", design.plan_reference, "z_unc on r - p, transposed"),
            *iteration.tables,
            Table("terminal_reference", design.qp.terminal_reference, "(16g) on r_N - p"),
            Table("terminal_position", design.qp.terminal_position, "(16g) on p"),
            Table("terminal_bound", design.qp.terminal_bound, "(16g), right-hand side"),
        ),
        state=(
            StateField("plan", "commands u_0..u_{N-1}, m", "HORIZON"),
            StateField("predicted", "state expected at the next step", "ORDER", bound="bound"),
            *iteration.state,
            StateField("ready", "1 after a successful reset", type="int32_t"),
        ),
        operations=(
            Operation(
                "reset",
                "Stand still at a position: the plan commands it for ever.",
                inputs=(Port("position", "m", "where the stage stands", low=-reach, high=reach),),
            ),
            Operation(
                "seed",
                "Shift the plan and append a command (priming), a bad one not: the last repeats.",
                inputs=(Port("command", "m", "command", low=-reach, high=reach),),
            ),
            Operation(
                "candidate",
                "State at the end of the shifted plan but one, from the measured state if usable.",
                inputs=state,
                outputs=tuple(Port(p.name, p.unit, p.doc) for p in state),
                reads_only=True,
            ),
            Operation(
                "step",
                "Solve (16); at the cap without a feasible iterate, use the shifted plan.",
                inputs=(*state, reference, *bounds),
                outputs=(command, iterations),
            ),
            Operation(
                "hold",
                "No usable measurement: go on with the shifted plan, from the predicted state.",
                inputs=(Port("reference", "m", "r_N", low=-lim.position_m, high=lim.position_m),),
                outputs=(command, *(Port(p.name, p.unit, p.doc) for p in state)),
            ),
        ),
        facts={"terminal": design.qp.terminal_rows > 0, **iteration.facts},
    )
