"""Extended command governor (17)-(18) for a slow stage in two axes: its design.

Every slow period the plan of the last one is moved on by a period and foreseen from the measured
state; that says which points of the path each coming period can machine (``command_governor_path``)
and with them the stroke bounds S_k and the references (21). Then each axis solves its program.
Where that ends at its cap, the moved plan itself is used: the shifted register with the same rho,
which keeps every bound because it is what they were made from.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from servogen.controllers.command_governor_program import (
    SETTLED,
    GovernorProgram,
    GovernorWeights,
    governor_program,
)
from servogen.controllers.errors import DesignError
from servogen.controllers.mpc_design import POSITION_FACTOR
from servogen.plants.statespace import Discrete, StateSpace, discretise
from servogen.precision import Precision
from servogen.qp.active_set_tables import ActiveSetTables, active_set_tables
from servogen.qp.tolerances import QpTolerances, tolerances
from servogen.sets.constraints import AxisLimits
from servogen.sets.extended import ExtendedSet

# Iterations for every command of a plan after which a program counts as one without an answer: many
# times what any takes.
PATIENT = 50


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
        points_ahead: of the path, that a plan looks at: memory and comparisons against time; None:
            as many as it can machine, M in each of its periods.
    """

    weights: GovernorWeights = field(default_factory=GovernorWeights)
    cap: int = 150
    margin: float = 1e-6
    sub_step_stroke: bool = False
    stroke_margin_m: float = 0.0
    after: bool = True
    points_ahead: int | None = None


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

    @property
    def in_reach(self) -> float:
        """Share of the fast stage's range in which a point is in reach of a plan: the stroke, drawn
        in as the bounds are that are made of the points."""
        return self.program.stroke_m * (1.0 / self.program.scale_m) - self.tol.margin

    @property
    def patience(self) -> int:
        """Periods in a row that a stage at rest may be at the cap."""
        return -(-PATIENT * self.program.variables // self.solver.cap)

    @property
    def standing_m(self) -> float:
        """So near to the end of its plan a stage is at rest: what the rows take for settled."""
        return SETTLED * self.program.stroke_m

    @property
    def farthest(self) -> float:
        """Of positions from one another, in shares of that range: more than any two."""
        return 4.0 * POSITION_FACTOR * self.reach.position_m / self.program.scale_m


@dataclass(frozen=True)
class CommandGovernorDesign:
    """Both axes; ``points`` M per period at the most, ``window`` points ahead that a plan looks at,
    ``after`` as in ``GovernorSettings``."""

    prefix: str
    precision: Precision
    axes: tuple[AxisGovernorDesign, AxisGovernorDesign]
    points: int
    window: int
    after: bool


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
            program.hessian,
            program.written,
            program.rows,
            tol.accept,
            settings.cap,
            precision,
            resumes=True,
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
        DesignError: axes that do not agree in horizon, period or precision, M below one, or not
            more points ahead than M.
    """
    if points < 1:
        raise DesignError("points", points, "at least one per period")
    of_axes = [(a.horizon, a.plant.sample_time_s, a.precision.name) for a in axes]
    if of_axes[0] != of_axes[1]:
        raise DesignError("axes", f"of {of_axes}", "one horizon, period and precision")
    # all that its periods can take, and the one after
    window = axes[0].program.variables * points + 1
    if settings.points_ahead is not None:
        if not points < settings.points_ahead:
            raise DesignError("points_ahead", settings.points_ahead, f"more than M, {points}")
        window = min(window, settings.points_ahead)
    return CommandGovernorDesign(prefix, axes[0].precision, axes, points, window, settings.after)
