"""The cascade of paper 1: governor, one tracking MPC per axis, fast stage (Figure 4).

Slow step: shift the references, ask the governor how many points the interval at the end of the
horizon may take, solve (16) on both axes, start the fast stage's next interval. With horizon 0
(SPRG alone) the governor looks from the measured state and its reference is the slow command.

The first N - 1 steps only fill the horizon (PRIMING): the machine stands, they may be called back
to back. They build the plan that the governor alone would follow, which (16) admits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from servogen.controllers.arithmetic import check_port
from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Status,
    Value,
)
from servogen.controllers.fast_stage import FastDesign, FastStage, declare_fast
from servogen.controllers.governor import (
    AXES,
    Governor,
    GovernorDesign,
    declare_governor,
    point_ports,
)
from servogen.controllers.tracking_mpc import MpcDesign, TrackingMpc, declare_mpc, state_ports
from servogen.precision import FloatArray


@dataclass(frozen=True)
class CascadeDesign:
    """``mpc``: one design per axis (the same object where the axes are alike), or None."""

    prefix: str
    governor: GovernorDesign
    mpc: tuple[MpcDesign, MpcDesign] | None
    fast: FastDesign

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


def declare_cascade(design: CascadeDesign) -> Declaration:
    """Names, sizes and ports of the cascade."""
    g, horizon = design.governor, design.horizon
    starts = tuple(
        Port(f"position_{a}", "m", "first point", low=-lim.position_m, high=lim.position_m)
        for a, lim in zip(AXES, g.limits, strict=True)
    )
    states = tuple(
        port
        for axis, limit in zip(AXES, g.limits, strict=True)
        for port in state_ports(f"{axis}_", g.order, limit)
    )
    outputs = [
        *(Port(f"command_{axis}", "m", "slow stage position command") for axis in AXES),
        Port("points_taken", "1", "points to drop from the front of the path", integer=True),
        Port("interval_points", "1", "points of the interval that begins", integer=True),
        Port("pending", "1", "points taken and not yet processed", integer=True),
        *(Port(f"iterations_{axis}", "1", "PQP iterations", integer=True) for axis in AXES),
        *(Port(f"status_{axis}", "1", "status of this axis", integer=True) for axis in AXES),
    ]
    constants = []
    for axis, limit in zip(AXES, g.limits, strict=True):
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
            Dimension("PRIMING", max(horizon - 1, 0), "steps that fill the horizon"),
        ),
        constants=tuple(constants),
        tables=(),
        state=_cascade_state(design),
        operations=(
            Operation("reset", "Stand at the first point of the path.", inputs=starts),
            Operation(
                "step",
                "One slow period: measure, govern, optimise, start the next interval.",
                inputs=(*states, *point_ports(g.points, g.limits)),
                outputs=tuple(outputs),
            ),
            Operation(
                "fast_step",
                "One fast sample.",
                outputs=declare_fast(design.fast).operation("step").outputs,
                returns_status=False,
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
        StateField("priming", "priming steps left", type="int32_t"),
        StateField("ready", "1 after a successful reset", type="int32_t"),
    ]
    return tuple(fields)


class Cascade:
    """Reference of the emitted cascade, bit for bit."""

    def __init__(self, design: CascadeDesign) -> None:
        self.design = design
        self.declaration = declare_cascade(design)
        self.governor = Governor(design.governor)
        self.fast = FastStage(design.fast)
        self.mpc = [TrackingMpc(m) for m in design.mpc] if design.mpc else []
        self._real = design.governor.precision.dtype.type
        self._range = [self._real(lim.fast_range_m) for lim in design.governor.limits]
        self._limit = [self._real(lim.position_m) for lim in design.governor.limits]
        self._names = [f"{a}_{p.name}" for a in AXES for p in self._state_ports()]
        self._stand([self._real(0.0)] * 2)
        self.ready = False

    def _state_ports(self) -> tuple[Port, ...]:
        return state_ports("", self.design.governor.order, self.design.governor.limits[0])

    def _stand(self, start: list[np.floating]) -> None:
        n, horizon = self.design.governor.order, self.design.horizon
        self.reference = [np.full(horizon + 1, value, dtype=self._real) for value in start]
        # least and greatest coordinate of intervals 1..N; row k is interval k + 1
        self.low = [np.full(max(horizon, 1), value, dtype=self._real) for value in start]
        self.high = [np.full(max(horizon, 1), value, dtype=self._real) for value in start]
        self.command = list(start)
        self.state = [np.zeros(n, dtype=self._real) for _ in AXES]
        for i in range(2):
            self.state[i][0] = start[i]
        self.priming = max(horizon - 1, 0)
        self.pending = 0

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self._reset(given), {}
            case "step":
                return self._step(given)
            case "fast_step":
                return self.fast.call("step")
        raise KeyError(operation)

    def repeat(self, operation: str, count: int) -> FloatArray:
        """(count, outputs) of an operation without inputs, called ``count`` times."""
        names = [port.name for port in self.declaration.operation(operation).outputs]
        rows = []
        for _ in range(count):
            outputs = self.call(operation)[1]
            rows.append([outputs[name] for name in names])
        return np.array(rows, dtype=self._real)

    def _reset(self, given: Mapping[str, Value]) -> Status:
        start = [self._real(given[f"position_{axis}"]) for axis in AXES]
        status = self.fast.call("reset", given)[0]
        for i, mpc in enumerate(self.mpc):
            status = max(status, mpc.reset(start[i]))
        self.ready = status is Status.OK
        self._stand(start if self.ready else [self._real(0.0)] * 2)
        return status

    def _outputs(self, **values: Value) -> dict[str, Value]:
        outputs: dict[str, Value] = {
            "command_x": self.command[0],
            "command_y": self.command[1],
            "points_taken": 0,
            "interval_points": 0,
            "pending": self.pending,
            "iterations_x": 0,
            "iterations_y": 0,
            "status_x": 0,
            "status_y": 0,
        }
        return outputs | values

    def _step(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, self._outputs()
        measured = self._measured(given)
        if self.mpc:
            return self._mpc_step(given, measured)
        return self._sprg_step(given, measured)

    def _measured(self, given: Mapping[str, Value]) -> Status:
        """Take the measured states over, or go on from the predicted ones."""
        ports = self.declaration.operation("step").inputs[: 2 * self.design.governor.order]
        precision = self.design.governor.precision
        status = max(check_port(port, given[port.name], precision) for port in ports)
        if status is Status.OK:
            values = np.array([given[port.name] for port in ports], dtype=self._real)
            self.state = [np.array(part) for part in np.split(values, 2)]
        return Status(status)

    def _govern(
        self, given: Mapping[str, Value], states: list[FloatArray], usable: bool
    ) -> tuple[Status, dict[str, Value]]:
        """Ask the governor and queue the points; none are taken without a usable measurement."""
        inputs: dict[str, Value] = dict(zip(self._names, np.concatenate(states), strict=True))
        for i, axis in enumerate(AXES):
            inputs[f"last_{axis}"] = self.reference[i][-1]
            inputs[f"points_{axis}"] = given[f"points_{axis}"]
        inputs["n_points"] = given["n_points"] if usable else 0
        status, outputs = self.governor.call("step", inputs)
        push = {
            "points_x": given["points_x"],
            "points_y": given["points_y"],
            "n_points": outputs["points_taken"],
        }
        status = max(status, self.fast.call("push", push)[0])
        self.pending += int(np.asarray(outputs["points_taken"]))
        for i, axis in enumerate(AXES):
            for queue, name in (
                (self.reference, "reference"),
                (self.low, "low"),
                (self.high, "high"),
            ):
                queue[i] = np.append(queue[i][1:], outputs[f"{name}_{axis}"]).astype(self._real)
        return status, outputs

    def _mpc_step(
        self, given: Mapping[str, Value], measured: Status
    ) -> tuple[Status, dict[str, Value]]:
        usable = measured is Status.OK
        if not usable:
            self.state = [np.array(mpc.predicted) for mpc in self.mpc]
        ends = [mpc.candidate(self.state[i]) for i, mpc in enumerate(self.mpc)]
        status, govern = self._govern(given, ends, usable)
        taken = govern["points_taken"]
        if self.priming > 0:
            self.priming -= 1
            for i, mpc in enumerate(self.mpc):
                mpc.seed(self.reference[i][-1])
            status = max(Status.PRIMING, measured, status)
            return status, self._outputs(points_taken=taken)
        statuses, iterations = [Status.OK] * 2, [0, 0]
        for i, mpc in enumerate(self.mpc):
            if usable:
                low, high = self._window(i)
                inputs = dict(zip(mpc._names, self.state[i], strict=True))
                found, out = mpc.call(
                    "step", {**inputs, "reference": self.reference[i], "low": low, "high": high}
                )
                statuses[i], iterations[i] = found, int(np.asarray(out["iterations"]))
                self.command[i] = self._real(out["command"])
            else:
                self.command[i] = mpc.hold(self.reference[i][-1])[0]
        status = max(measured, status, *statuses)
        return self._begin(
            given,
            status,
            points_taken=taken,
            iterations_x=iterations[0],
            iterations_y=iterations[1],
            status_x=int(statuses[0]),
            status_y=int(statuses[1]),
        )

    def _window(self, i: int) -> tuple[FloatArray, FloatArray]:
        """Bounds of y_1..y_N: range (16e, f) at both ends of every interval, position limit."""
        low, high = np.array(self.high[i]), np.array(self.low[i])
        if self.design.governor.both_ends:
            low[:-1] = np.maximum(low[:-1], self.high[i][1:])
            high[:-1] = np.minimum(high[:-1], self.low[i][1:])
        limit, reach = self._limit[i], self._range[i]
        return np.maximum(low - reach, -limit), np.minimum(high + reach, limit)

    def _sprg_step(
        self, given: Mapping[str, Value], measured: Status
    ) -> tuple[Status, dict[str, Value]]:
        if measured is not Status.OK:  # the fast stage's model has followed the last command
            self.state = [np.array(state, dtype=self._real) for state in self.fast.state]
        status, govern = self._govern(given, self.state, measured is Status.OK)
        self.command = [self.reference[i][-1] for i in range(2)]
        return self._begin(given, max(measured, status), points_taken=govern["points_taken"])

    def _begin(
        self, given: Mapping[str, Value], status: Status, **outputs: Value
    ) -> tuple[Status, dict[str, Value]]:
        inputs: dict[str, Value] = dict(zip(self._names, np.concatenate(self.state), strict=True))
        for i, axis in enumerate(AXES):
            inputs[f"slow_command_{axis}"] = self.command[i]
        began, out = self.fast.call("begin", inputs)
        interval = int(np.asarray(out["interval_points"]))
        self.pending -= interval
        status = max(status, began)
        left = self.pending + interval + int(np.asarray(given["n_points"]))
        if status is Status.OK and left == 0:
            status = Status.FINISHED
        return status, self._outputs(interval_points=interval, **outputs)
