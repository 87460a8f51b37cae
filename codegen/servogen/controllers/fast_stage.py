"""Fast stage: follows the points of an interval and takes off what the slow stage does (22)-(23).

Points: an interval of eta points is spread over M fast samples by a feed rate that ramps inside
the interval, so that a change in eta is no step in the speed of the tool.

Compensation: (23) divides the slow stage's model by the fast stage's. The quotient of the sampled
models is unstable (a sampling zero beyond -1), but the fast stage is all-pole, so its inverse is a
sum of derivatives of the slow motion, which are states: y_s + (a1/a0) v + (a2/a0) a + jerk / a0 for
a third-order stage. It is evaluated half a fast sample ahead, where the held command acts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from servogen.controllers.arithmetic import Scalar, check_port, scalar_type
from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Status,
    Table,
    Value,
)
from servogen.controllers.governor import AXES, point_ports
from servogen.controllers.tracking_mpc import POSITION_FACTOR, state_ports
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
            Constant(
                f"limit_{axis}", limit.fast_range_m * RANGE_FACTOR, "m: no fast command beyond it"
            ),
        ]
        tables += [
            Table(f"model_{axis}", part.model.a.T, f"{axis}: slow stage at T_f, transposed"),
            Table(f"input_{axis}", part.model.b, f"{axis}: slow stage at T_f, input"),
            Table(f"row_{axis}", part.row, f"{axis}: compensation on the state"),
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
            Constant("ramp_inverse", 1.0 / ramp if ramp else 0.0, "1 / RAMP"),
            Constant("ramp_half", 0.5 * ramp, "RAMP / 2"),
            Constant("ramp_twice_inverse", 2.0 / ramp if ramp else 0.0, "2 / RAMP"),
            Constant("flat", float(design.points - ramp), "M - RAMP"),
            Constant("flat_inverse", 1.0 / (design.points - ramp), "1 / (M - RAMP)"),
            Constant("rate_scale", 0.5 / design.points, "1 / (2 M)"),
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
                outputs=(Port("interval_points", "1", "its points", integer=True),),
            ),
            Operation(
                "step",
                "One fast sample.",
                outputs=(
                    *(Port(f"command_{axis}", "m", "fast stage command") for axis in AXES),
                    *(
                        Port(f"reference_{axis}", "m", "r_f of (22), where the tool should be")
                        for axis in AXES
                    ),
                    Port("along", "1", "points of the interval behind that point"),
                ),
                returns_status=False,
            ),
        ),
        facts={"ramp": ramp > 0},
    )


class FastStage:
    """Reference of the emitted fast stage, bit for bit.

    It runs at the fast rate, so it computes on scalars: Python's own for float64, which are the
    same IEEE numbers and much quicker than numpy's.
    """

    def __init__(self, design: FastDesign) -> None:
        self.design = design
        self.declaration = declare_fast(design)
        self._real = real = scalar_type(design.precision)
        self._c = {c.name: real(c.value) for c in self.declaration.constants}
        self._model = [[[real(v) for v in row] for row in axis.model.a] for axis in design.axes]
        self._input = [[real(v) for v in axis.model.b] for axis in design.axes]
        self._row = [[real(v) for v in axis.row] for axis in design.axes]
        self._direct = [self._c[f"direct_{a}"] for a in AXES]
        self._limit = [self._c[f"limit_{a}"] for a in AXES]
        self._ports = {
            op.name: {port.name: port for port in op.inputs} for op in self.declaration.operations
        }
        self._clear([real(0.0)] * 2)
        self.ready = False

    def _clear(self, start: list[Scalar]) -> None:
        self.path = [[value] for value in start]  # points from the head on
        self.queue: list[int] = []
        self.current = 0
        self.done = self.design.points  # fast samples of the interval done
        self.along = self._real(0.0)  # points along the interval
        self.rate_begin = self._real(0.0)
        self.rate_flat = self._real(0.0)
        self.rate_end = self._real(0.0)
        rest = [self._real(0.0)] * (self.design.order - 1)
        self.state = [[start[i], *rest] for i in range(2)]
        self.command = list(start)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self._reset(given), {}
            case "push":
                return self._push(given), {}
            case "begin":
                return self._begin(given)
            case "step":
                return Status.OK, self.step()
        raise KeyError(operation)

    def _check(self, operation: str, given: Mapping[str, Value]) -> Status:
        ports = self._ports[operation].values()
        return max(check_port(port, given[port.name], self.design.precision) for port in ports)

    def _reset(self, given: Mapping[str, Value]) -> Status:
        status = self._check("reset", given)
        self.ready = status is Status.OK
        zero = self._real(0.0)
        self._clear([self._real(given[f"position_{a}"]) if self.ready else zero for a in AXES])
        return status

    def _push(self, given: Mapping[str, Value]) -> Status:
        if not self.ready:
            return Status.NOT_READY
        count = int(np.asarray(given["n_points"]))
        if not 0 <= count <= self.design.points:
            return Status.OUT_OF_RANGE
        precision = self.design.precision
        points = [np.asarray(given[f"points_{a}"], dtype=precision.dtype)[:count] for a in AXES]
        if count:
            status = max(
                check_port(self._ports["push"][f"points_{a}"], points[i], precision)
                for i, a in enumerate(AXES)
            )
            if status is not Status.OK:
                return status
        if len(self.queue) >= self.design.intervals:
            return Status.OVERFLOW
        for i in range(2):
            self.path[i].extend(self._real(value) for value in points[i])
        self.queue.append(count)
        return Status.OK

    def _begin(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, {"interval_points": 0}
        n = self.design.order
        status = self._check("begin", given)
        names = list(self._ports["begin"])
        if status is Status.OK:
            for i in range(2):
                own = names[i * (n + 1) : (i + 1) * (n + 1)]
                self.state[i] = [self._real(given[name]) for name in own[:n]]
                self.command[i] = self._real(given[own[n]])
        for i in range(2):
            del self.path[i][: self.current]
        self.current = self.queue.pop(0) if self.queue else 0
        following = self.queue[0] if self.queue else self.current
        self.done = 0
        self.along = self._real(0.0)
        self._plan_feed(self._real(self.current), self._real(following))
        return status, {"interval_points": self.current}

    def _plan_feed(self, points: Scalar, following: Scalar) -> None:
        """Rates (points per fast sample) at the start, in the flat middle and at the end.

        The start is where the last interval ended; the end is the mean of this interval's and the
        next one's feed, kept where both can still cover their points at rates from 0 to 1.
        """
        c, real = self._c, self._real
        zero, one = real(0.0), real(1.0)
        if self.design.ramp == 0:
            self.rate_flat = points * c["flat_inverse"]
            return
        end = (points + following) * c["rate_scale"]
        end = min(end, following * c["ramp_twice_inverse"])
        end = max(end, (following - c["flat"]) * c["ramp_twice_inverse"] - one)
        begin = self.rate_end
        most = points * c["ramp_twice_inverse"]
        least = (points - c["flat"]) * c["ramp_twice_inverse"]
        end = min(end, most - begin)
        end = max(end, least - begin)
        end = min(max(end, zero), one)
        begin = min(begin, most - end)
        begin = max(begin, least - end)
        begin = min(max(begin, zero), one)
        self.rate_begin, self.rate_end = begin, end
        self.rate_flat = (points - c["ramp_half"] * (begin + end)) * c["flat_inverse"]

    def _rate(self) -> Scalar:
        ramp = self.design.ramp
        left = self.design.points - self.done
        real, half = self._real, self._real(0.5)
        if self.done < ramp:
            share = (real(self.done) + half) * self._c["ramp_inverse"]
            return self.rate_begin + (self.rate_flat - self.rate_begin) * share
        if left <= ramp:
            share = (real(left) - half) * self._c["ramp_inverse"]
            return self.rate_end + (self.rate_flat - self.rate_end) * share
        return self.rate_flat

    def _point(self, axis: int) -> Scalar:
        path = self.path[axis]
        if self.current == 0:
            return path[0]
        index = min(max(int(self.along), 0), self.current - 1)
        share = self.along - self._real(index)
        here, there = path[index], path[index + 1]
        return here + share * (there - here)

    def step(self) -> dict[str, Value]:
        """One fast sample: the outputs, then the model and the feed one sample on."""
        outputs: dict[str, Value] = {}
        for i, axis in enumerate(AXES):
            reference = self._point(i)
            state, command = self.state[i], self.command[i]
            taken = _dot(self._row[i], state) + self._direct[i] * command
            limit = self._limit[i]
            outputs[f"reference_{axis}"] = reference
            outputs[f"command_{axis}"] = min(max(reference - taken, -limit), limit)
            self.state[i] = [
                _dot(row, state) + gain * command
                for row, gain in zip(self._model[i], self._input[i], strict=True)
            ]
        outputs["along"] = self.along
        if self.done < self.design.points:
            self.along = min(self.along + self._rate(), self._real(self.current))
            self.done += 1
        if self.done == self.design.points:
            self.along = self._real(self.current)
        return outputs


def _dot(row: list[Scalar], state: list[Scalar]) -> Scalar:
    total = row[0] * state[0]
    for a, x in zip(row[1:], state[1:], strict=True):
        total = total + a * x
    return total
