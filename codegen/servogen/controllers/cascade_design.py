"""The cascade of paper 1: governor, one tracking MPC per axis, fast stage (Figure 4).

Slow step: shift the references, ask the governor how many points the interval at the end of the
horizon may take, solve (16) on both axes, start the fast stage's next interval. With horizon 0
(SPRG alone) the governor looks from the measured state and its reference is the slow command.

The first N - 1 steps only fill the horizon (PRIMING): the machine stands, they may be called back
to back. They build the plan that the governor alone would follow, which (16) admits.
"""

from __future__ import annotations

from dataclasses import dataclass

from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Status,
    Table,
)
from servogen.controllers.fast_design import FastDesign, declare_fast
from servogen.controllers.governor_design import (
    AXES,
    NOT_READ,
    GovernorDesign,
    declare_governor,
    point_ports,
)
from servogen.controllers.mpc_design import (
    POSITION_FACTOR,
    MpcDesign,
    declare_mpc,
    state_bounds,
    state_ports,
)
from servogen.plants.statespace import Discrete


@dataclass(frozen=True)
class CascadeDesign:
    """``mpc``: one design per axis (the same object where the axes are alike), or None;
    ``plants``: slow stages at T_s, for the state one period ahead."""

    prefix: str
    governor: GovernorDesign
    mpc: tuple[MpcDesign, MpcDesign] | None
    fast: FastDesign
    plants: tuple[Discrete, Discrete]

    @property
    def horizon(self) -> int:
        return self.mpc[0].horizon if self.mpc else 0

    @property
    def axis_prefixes(self) -> tuple[str, ...]:
        return tuple(m.prefix for m in self.mpc) if self.mpc else ()


def declare_parts(design: CascadeDesign) -> tuple[Declaration, ...]:
    """Declarations of everything the cascade is made of, itself last, each once."""
    mpcs = {m.prefix: m for m in design.mpc or ()}
    return (
        declare_governor(design.governor),
        *(declare_mpc(m) for m in mpcs.values()),
        declare_fast(design.fast),
        declare_cascade(design),
    )


def _step_outputs(design: CascadeDesign) -> tuple[Port, ...]:
    """Bounded whatever came in: commands by a clamp, counts by the queue of the fast stage."""
    limits, points = design.governor.limits, design.governor.points
    reaches = [limit.position_m * POSITION_FACTOR for limit in limits]
    caps = [m.solver.cap for m in design.mpc] if design.mpc else [0, 0]
    counts = (
        ("points_taken", "points to drop from the front of the path", points),
        ("interval_points", "points of the interval that begins", points),
        ("pending", "points taken and not yet processed", points * max(design.horizon, 1)),
        *(
            (f"iterations_{a}", "iterations of the MPC's program", cap)
            for a, cap in zip(AXES, caps, strict=True)
        ),
        *((f"status_{a}", "status of this axis", int(max(Status))) for a in AXES),
    )
    return (
        *(
            Port(f"command_{a}", "m", "slow stage position command", low=-reach, high=reach)
            for a, reach in zip(AXES, reaches, strict=True)
        ),
        *(Port(name, "1", doc, integer=True, low=0, high=most) for name, doc, most in counts),
    )


def _state_bounds(design: CascadeDesign) -> tuple[Table, ...]:
    """Of the governor alone, which follows its own model where there is no measurement; with a
    predictive controller that one has them."""
    g = design.governor
    return tuple(
        Table(f"bound_{axis}", state_bounds(g.order, limit), f"largest state expected, {axis}")
        for axis, limit in zip(AXES, () if design.mpc else g.limits, strict=False)
    )


def declare_cascade(design: CascadeDesign) -> Declaration:
    """Names, sizes and ports of the cascade."""
    g, horizon = design.governor, design.horizon
    slow, fast = g.sample_time_s, design.fast.sample_time_s
    starts = tuple(
        Port(f"position_{a}", "m", "first point", low=-lim.position_m, high=lim.position_m)
        for a, lim in zip(AXES, g.limits, strict=True)
    )
    states = tuple(
        port
        for axis, limit in zip(AXES, g.limits, strict=True)
        for port in state_ports(f"{axis}_", g.order, limit)
    )
    outputs = _step_outputs(design)
    constants = []  # the governor alone needs none
    for axis, limit in zip(AXES, g.limits if horizon else (), strict=False):
        constants += [
            Constant(f"range_{axis}", limit.fast_range_m, f"m: fast stage range, {axis}"),
            Constant(f"position_limit_{axis}", limit.position_m, f"m: slow stage range, {axis}"),
        ]
    parts = (g.prefix, *dict.fromkeys(design.axis_prefixes), design.fast.prefix)
    return Declaration(
        kind="cascade" if horizon else "cascade_sprg",
        prefix=design.prefix,
        summary="SPRG-MPC cascade for a two-stage machine"
        if horizon
        else "Spatial reference governor alone for a two-stage machine",
        precision=g.precision,
        sample_time_s=g.sample_time_s,
        dimensions=(
            Dimension("ORDER", g.order, "states of a slow stage"),
            Dimension("POINTS", g.points, "M"),
            Dimension("HORIZON", horizon, "N; 0: the governor alone"),
            Dimension("REFERENCES", horizon + 1, "r_0..r_N"),
            Dimension("INTERVALS", max(horizon, 1), "intervals looked ahead"),
            Dimension("WAITING", design.fast.intervals * g.points, "points that can wait"),
            Dimension("PRIMING", max(horizon - 1, 0), "steps that fill the horizon"),
        ),
        constants=tuple(constants),
        tables=tuple(
            table
            for axis, plant in zip(AXES, design.plants, strict=True)
            for table in (
                Table(f"a_columns_{axis}", plant.a.T, f"A of (11), {axis}, transposed"),
                Table(f"b_{axis}", plant.b, f"B of (11), {axis}"),
            )
        )
        + _state_bounds(design),
        state=_cascade_state(design),
        operations=(
            Operation("reset", "Stand at the first point of the path.", inputs=starts),
            Operation(
                "step",
                "plan and start in one, for a processor that needs no time to speak of.",
                inputs=(*states, *point_ports(g.points, g.limits, NOT_READ)),
                outputs=outputs,
            ),
            Operation(
                "predict",
                "State at the next slow sample, from the one measured at the last.",
                inputs=states,
                outputs=tuple(Port(port.name, port.unit, port.doc) for port in states),
                reads_only=True,
                period_s=slow,
            ),
            Operation(
                "plan",
                "Govern and optimise for the state at the next slow sample; takes its time.",
                inputs=(*states, *point_ports(g.points, g.limits, NOT_READ)),
                outputs=outputs,
                shares="step",
                period_s=slow,
            ),
            Operation(
                "start",
                "At the slow sample, not interrupted by fast_step: begin what was planned.",
                outputs=tuple(
                    port
                    for port in outputs
                    if port.name in ("command_x", "command_y", "interval_points", "pending")
                ),
                period_s=slow,
                deadline_s=fast,  # before the fast sample that falls on the slow one is late
            ),
            Operation(
                "fast_step",
                "One fast sample.",
                outputs=declare_fast(design.fast).operation("step").outputs,
                returns_status=False,
                period_s=fast,
            ),
        ),
        uses=parts,
        facts={
            "governor": g.prefix,
            "fast": design.fast.prefix,
            "mpc": dict(zip(AXES, design.axis_prefixes, strict=False)),
            "both_ends": g.both_ends,
        },
    )


def _cascade_state(design: CascadeDesign) -> tuple[StateField, ...]:
    fields = [StateField("governor", "governor", type=design.governor.prefix)]
    for axis, prefix in zip(AXES, design.axis_prefixes, strict=False):
        fields.append(StateField(f"mpc_{axis}", f"tracking MPC, {axis}", type=prefix))
    fields.append(StateField("fast", "fast stage", type=design.fast.prefix))
    for axis in AXES:
        fields += [
            StateField(f"reference_{axis}", "r_0..r_N, m", "REFERENCES"),
            StateField(f"low_{axis}", "least coordinate of intervals 1..N", "INTERVALS"),
            StateField(f"high_{axis}", "greatest coordinate of them", "INTERVALS"),
            StateField(f"state_{axis}", "state of the slow stage used", "ORDER"),
            StateField(f"command_{axis}", "slow stage command, m"),
        ]
    fields += [
        StateField("pending", "points taken and not yet processed", type="int32_t"),
        StateField("offered", "points offered to the last plan", type="int32_t"),
        StateField("planned", "1 between plan and start", type="int32_t"),
        StateField("priming", "priming steps left", type="int32_t"),
        StateField("ready", "1 after a successful reset", type="int32_t"),
    ]
    return tuple(fields)
