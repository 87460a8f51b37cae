"""Fast stage: follows the points of an interval and takes off what the slow stage does (22)-(23).

Points: an interval of eta points is spread over M fast samples by a feed rate that ramps inside
the interval, so that a change in eta is no step in the speed of the tool.

Compensation: (23) divides the slow stage's model by the fast stage's. The quotient of the sampled
models is unstable (a sampling zero beyond -1), but the fast stage is all-pole, so its inverse is a
sum of derivatives of the slow motion, which are states: y_s + (a1/a0) v + (a2/a0) a + jerk / a0 for
a third-order stage. It is evaluated half a fast sample ahead, where the held command acts.
"""

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
from servogen.controllers.governor_design import AXES, point_ports
from servogen.controllers.mpc_design import POSITION_FACTOR, state_bounds, state_ports
from servogen.plants.errors import PlantError
from servogen.plants.statespace import Discrete, StateSpace, discretise
from servogen.precision import FloatArray, Precision
from servogen.sets.constraints import AxisLimits

# The fast command may lead the fast position by its own lag (about 1 mm at 0.7 m/s); a command
# further out than this share of the range means that somebody upstream is wrong.
RANGE_FACTOR = 1.2
# A coefficient of the fast stage's numerator below this share of the leading one is rounding.
NUMERATOR_TOLERANCE = 1e-9


@dataclass(frozen=True)
class AxisCompensation:
    """``model``: slow stage at T_f; ``row`` (n,) and ``direct``: what (22) or (23) takes off."""

    model: Discrete
    row: FloatArray
    direct: float


@dataclass(frozen=True)
class FastDesign:
    """``points`` M; ``intervals``: intervals that can be queued; ``ramp``: fast samples a feed
    ramp takes, 0 for a constant feed inside every interval."""

    prefix: str
    precision: Precision
    points: int
    intervals: int
    ramp: int
    order: int
    sample_time_s: float
    limits: tuple[AxisLimits, AxisLimits]
    axes: tuple[AxisCompensation, AxisCompensation]


def compensation(
    slow: StateSpace, fast: StateSpace, fast_sample_time_s: float, matching: bool
) -> AxisCompensation:
    """Row and feedthrough on (slow state, slow command), continuous models in motion states.

    Raises:
        PlantError: (23) asked for with a fast stage that has zeros or more poles than the slow
            stage has derivatives.
    """
    model = discretise(slow, fast_sample_time_s)
    n = slow.order
    if not matching:
        return AxisCompensation(model, np.eye(n)[0], 0.0)
    row, direct = _inverse_of_fast(slow, fast)
    half = discretise(slow, 0.5 * fast_sample_time_s)
    return AxisCompensation(model, row @ half.a, float(row @ half.b) + direct)


def _inverse_of_fast(slow: StateSpace, fast: StateSpace) -> tuple[FloatArray, float]:
    """sum over i of a_i/a_0 d^i y_s/dt^i, a_i the fast stage's characteristic polynomial."""
    polynomial = np.poly(fast.a)[::-1].real  # a_0 first
    gain = fast.b[-1]
    if np.any(np.abs(fast.b[:-1]) > NUMERATOR_TOLERANCE * abs(gain)):
        raise PlantError("matching", True, "a fast stage without zeros, or matching = false (22)")
    row, direct = np.zeros(slow.order), 0.0
    derivative, on_command = slow.c.copy(), 0.0
    for i, coefficient in enumerate(polynomial):
        row = row + coefficient / polynomial[0] * derivative
        direct += coefficient / polynomial[0] * on_command
        if i == polynomial.size - 1:
            break
        if on_command != 0.0:
            raise PlantError(
                "matching", True, "a fast stage of no higher relative degree than the slow stage"
            )
        on_command = float(derivative @ slow.b)
        derivative = derivative @ slow.a
        if abs(on_command) <= NUMERATOR_TOLERANCE * abs(float(slow.b[-1])):
            on_command = 0.0
    return row, direct


def _feed_constants(points: int, ramp: int) -> tuple[Constant, ...]:
    flat = Constant("flat_inverse", 1.0 / (points - ramp), "1 / (M - RAMP)")
    if ramp == 0:
        return (flat,)
    return (
        Constant("ramp_inverse", 1.0 / ramp, "1 / RAMP"),
        Constant("ramp_half", 0.5 * ramp, "RAMP / 2"),
        Constant("ramp_twice_inverse", 2.0 / ramp, "2 / RAMP"),
        Constant("flat", float(points - ramp), "M - RAMP"),
        flat,
        Constant("rate_scale", 0.5 / points, "1 / (2 M)"),
    )


def _step_outputs(design: FastDesign) -> tuple[Port, ...]:
    """Bounded whatever came in: commands by a clamp, the rest lies among points of the path."""
    reaches = [limits.fast_range_m * RANGE_FACTOR for limits in design.limits]
    ends = [limits.position_m for limits in design.limits]
    return (
        *(
            Port(f"command_{axis}", "m", "fast stage command", low=-reach, high=reach)
            for axis, reach in zip(AXES, reaches, strict=True)
        ),
        *(
            Port(
                f"reference_{axis}",
                "m",
                "r_f of (22), where the tool should be",
                low=-end,
                high=end,
            )
            for axis, end in zip(AXES, ends, strict=True)
        ),
        Port(
            "along",
            "1",
            "points of the interval behind that point",
            low=0.0,
            high=float(design.points),
        ),
    )


def declare_fast(design: FastDesign) -> Declaration:
    """Names, sizes, tables and ports of the fast stage's command generator."""
    begin = []
    constants = []
    tables = []
    for axis, limit, part in zip(AXES, design.limits, design.axes, strict=True):
        reach = limit.position_m * POSITION_FACTOR
        begin += list(state_ports(f"{axis}_", design.order, limit))
        begin.append(
            Port(f"slow_command_{axis}", "m", "slow stage command", low=-reach, high=reach)
        )
        constants += [
            Constant(f"direct_{axis}", part.direct, f"{axis}: compensation on the command"),
            Constant(f"end_{axis}", limit.position_m, "m: no point of the path beyond it"),
            Constant(
                f"limit_{axis}", limit.fast_range_m * RANGE_FACTOR, "m: no fast command beyond it"
            ),
        ]
        tables += [
            Table(f"model_{axis}", part.model.a.T, f"{axis}: slow stage at T_f, transposed"),
            Table(f"input_{axis}", part.model.b, f"{axis}: slow stage at T_f, input"),
            Table(f"row_{axis}", part.row, f"{axis}: compensation on the state"),
            Table(f"bound_{axis}", state_bounds(design.order, limit), f"{axis}: model's state"),
        ]
    ramp = design.ramp
    starts = tuple(
        Port(f"position_{axis}", "m", "start point", low=-limit.position_m, high=limit.position_m)
        for axis, limit in zip(AXES, design.limits, strict=True)
    )
    return Declaration(
        kind="fast",
        prefix=design.prefix,
        summary="Fast stage commands (22)-(23) and the feed along the points",
        precision=design.precision,
        sample_time_s=design.sample_time_s,
        dimensions=(
            Dimension("ORDER", design.order, "states of a slow stage"),
            Dimension("POINTS", design.points, "M, fast samples per interval"),
            Dimension("INTERVALS", design.intervals, "intervals that can wait"),
            Dimension("BUFFER", (design.intervals + 1) * design.points + 1, "points kept"),
            Dimension("RAMP", ramp, "fast samples of a feed ramp"),
        ),
        constants=(
            *_feed_constants(design.points, ramp),
            *constants,
        ),
        tables=tuple(tables),
        state=(
            *(StateField(f"path_{a}", "ring of points, m", "BUFFER") for a in AXES),
            *(StateField(f"state_{a}", "slow stage model at T_f", "ORDER") for a in AXES),
            *(StateField(f"scratch_{a}", "workspace", "ORDER") for a in AXES),
            *(StateField(f"command_{a}", "slow stage command, m") for a in AXES),
            StateField("along", "points along the interval"),
            StateField("rate_begin", "points per fast sample"),
            StateField("rate_flat", "points per fast sample"),
            StateField("rate_end", "points per fast sample"),
            StateField("queue", "points of the intervals that wait", "INTERVALS", "int32_t"),
            StateField("waiting", "intervals that wait", type="int32_t"),
            StateField("head", "where the interval's first point is in the ring", type="int32_t"),
            StateField("tail", "where the newest point is in the ring", type="int32_t"),
            StateField("current", "points of the interval", type="int32_t"),
            StateField("done", "fast samples of the interval", type="int32_t"),
            StateField("ready", "1 after a successful reset", type="int32_t"),
        ),
        operations=(
            Operation("reset", "Forget the queue; stand at a point.", inputs=starts),
            Operation(
                "push",
                "Queue the points of one interval.",
                inputs=point_ports(design.points, design.limits),
            ),
            Operation(
                "begin",
                "Start the next interval of the queue from the slow stage's measured state.",
                inputs=tuple(begin),
                outputs=(
                    Port(
                        "interval_points",
                        "1",
                        "its points",
                        integer=True,
                        low=0,
                        high=design.points,
                    ),
                ),
            ),
            Operation(
                "room",
                "Most points the next interval can pass without a step in the feed.",
                outputs=(
                    Port("points", "1", "at most M", integer=True, low=0, high=design.points),
                ),
                returns_status=False,
                reads_only=True,
            ),
            Operation(
                "step",
                "One fast sample.",
                outputs=_step_outputs(design),
                returns_status=False,
            ),
        ),
        facts={"ramp": ramp > 0},
    )
