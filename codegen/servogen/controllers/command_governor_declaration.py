"""What the extended command governor declares: of one axis, and of both together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servogen.controllers.command_governor_design import AxisGovernorDesign, CommandGovernorDesign
from servogen.controllers.command_governor_program import GovernorProgram
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
from servogen.controllers.mpc_design import POSITION_FACTOR, state_bounds, state_ports

AXES = ("x", "y")
_SCRATCH = "workspace, no meaning between calls"
# Intervals whose stroke bounds a row of a period: none, the period, that and the next one.
NO_STROKE, OWN, ENDS = 0, 1, 2


def _interval_ports(design: AxisGovernorDesign, names: tuple[str, str], doc: str) -> list[Port]:
    # a stroke beyond any point of the path, and what rounding may add
    reach = design.reach.position_m * POSITION_FACTOR + 2.0 * design.program.scale_m
    return [
        Port(name, "m", f"{which} {doc}", size=design.intervals, low=-reach, high=reach)
        for name, which in zip(names, ("least", "greatest"), strict=True)
    ]


def _layout_tables(program: GovernorProgram) -> tuple[Table, ...]:
    """What bounds the rows, once for all periods: ``NO_STROKE``, ``ENDS`` or ``OWN``."""
    per_step, stages = program.rows.per_step, program.rows.stages
    first, second = program.first[:per_step], program.second[:per_step]
    stroke = np.where(first < 0, NO_STROKE, np.where(first == second, OWN, ENDS))
    held = np.where(program.first[stages:] < 0, NO_STROKE, OWN)
    return (
        Table("step_limit", program.limit[:per_step], "of the rows of a period"),
        Table("step_moves", program.position[:per_step], "1: moves with the position", True),
        Table("step_stroke", stroke, "1: of its period, 2: of the next one too", integer=True),
        Table("end_limit", program.limit[stages:], "of the rows after the last period"),
        Table("end_moves", program.position[stages:], "1: moves with the position", integer=True),
        Table("end_stroke", held, "1: of all that follows", integer=True),
    )


def declare_axis_governor(design: AxisGovernorDesign) -> Declaration:
    """Names, sizes, tables and ports of one axis."""
    n, program, tol = design.plant.order, design.program, design.tol
    variables, m, reach = program.variables, program.rows.count, design.reach
    far = reach.position_m * POSITION_FACTOR
    iteration = active_set_parts(design.solver)
    state = state_ports("", n, reach)
    command = Port("command", "m", "command of this period", low=-far, high=far)
    reference = Port(
        "reference", "m", "r(0), ..., r(n) of (21)", size=variables, low=-far, high=far
    )
    iterations = Port(
        "iterations", "1", "0: none needed", integer=True, low=0, high=design.solver.cap
    )
    standing = Port(
        "standing", "1", "1: at the end of its plan, which stays", integer=True, low=0, high=1
    )
    scratch = (
        ("relative", "VARIABLES"),
        ("start", "STATES"),
        ("free_plan", "VARIABLES"),
        ("below", "ROWS"),
        ("above", "ROWS"),
        ("rows", "ROWS"),
    )
    return Declaration(
        kind="command_governor_axis",
        prefix=design.prefix,
        summary=f"Extended command governor (17) of one axis: {iteration.told}, property (b)",
        precision=design.precision,
        sample_time_s=design.plant.sample_time_s,
        dimensions=(
            Dimension("PLANT_ORDER", n, "states of the slow stage"),
            Dimension("ORDER", n + 1, "states behind the rows: and the command held"),
            Dimension("STATES", n + 1, "the same"),
            Dimension("INTERVALS", design.intervals, "periods of the plan, and all that follows"),
            Dimension("ROWS", m, "two-sided rows"),
            Dimension("ROWS_PER_STEP", program.rows.per_step, "rows of one period"),
            Dimension("TERMINAL_ROWS", m - program.rows.stages, "rows after the last period"),
            Dimension("ITERATION_CAP", design.solver.cap, "iterations at the most"),
            Dimension("PATIENCE", design.patience, "periods at rest and at the cap"),
            *iteration.dimensions,
        ),
        constants=(
            Constant("position_scale", 1.0 / program.scale_m, "1/m: positions to rows"),
            Constant("unit", program.scale_m, "m: rows to positions"),
            Constant("centre", program.centre_m, "m: middle of the position range"),
            Constant("in_reach", design.in_reach, "share of it in which a point is in reach"),
            Constant("farthest", design.farthest, "shares: no two positions are so far apart"),
            Constant("settle", float(program.settle[-1]), "share by which it is shorter for rho"),
            Constant("standing", design.standing_m, "m: so near to a place is at it"),
            Constant("command_limit", far, "m: no command beyond it"),
            Constant("margin", tol.margin, "the bounds are drawn in by this share"),
            Constant("tolerance", tol.accept, "violation of the drawn-in bounds accepted"),
            *iteration.constants,
        ),
        tables=(
            Table("a_columns", design.plant.a.T, "A of the stage over a period, transposed"),
            Table("b", design.plant.b, "B of it"),
            Table("bound", state_bounds(n, reach), "largest state expected"),
            Table("start_scale", 1.0 / program.state_scale, "states to rows"),
            *iteration.tables,
            *_layout_tables(program),
        ),
        state=(
            StateField("plan", "commands v(0), ..., v(n-1), rho, m", "VARIABLES"),
            StateField("predicted", "state expected at the next step", "PLANT_ORDER", "", "bound"),
            *iteration.state,
            StateField("waited", "periods in a row at rest and at the cap", type="int32_t"),
            *(StateField(f, "workspace, no meaning between calls", size) for f, size in scratch),
            StateField("ready", "1 after a successful reset", type="int32_t"),
        ),
        operations=(
            Operation(
                "reset",
                "Stand still at a position: the plan commands it for ever.",
                inputs=(Port("position", "m", "where the stage stands", low=-far, high=far),),
            ),
            Operation(
                "foresee",
                "Points within the stroke of the moved plan in every interval.",
                inputs=state,
                outputs=tuple(
                    replace(port, low=None, high=None)
                    for port in _interval_ports(design, ("least", "greatest"), "point in reach")
                ),
            ),
            Operation(
                "step",
                "Solve (17); where no optimum is found use the moved plan.",
                inputs=(
                    *state,
                    reference,
                    *_interval_ports(design, ("low", "high"), "position of an interval"),
                ),
                outputs=(command, iterations, standing),
            ),
            Operation(
                "predict",
                "State at the next sample, under the command of this period.",
                inputs=state,
                outputs=tuple(Port(port.name, port.unit, port.doc) for port in state),
                reads_only=True,
            ),
        ),
        facts=iteration.facts,
    )


def path_ports(design: CommandGovernorDesign) -> tuple[Port, ...]:
    """The next points of the path and of its reference, and how many are valid."""
    ports = [
        Port(
            f"{name}_{axis}",
            "m",
            f"{doc}, {axis}; those beyond n_points are not read",
            size=design.window,
            low=-part.reach.position_m * POSITION_FACTOR,
            high=part.reach.position_m * POSITION_FACTOR,
        )
        for name, doc in (("points", "points after the last one machined"), ("slow", "(19)"))
        for axis, part in zip(AXES, design.axes, strict=True)
    ]
    count = Port("n_points", "1", "valid points", integer=True, low=0, high=design.window)
    return (*ports, count)


def declare_command_governor(design: CommandGovernorDesign) -> Declaration:
    """Names, sizes and ports of both axes together."""
    n, first = design.axes[0].plant.order, design.axes[0]
    both = list(zip(AXES, design.axes, strict=True))
    states = tuple(p for axis, part in both for p in state_ports(f"{axis}_", n, part.reach))
    window = path_ports(design)
    starts = tuple(
        Port(f"position_{axis}", "m", "first point, where the stage stands", low=-far, high=far)
        for axis, far in ((a, part.reach.position_m * POSITION_FACTOR) for a, part in both)
    )
    outputs = [
        Port(
            "points_taken", "1", "machined in this period", integer=True, low=0, high=design.points
        )
    ]
    for axis, part in both:
        far = part.reach.position_m * POSITION_FACTOR
        cap = part.solver.cap
        outputs += [
            Port(f"command_{axis}", "m", "command of this period", low=-far, high=far),
            Port(f"status_{axis}", "1", "of the axis", integer=True),
            Port(f"iterations_{axis}", "1", "of the axis", integer=True, low=0, high=cap),
        ]
    return Declaration(
        kind="command_governor",
        prefix=design.prefix,
        summary="Extended command governor (17)-(18), (21), both axes",
        precision=design.precision,
        sample_time_s=first.plant.sample_time_s,
        dimensions=(
            Dimension("ORDER", n, "states of a slow stage"),
            Dimension("POINTS", design.points, "M, points per period at the most"),
            Dimension("WINDOW", design.window, "points ahead that a plan looks at"),
            Dimension("INTERVALS", first.intervals, "periods of the plan, and all that follows"),
            Dimension("VARIABLES", first.program.variables, "commands of the plan"),
            Dimension("ROUNDS", 2 * first.program.variables, "turns of the planning"),
        ),
        constants=(
            *(
                Constant(f"stroke_{axis}", part.program.stroke_m, f"m: fast range used, {axis}")
                for axis, part in both
            ),
            *(
                Constant(f"limit_{axis}", part.reach.position_m * POSITION_FACTOR, "m: of points")
                for axis, part in both
            ),
            *(
                Constant(
                    f"centre_{axis}", part.program.centre_m, f"m: middle of the range of {axis}"
                )
                for axis, part in both
            ),
        ),
        tables=(),
        state=(
            *(StateField(f"last_{axis}", "the last point machined, m") for axis in AXES),
            *(StateField(f"home_{axis}", "its reference, m") for axis in AXES),
            StateField(
                "planned", "points machined at the start of an interval", "INTERVALS", "int32_t"
            ),
            *(StateField(axis, "of the axis", type=part.prefix) for axis, part in both),
            StateField("indices", f"{_SCRATCH}: the new ones", "INTERVALS", "int32_t"),
            StateField(
                "parts",
                f"{_SCRATCH}: intervals before which points were taken",
                "INTERVALS",
                "int32_t",
            ),
            *(
                StateField(f"{end}_{axis}", f"{_SCRATCH}: in reach {doc}", "INTERVALS")
                for axis in AXES
                for end, doc in (
                    ("least", "in an interval"),
                    ("greatest", "in an interval"),
                    ("least_on", "from one on"),
                    ("greatest_on", "from one on"),
                )
            ),
            StateField(
                "lost", "1 where the tool waits for the stages to come back", type="int32_t"
            ),
            StateField("ready", "1 after a successful reset", type="int32_t"),
        ),
        operations=(
            Operation("reset", "Stand still at the first point.", inputs=starts),
            Operation(
                "predict",
                "States at the next sample: plan from them while this period lasts.",
                inputs=states,
                outputs=tuple(Port(port.name, port.unit, port.doc) for port in states),
                reads_only=True,
                period_s=first.plant.sample_time_s,
            ),
            Operation(
                "step",
                "Plan from the state at a sample: the commands and points of the period it begins.",
                inputs=(*states, *window),
                outputs=tuple(outputs),
                period_s=first.plant.sample_time_s,
            ),
        ),
        uses=tuple(dict.fromkeys(part.prefix for part in design.axes)),
        facts={
            "after": design.after,
            "axes": {axis: part.prefix for axis, part in both},
            "measured": {axis: state_ports(f"{axis}_", n, part.reach) for axis, part in both},
            "checked": tuple(port for port in window if not port.size),
        },
    )


def declare_governor_parts(design: CommandGovernorDesign) -> tuple[Declaration, ...]:
    """Declarations of the axes, once where both are the same one, and of the governor."""
    parts = {part.prefix: part for part in design.axes}
    own = tuple(declare_axis_governor(part) for part in parts.values())
    return (*own, declare_command_governor(design))
