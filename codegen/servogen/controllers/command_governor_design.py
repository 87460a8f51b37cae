"""Extended command governor (17)-(18) for a slow stage in two axes: design and declaration.

Every slow period the plan of the last one is moved on by a period and foreseen from the measured
state; that says which points of the path each coming period can machine (``command_governor_path``)
and with them the stroke bounds S_k and the references (21). Then each axis solves its program.
Where that ends at its cap, the moved plan itself is used: the shifted register with the same rho,
which keeps every bound because it is what they were made from.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from servogen.controllers.arithmetic import cast
from servogen.controllers.command_governor_program import (
    GovernorProgram,
    GovernorWeights,
    governor_program,
)
from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Table,
)
from servogen.controllers.errors import DesignError
from servogen.controllers.iteration_parts import active_set_parts
from servogen.controllers.mpc_design import POSITION_FACTOR, state_bounds, state_ports
from servogen.plants.statespace import Discrete, StateSpace, discretise
from servogen.precision import FloatArray, Precision
from servogen.qp.active_set_tables import ActiveSetTables, active_set_tables
from servogen.qp.tolerances import QpTolerances, tolerances
from servogen.sets.constraints import AxisLimits
from servogen.sets.extended import ExtendedSet

AXES = ("x", "y")
_SCRATCH = "workspace, no meaning between calls"


@dataclass(frozen=True)
class GovernorSettings:
    """What the paper leaves to the user, of both axes.

    Attributes:
        weights: Q-bar and R-bar of (17).
        cap: iterations of an axis in a period. margin: share of every bound kept in reserve.
        sub_step_stroke: the stroke holds at the N instants of a period, not at its ends alone.
        stroke_margin_m: the stroke is shorter by so much.
        after: the reference is the first point after those machined in a period, index l + 1 of
            (21); False: the first one machined in it, index l.
    """

    weights: GovernorWeights = field(default_factory=GovernorWeights)
    cap: int = 150
    margin: float = 1e-6
    sub_step_stroke: bool = False
    stroke_margin_m: float = 0.0
    after: bool = True


@dataclass(frozen=True)
class AxisGovernorDesign:
    """One axis: its program, the tables of its solver in the target precision, its plant.

    ``reach``: position limits of the ports, about zero.
    """

    prefix: str
    precision: Precision
    plant: Discrete
    program: GovernorProgram
    tol: QpTolerances
    solver: ActiveSetTables
    reach: AxisLimits

    @property
    def horizon(self) -> int:
        """n, periods of the register."""
        return self.program.variables - 1

    @property
    def intervals(self) -> int:
        """n + 2: those of the plan, and all that follows."""
        return self.program.variables + 1


@dataclass(frozen=True)
class CommandGovernorDesign:
    """Both axes; ``points`` M per period at the most, ``after`` as in ``GovernorSettings``."""

    prefix: str
    precision: Precision
    axes: tuple[AxisGovernorDesign, AxisGovernorDesign]
    points: int
    after: bool

    @property
    def window(self) -> int:
        """Points ahead that a plan can use: M in each of its n + 1 periods, and the one after."""
        return self.axes[0].program.variables * self.points + 1


def design_axis_governor(
    prefix: str,
    precision: Precision,
    slow: StateSpace,
    admissible: ExtendedSet,
    settings: GovernorSettings,
) -> AxisGovernorDesign:
    """The program of one axis, its tables rounded once to ``precision``.

    Raises:
        DesignError: see ``governor_program``.
    """
    program = governor_program(
        slow, admissible, settings.weights, settings.sub_step_stroke, settings.stroke_margin_m,
        precision.dtype,
    )  # fmt: skip
    tol = tolerances(precision, settings.margin, 0.0, program.hessian, program.scale_m)
    half = admissible.limits
    return AxisGovernorDesign(
        prefix=prefix,
        precision=precision,
        plant=discretise(slow, admissible.sample_time_s),
        program=program,
        tol=tol,
        solver=active_set_tables(
            program.hessian, program.written, program.rows, tol.accept, settings.cap, precision
        ),
        reach=replace(half, position_m=half.position_m + abs(admissible.centre_m)),
    )


def design_command_governor(
    prefix: str,
    axes: tuple[AxisGovernorDesign, AxisGovernorDesign],
    points: int,
    settings: GovernorSettings,
) -> CommandGovernorDesign:
    """Both axes together.

    Args:
        points: M, fast samples per slow period.

    Raises:
        DesignError: axes that do not agree in horizon, period or precision, or M below one.
    """
    if points < 1:
        raise DesignError("points", points, "at least one per period")
    of_axes = [(a.horizon, a.plant.sample_time_s, a.precision.name) for a in axes]
    if of_axes[0] != of_axes[1]:
        raise DesignError("axes", f"of {of_axes}", "one horizon, period and precision")
    return CommandGovernorDesign(prefix, axes[0].precision, axes, points, settings.after)


def _interval_ports(design: AxisGovernorDesign, names: tuple[str, str], doc: str) -> list[Port]:
    # a stroke beyond any point of the path, and what rounding may add
    reach = design.reach.position_m * POSITION_FACTOR + 2.0 * design.program.scale_m
    return [
        Port(name, "m", f"{which} {doc}", size=design.intervals, low=-reach, high=reach)
        for name, which in zip(names, ("least", "greatest"), strict=True)
    ]


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
            *iteration.dimensions,
        ),
        constants=(
            Constant("position_scale", 1.0 / program.scale_m, "1/m: positions to rows"),
            Constant("centre", program.centre_m, "m: middle of the position range"),
            Constant("unit", program.scale_m, "m: rows to positions"),
            Constant(
                "stroke", stroke_rows(design), "range of the fast stage used, drawn in, as rows"
            ),
            Constant("far", far_rows(design), "further than two positions are apart, as rows"),
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
            Table("limit", program.limit, "of the rows"),
            Table("moves", program.position, "rows that move with the position"),
            Table("settle", program.settle, "share by which the stroke is shorter"),
            Table("first", program.first, "interval whose stroke bounds a row", integer=True),
            Table("second", program.second, "and another one; -1: none", integer=True),
        ),
        state=(
            StateField("plan", "commands v(0), ..., v(n-1), rho, m", "VARIABLES"),
            StateField("predicted", "state expected at the next step", "PLANT_ORDER", "", "bound"),
            *iteration.state,
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
                outputs=(command, iterations),
            ),
            Operation(
                "hold",
                "No usable measurement: the moved plan.",
                outputs=(command,),
                returns_status=False,
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
            Dimension("WINDOW", design.window, "points ahead that a plan can use"),
            Dimension("INTERVALS", first.intervals, "periods of the plan, and all that follows"),
            Dimension("VARIABLES", first.program.variables, "commands of the plan"),
            Dimension("ROUNDS", 2 * first.program.variables, "turns of the planning"),
        ),
        constants=(
            *(
                Constant(f"stroke_{a}", part.program.stroke_m, "m: fast range used")
                for a, part in both
            ),
            *(
                Constant(f"limit_{a}", part.reach.position_m * POSITION_FACTOR, "m: of the points")
                for a, part in both
            ),
        ),
        tables=(),
        state=(
            *(StateField(f"last_{axis}", "the last point machined, m") for axis in AXES),
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
            StateField("ready", "1 after a successful reset", type="int32_t"),
        ),
        operations=(
            Operation("reset", "Stand still at the first point.", inputs=starts),
            Operation(
                "step",
                "Plan from the measured state and give the commands and points of this period.",
                inputs=(*states, *window),
                outputs=tuple(outputs),
            ),
        ),
        uses=tuple(dict.fromkeys(part.prefix for part in design.axes)),
        facts={
            "after": design.after,
            "axes": {axis: part.prefix for axis, part in both},
            "checked": (*states, *(port for port in window if not port.size)),
        },
    )


def declare_governor_parts(design: CommandGovernorDesign) -> tuple[Declaration, ...]:
    """Declarations of the axes, once where both are the same one, and of the governor."""
    parts = {part.prefix: part for part in design.axes}
    own = tuple(declare_axis_governor(part) for part in parts.values())
    return (*own, declare_command_governor(design))


def stroke_rows(design: AxisGovernorDesign) -> float:
    """The stroke less its margins, as positions are in the rows."""
    return design.program.stroke_m * (1.0 / design.program.scale_m) - design.tol.margin


def far_rows(design: AxisGovernorDesign) -> float:
    """No position is as far from another one, as positions are in the rows."""
    return 4.0 * POSITION_FACTOR * design.reach.position_m / design.program.scale_m


def cast_rows(design: AxisGovernorDesign) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Limit, moves and settle (m,) of the rows in the target precision."""
    program, p = design.program, design.precision
    return cast(program.limit, p), cast(program.position, p), cast(program.settle, p)
