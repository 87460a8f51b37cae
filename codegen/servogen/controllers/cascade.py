"""The cascade of paper 1, step by step; see ``cascade_design`` for what it is made of."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.cascade_design import CascadeDesign, declare_cascade
from servogen.controllers.design import Port, Status, Value
from servogen.controllers.fast_stage import FastStage
from servogen.controllers.governor import Governor
from servogen.controllers.governor_design import AXES
from servogen.controllers.mpc_design import state_bounds, state_ports
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.precision import FloatArray
from servogen.qp.ordered import matvec


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
        p = design.governor.precision
        self._a_columns = [cast(plant.a.T, p) for plant in design.plants]
        self._b = [cast(plant.b, p) for plant in design.plants]
        order = design.governor.order
        self._bound = [cast(state_bounds(order, lim), p) for lim in design.governor.limits]
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
        self.offered = 0
        self.planned = False
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
            case "predict":
                return self._predict(given)
            case "plan":
                return self._plan(given)
            case "start":
                return self._start()
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
        status, outputs = self._plan(given)
        if self.planned:
            status, interval = self._begin(status)
            outputs["interval_points"] = interval
        outputs["pending"] = self.pending
        return status, outputs

    def _plan(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, self._outputs()
        measured = self._measured(given)
        self.offered = int(np.asarray(given["n_points"]))
        complete = self.priming == 0
        step = self._mpc_step if self.mpc else self._sprg_step
        result = step(given, measured)
        self.planned = complete
        return result

    def _start(self) -> tuple[Status, dict[str, Value]]:
        status, interval = Status.NOT_READY, 0
        if self.planned:
            status, interval = self._begin(Status.OK)
        return status, {
            "command_x": self.command[0],
            "command_y": self.command[1],
            "interval_points": interval,
            "pending": self.pending,
        }

    def _predict(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        """A x + B u from the measured state; from the last one used where it is not usable."""
        ports = self.declaration.operation("predict").inputs
        precision = self.design.governor.precision
        status = max(check_port(port, given[port.name], precision) for port in ports)
        states = self.state
        if status is Status.OK:
            values = np.array([given[port.name] for port in ports], dtype=self._real)
            states = [np.array(part) for part in np.split(values, 2)]
        ahead = [self._ahead(i, state) for i, state in enumerate(states)]
        if not self.ready:
            status = Status.NOT_READY
        return Status(status), dict(zip(self._names, np.concatenate(ahead), strict=True))

    def _ahead(self, i: int, state: FloatArray) -> FloatArray:
        """(11): where the present command of axis i leads in one period."""
        return matvec(self._a_columns[i], state) + self._b[i] * self.command[i]

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
        inputs["n_points"] = given["n_points"] if usable else 0
        inputs |= self._first_points(given, inputs["n_points"])
        status, outputs = self.governor.call("step", inputs)
        push = self._first_points(given, outputs["points_taken"])
        pushed = self.fast.call("push", {**push, "n_points": outputs["points_taken"]})[0]
        if pushed is not Status.OK:  # nothing was queued, so nothing may be taken
            outputs = {"points_taken": 0}
            for i, axis in enumerate(AXES):
                for name in ("reference", "low", "high"):
                    outputs[f"{name}_{axis}"] = self.reference[i][-1]
        status = max(status, pushed)
        self._pend(int(np.asarray(outputs["points_taken"])))
        for i, axis in enumerate(AXES):
            for queue, name in (
                (self.reference, "reference"),
                (self.low, "low"),
                (self.high, "high"),
            ):
                queue[i] = np.append(queue[i][1:], outputs[f"{name}_{axis}"]).astype(self._real)
        return status, outputs

    def _pend(self, points: int) -> None:
        """Points taken (or, negative, begun); never below none or above what the queue holds."""
        most = self.design.fast.intervals * self.design.governor.points
        self.pending = min(max(self.pending + points, 0), most)

    def _first_points(self, given: Mapping[str, Value], count: Value) -> dict[str, Value]:
        """The first ``count`` points of both axes, zeros behind them."""
        first = np.arange(self.design.governor.points) < int(np.asarray(count))
        zero = self._real(0.0)
        return {
            f"points_{a}": np.where(first, np.asarray(given[f"points_{a}"], self._real), zero)
            for a in AXES
        }

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
        statuses, iterations = [measured] * 2, [0, 0]
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
        return status, self._outputs(
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
        if measured is not Status.OK:  # fast_step may be at work on the fast stage's model
            ahead = [self._ahead(i, state) for i, state in enumerate(self.state)]
            self.state = [
                np.minimum(np.maximum(state, -bound), bound)
                for state, bound in zip(ahead, self._bound, strict=True)
            ]
        # the next interval's feed is not known yet: only as many points as can follow this one's
        offer = dict(given)
        if int(np.asarray(given["n_points"])) <= self.design.governor.points:
            offer["n_points"] = min(int(np.asarray(given["n_points"])), self.fast.room())
        status, govern = self._govern(offer, self.state, measured is Status.OK)
        self.command = [self.reference[i][-1] for i in range(2)]
        return max(measured, status), self._outputs(
            points_taken=govern["points_taken"], status_x=int(measured), status_y=int(measured)
        )

    def _begin(self, status: Status) -> tuple[Status, int]:
        """Start the fast stage's next interval; FINISHED when nothing is left."""
        inputs: dict[str, Value] = dict(zip(self._names, np.concatenate(self.state), strict=True))
        for i, axis in enumerate(AXES):
            inputs[f"slow_command_{axis}"] = self.command[i]
        began, out = self.fast.call("begin", inputs)
        interval = int(np.asarray(out["interval_points"]))
        status = max(status, began)
        if status is Status.OK and self.pending == 0 and self.offered == 0:
            status = Status.FINISHED
        self._pend(-interval)
        self.planned = False
        return status, interval
