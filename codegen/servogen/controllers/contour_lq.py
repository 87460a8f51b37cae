"""Receding-horizon LQ contour control, step by step; see ``contour_tables`` for the law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port, scalar_type
from servogen.controllers.contour_axis import AxisModel
from servogen.controllers.contour_law import Law, SlidingLaw
from servogen.controllers.contour_lq_declaration import declare_contour_lq
from servogen.controllers.contour_lq_design import HIDDEN_BOUND, ContourAxis, ContourLqDesign
from servogen.controllers.contour_table import TabulatedLaw
from servogen.controllers.contour_tangent import Course
from servogen.controllers.design import Status, Value
from servogen.precision import FloatArray, Precision
from servogen.qp.ordered import dot, matvec


class AxisFilter:
    """Estimate of one axis: position less the last measured, and the hidden states."""

    def __init__(self, axis: ContourAxis, reach: float, p: Precision) -> None:
        real, model, observer = scalar_type(p), axis.model, axis.observer
        self._gain, self._gain_hidden = real(observer.on_position), cast(observer.on_hidden, p)
        self._drift, self._drive = real(model.drift[0]), real(model.b[0])
        self._hidden_drift, self._hidden_drive = cast(model.drift[1:], p), cast(model.b[1:], p)
        self._on_hidden, self._moves = cast(model.a[1:, 1:].T, p), cast(model.a[0, 1:], p)
        self._bound, self._far = real(HIDDEN_BOUND), real(2.0 * reach)
        self._real, self._dtype = real, p.dtype
        self.rest(0.0)

    def rest(self, position: float) -> None:
        self.last, self.ahead = self._real(position), self._real(0.0)
        self.hidden = np.zeros(self._moves.size, dtype=self._dtype)

    def measure(self, position: float) -> None:
        here = self._real(position)
        innovation = (here - self.last) - self.ahead
        self.hidden = self._within(self.hidden + self._gain_hidden * innovation)
        self.ahead, self.last = self._near(self._gain * innovation), here

    def predict(self, command: np.floating) -> None:
        """The next sample's, under a command that is held till then."""
        position = self.last + self.ahead
        ahead = (self.ahead + self._drift * position) + self._drive * command
        if self.hidden.size:
            ahead = ahead + dot(self._moves, self.hidden)
            moved = matvec(self._on_hidden, self.hidden)
            driven = self._hidden_drift * position + self._hidden_drive * command
            self.hidden = self._within(moved + driven)
        self.ahead = self._near(ahead)

    def _within(self, hidden: FloatArray) -> FloatArray:
        result: FloatArray = np.minimum(np.maximum(hidden, -self._bound), self._bound)
        return result

    def _near(self, ahead: np.floating) -> np.floating:
        return min(max(ahead, -self._far), self._far)


class ContourLq:
    """Reference of the emitted controller; see ``declare_contour_lq`` for its operations.

    An input that cannot be used gives the command zero: inputs are velocities, and one held
    without a position to close the loop, or without a path, would run the axis into its end. A
    usable measurement beside an unusable reference still corrects the estimate.
    """

    def __init__(self, design: ContourLqDesign) -> None:
        self.design = design
        self.declaration = declare_contour_lq(design)
        p = design.precision
        real = scalar_type(p)
        self._dtype, self._zero = p.dtype, real(0.0)
        table = design.table
        self.law: Law = TabulatedLaw(design, table) if table else SlidingLaw(design)
        self.filters = tuple(AxisFilter(axis, design.reach, p) for axis in design.axes)
        self.models: tuple[AxisModel, ...] = tuple(axis.model for axis in design.axes)
        self._limits = tuple(real(model.input_limit) for model in self.models)
        self._ports = {
            op.name: {port.name: port for port in op.inputs} for op in self.declaration.operations
        }
        self.ready = False
        self._forget()

    def _forget(self) -> None:
        self.begun = False
        zeros = np.zeros(len(self.filters), dtype=self._dtype)
        self.course = Course(zeros, zeros)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self._reset(given), {}
            case "step":
                return self._step(given)
            case "follow":
                return self._follow(given)
        raise KeyError(operation)

    def _check(self, operation: str, name: str, given: Mapping[str, Value]) -> Status:
        return check_port(self._ports[operation][name], given[name], self.design.precision)

    def _values(self, value: Value) -> FloatArray:
        return np.atleast_1d(np.asarray(value)).astype(self._dtype)

    def _reset(self, given: Mapping[str, Value]) -> Status:
        status = self._check("reset", "position", given)
        self.ready = status is Status.OK
        position = self._values(given["position"])
        for axis, where in zip(self.filters, position, strict=True):
            axis.rest(where if self.ready else 0.0)
        self._forget()
        return status

    def _step(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, self._outputs([self._zero] * len(self.filters), 0, 0)
        seen = self._check("step", "position", given)
        told = self._check("step", "reference", given)
        if seen is Status.OK:
            for axis, where in zip(self.filters, self._values(given["position"]), strict=True):
                axis.measure(where)
        hidden = [axis.hidden for axis in self.filters]
        ahead = [axis.ahead for axis in self.filters]
        last = [axis.last for axis in self.filters]
        status, outputs = self._answer(max(seen, told), given, last, ahead, hidden)
        for axis, command in zip(self.filters, np.asarray(outputs["command"]), strict=True):
            axis.predict(command)
        return status, outputs

    def _follow(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, self._outputs([self._zero] * len(self.filters), 0, 0)
        status = max(self._check("follow", name, given) for name in self._ports["follow"])
        ends = np.cumsum([model.hidden for model in self.models])
        told = (
            self._values(given["hidden"]) if self.design.hidden else np.zeros(0, dtype=self._dtype)
        )
        hidden = np.split(told, ends[:-1])
        position = list(self._values(given["position"]))
        return self._answer(status, given, position, [self._zero] * len(hidden), hidden)

    def _answer(
        self,
        status: Status,
        given: Mapping[str, Value],
        last: list[np.floating],
        ahead: list[np.floating],
        hidden: list[FloatArray],
    ) -> tuple[Status, dict[str, Value]]:
        """PRIMING: no direction of the contour is known, all errors count alike."""
        if status is not Status.OK:
            return status, self._outputs([self._zero] * len(self.filters), 0, 0)
        points = self._values(given["reference"]).reshape(-1, len(self.filters))
        relative = [
            np.concatenate([(points[1:, a] - last[a]) - ahead[a], [last[a] + ahead[a]], hidden[a]])
            for a in range(len(hidden))
        ]
        if not self.begun:
            self.course = Course(points[0].copy(), np.zeros_like(points[0]))
            self.begun = True
        commands, known, self.course = self.law(points, self.course, relative)
        bounded = [
            min(max(u, -limit), limit) for u, limit in zip(commands, self._limits, strict=True)
        ]
        limited = sum(int(u != v) for u, v in zip(commands, bounded, strict=True))
        return Status.OK if known else Status.PRIMING, self._outputs(bounded, limited, known)

    def _outputs(self, commands: list[np.floating], limited: int, known: int) -> dict[str, Value]:
        command = np.array(commands, dtype=self._dtype)
        return {"command": command, "limited": limited, "known": known}
