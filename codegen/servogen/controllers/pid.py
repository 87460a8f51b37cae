"""Cascaded PID of a servo axis, step by step; see ``pid_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import Scalar, check_port, scalar_type
from servogen.controllers.design import Status, Value
from servogen.controllers.pid_design import PidDesign, declare_pid
from servogen.controllers.wrapping import Wrapping


class Pid:
    """Reference of the emitted PID, bit for bit.

    Anti-windup: while the speed loop asks for more than the limit, the integral takes nothing on
    that would make it ask for more still. An unusable input asks for no current and empties the
    integral; the filter lets what it holds run out.
    """

    def __init__(self, design: PidDesign) -> None:
        self.design = design
        self.declaration = declare_pid(design)
        self.precision = design.precision
        self._real = real = scalar_type(design.precision)
        self._c = {c.name: real(c.value) for c in self.declaration.constants}
        self._wrapping = Wrapping(design.turn, design.reach, design.precision)
        self._ports = {
            op.name: {port.name: port for port in op.inputs} for op in self.declaration.operations
        }
        self.ready = False
        self._rest(real(0.0))

    def _rest(self, position: Scalar) -> None:
        zero = self._real(0.0)
        self.last = position
        self.integral, self.wanted = zero, zero
        self.memory_1, self.memory_2 = zero, zero

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self._reset(given), {}
            case "step":
                status = self._step(given)
                return status, {"wanted": self.wanted}
            case "filter_step":
                return self._filter()
        raise KeyError(operation)

    def _scalar(self, value: Value) -> Scalar:
        return self._real(np.asarray(value))

    def _reset(self, given: Mapping[str, Value]) -> Status:
        status = check_port(self._ports["reset"]["position"], given["position"], self.precision)
        self.ready = status is Status.OK
        self._rest(self._scalar(given["position"]) if self.ready else self._real(0.0))
        return status

    def _step(self, given: Mapping[str, Value]) -> Status:
        if not self.ready:
            return Status.NOT_READY
        ports = self._ports["step"]
        seen = check_port(ports["position"], given["position"], self.precision)
        told = check_port(ports["reference"], given["reference"], self.precision)
        zero = self._real(0.0)
        speed = zero
        if seen is Status.OK:
            position = self._scalar(given["position"])
            speed = self._wrapping.shortest(position - self.last) * self._c["rate"]
            self.last = position
        status = max(seen, told)
        if status is Status.OK:
            error = self._wrapping.shortest(self._scalar(given["reference"]) - self.last)
            self._speed_loop(self._c["position_gain"] * error - speed)
        else:
            self.integral, self.wanted = zero, zero
        return status

    def _speed_loop(self, error: Scalar) -> None:
        low, high = self._c["limit_low"], self._c["limit_high"]
        direct = self._c["velocity_gain"] * error
        integral = self.integral + self._c["integral_gain"] * error
        wanted = direct + integral
        # beyond a limit only an error of its sign leads, as the integral stays within both
        if wanted > high:
            integral = self.integral
        if wanted < low:
            integral = self.integral
        self.integral = min(max(integral, low), high)
        self.wanted = min(max(direct + self.integral, low), high)

    def _filter(self) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, {"current": self._real(0.0)}
        c, wanted = self._c, self.wanted
        output = wanted
        if self.design.notch is not None:
            output = c["b0"] * wanted + self.memory_1
            first = (c["b1"] * wanted - c["a1"] * output) + self.memory_2
            second = c["b2"] * wanted - c["a2"] * output
            self.memory_1 = min(max(first, -c["most_1"]), c["most_1"])
            self.memory_2 = min(max(second, -c["most_2"]), c["most_2"])
        return Status.OK, {"current": min(max(output, c["limit_low"]), c["limit_high"])}
