"""Fast stage (22)-(23), step by step: points of an interval in, commands at T_f out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import Scalar, check_port, scalar_type
from servogen.controllers.design import Status, Value
from servogen.controllers.fast_design import FastDesign, declare_fast
from servogen.controllers.governor_design import AXES
from servogen.controllers.mpc_design import state_bounds


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
        self._bound = [
            [real(v) for v in state_bounds(design.order, limit)] for limit in design.limits
        ]
        self._direct = [self._c[f"direct_{a}"] for a in AXES]
        self._limit = [self._c[f"limit_{a}"] for a in AXES]
        self._end = [self._c[f"end_{a}"] for a in AXES]
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
            case "room":
                return Status.OK, {"points": self.room()}
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
        status = self._check("push", given)
        if status is not Status.OK:
            return status
        if len(self.queue) >= self.design.intervals:
            return Status.OVERFLOW
        count, dtype = int(np.asarray(given["n_points"])), self.design.precision.dtype
        points = [np.asarray(given[f"points_{a}"], dtype=dtype)[:count] for a in AXES]
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

    def room(self) -> int:
        """Points of an interval that ramps from the present end rate to one and stays there."""
        if self.design.ramp == 0:
            return self.design.points
        return int(self._c["flat"] + self._c["ramp_half"] * (self._real(1.0) + self.rate_end))

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
        index = min(int(self.along), self.current - 1)
        share = self.along - self._real(index)
        here, there = path[index], path[index + 1]
        return here + share * (there - here)

    def step(self) -> dict[str, Value]:
        """One fast sample: the outputs, then the model and the feed one sample on."""
        outputs: dict[str, Value] = {}
        for i, axis in enumerate(AXES):
            end = self._end[i]
            reference = min(max(self._point(i), -end), end)
            state, command = self.state[i], self.command[i]
            taken = _dot(self._row[i], state) + self._direct[i] * command
            limit = self._limit[i]
            outputs[f"reference_{axis}"] = reference
            outputs[f"command_{axis}"] = min(max(reference - taken, -limit), limit)
            self.state[i] = [
                min(max(_dot(row, state) + gain * command, -bound), bound)
                for row, gain, bound in zip(
                    self._model[i], self._input[i], self._bound[i], strict=True
                )
            ]
        outputs["along"] = self.along
        if self.done < self.design.points:
            along = max(self.along + self._rate(), self._real(0.0))
            self.along = min(along, self._real(self.current))
            self.done += 1
        if self.done == self.design.points:
            self.along = self._real(self.current)
        return outputs


def _dot(row: list[Scalar], state: list[Scalar]) -> Scalar:
    total = row[0] * state[0]
    for a, x in zip(row[1:], state[1:], strict=True):
        total = total + a * x
    return total
