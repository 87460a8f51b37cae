"""Extended command governor (17)-(18), step by step; see ``command_governor_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.command_governor_design import (
    AXES,
    AxisGovernorDesign,
    CommandGovernorDesign,
    cast_rows,
    declare_axis_governor,
    declare_command_governor,
    far_rows,
    stroke_rows,
)
from servogen.controllers.command_governor_path import IntArray, Reach, predicted_indices
from servogen.controllers.design import Status, Value
from servogen.controllers.mpc_design import POSITION_FACTOR, state_bounds
from servogen.controllers.mpc_solver import ActiveSetSolver
from servogen.precision import FloatArray
from servogen.qp.ordered import matvec


class AxisGovernor:
    """Reference of one axis; see ``declare_axis_governor`` for its operations."""

    def __init__(self, design: AxisGovernorDesign) -> None:
        self.design = design
        self.declaration = declare_axis_governor(design)
        p, program = design.precision, design.program
        self._real = p.dtype.type
        self._a_columns, self._b = cast(design.plant.a.T, p), cast(design.plant.b, p)
        self._bound = cast(state_bounds(design.plant.order, design.reach), p)
        self._start_scale = cast(1.0 / program.state_scale, p)
        self._limit, self._moves, self._settle = cast_rows(design)
        self._scale = self._real(1.0 / program.scale_m)
        self._names = [port.name for port in self.declaration.operation("foresee").inputs]
        self.solver = ActiveSetSolver(design.solver)
        self.plan = np.zeros(program.variables, dtype=p.dtype)
        self.predicted = np.zeros(design.plant.order, dtype=p.dtype)
        self.ready = False

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self.reset(given["position"]), {}
            case "foresee":
                status = self._check(operation, given)
                usable = status is Status.OK
                reach = self.foresee(self._state(given) if usable else self.predicted)
                return status, {"least": reach.least, "greatest": reach.greatest}
            case "hold":
                return Status.OK, {"command": self.hold()}
            case "step":
                return self._checked_step(given)
        raise KeyError(operation)

    def _check(self, operation: str, inputs: Mapping[str, Value]) -> Status:
        ports = self.declaration.operation(operation).inputs
        return max(check_port(port, inputs[port.name], self.design.precision) for port in ports)

    def _state(self, inputs: Mapping[str, Value]) -> FloatArray:
        return np.array([inputs[name] for name in self._names], dtype=self.design.precision.dtype)

    def _checked_step(self, inputs: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, {"command": self.plan[0], "iterations": 0}
        status = self._check("step", inputs)
        if status is not Status.OK:
            return status, {"command": self.hold(), "iterations": 0}
        dtype = self.design.precision.dtype
        reference, low, high = (
            np.asarray(inputs[name], dtype=dtype) for name in ("reference", "low", "high")
        )
        status, iterations = self.step(self._state(inputs), reference, low, high)
        return status, {"command": self.plan[0], "iterations": iterations}

    def reset(self, position: Value) -> Status:
        port = self.declaration.operation("reset").inputs[0]
        status = check_port(port, position, self.design.precision)
        self.ready = status is Status.OK
        where = self._real(position) if self.ready else self._real(0.0)
        self.plan = np.full_like(self.plan, where)
        self.predicted = np.zeros_like(self.predicted)
        self.predicted[0] = where
        self.solver.forget()
        return status

    def moved(self) -> FloatArray:
        """(V,) the plan one period on: the shifted register, the same rho."""
        return np.append(self.plan[1:], self.plan[-1])

    def foresee(self, state: FloatArray) -> Reach:
        """Points in reach of the moved plan from ``state`` (n,), interval by interval."""
        d = self.design
        origin = state[0]
        rows = d.solver.rows.product(self.moved() - origin, self._start(state))
        stroke, far = self._real(stroke_rows(d)), self._real(far_rows(d))
        lowest, highest = np.full(d.intervals, far), np.full(d.intervals, -far)
        # the position at which the first interval begins
        lowest[0] = highest[0] = self._real(0.0)
        for i, value in enumerate(rows):
            for interval in (int(d.program.first[i]), int(d.program.second[i])):
                if interval >= 0:
                    lowest[interval] = min(lowest[interval], value - self._settle[i])
                    highest[interval] = max(highest[interval], value + self._settle[i])
        unit = self._real(d.program.scale_m)
        return Reach((highest - stroke) * unit + origin, (lowest + stroke) * unit + origin)

    def hold(self) -> np.floating:
        """Command of the moved plan, from the state predicted."""
        self._accept(self.predicted, self.moved())
        command: np.floating = self.plan[0]
        return command

    def _accept(self, state: FloatArray, plan: FloatArray) -> None:
        far = self._real(self.design.reach.position_m * POSITION_FACTOR)
        self.plan = np.minimum(np.maximum(plan, -far), far)
        ahead = matvec(self._a_columns, state) + self._b * self.plan[0]
        self.predicted = np.minimum(np.maximum(ahead, -self._bound), self._bound)

    def step(
        self, state: FloatArray, reference: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[Status, int]:
        """State (n,), references (V,), positions allowed in every interval; absolute, m."""
        origin = state[0]
        below, above = self._bounds(origin, low, high)
        start = self._start(state)
        answer = self.solver.solve(reference - origin, start, below, above)
        status = answer.status
        if answer.z is not None:
            plan = answer.z + origin
        else:
            plan = self.moved()
            status = self._judge(plan - origin, start, below, above)
        self._accept(state, plan)
        return status, answer.iterations

    def _start(self, state: FloatArray) -> FloatArray:
        """(n + 1,) what the rows start from: the state in their units, positions from its own."""
        start = np.append(state, self._real(0.0)) * self._start_scale
        start[0] = self._real(0.0)
        return start

    def _bounds(
        self, origin: np.floating, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Bounds of the rows (m,), drawn in by the margin."""
        d, real = self.design, self._real
        middle = (real(d.program.centre_m) - origin) * self._scale
        above = self._moves * middle + self._limit
        below = self._moves * middle - self._limit
        relative_low, relative_high = (low - origin) * self._scale, (high - origin) * self._scale
        for interval in (d.program.first, d.program.second):
            used = interval >= 0
            at = interval[used]
            above[used] = np.minimum(above[used], relative_high[at] - self._settle[used])
            below[used] = np.maximum(below[used], relative_low[at] + self._settle[used])
        margin = real(d.tol.margin)
        return below + margin, above - margin

    def _judge(
        self, relative: FloatArray, start: FloatArray, below: FloatArray, above: FloatArray
    ) -> Status:
        """BACKUP where the plan, relative to the position, keeps the true bounds."""
        rows = self.design.solver.rows.product(relative, start)
        margin = self._real(self.design.tol.margin)
        inside = np.all(rows <= above + margin) and np.all(rows >= below - margin)
        return Status.BACKUP if inside else Status.INFEASIBLE


class CommandGovernor:
    """Reference of both axes; see ``declare_command_governor`` for its operations."""

    def __init__(self, design: CommandGovernorDesign) -> None:
        self.design = design
        self.declaration = declare_command_governor(design)
        self.axes = (AxisGovernor(design.axes[0]), AxisGovernor(design.axes[1]))
        self._real = design.precision.dtype.type
        self.planned = np.zeros(design.axes[0].intervals, dtype=np.int64)
        self.last = np.zeros(2, dtype=self._real)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self.reset([given[f"position_{axis}"] for axis in AXES]), {}
            case "step":
                return self._checked_step(given)
        raise KeyError(operation)

    def reset(self, position: list[Value]) -> Status:
        status = max(axis.reset(p) for axis, p in zip(self.axes, position, strict=True))
        self.planned[:] = 0
        self.last = np.array([axis.plan[0] for axis in self.axes])
        return status

    def _checked_step(self, inputs: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not all(axis.ready for axis in self.axes):
            return Status.NOT_READY, self._outputs(0, [Status.NOT_READY] * 2, [0, 0])
        precision = self.design.precision
        status = Status.OK
        count = int(np.asarray(inputs["n_points"]))
        for port in self.declaration.operation("step").inputs:
            value = inputs[port.name]
            if port.size:
                value = np.asarray(value)[: min(max(count, 0), port.size)]
            status = max(status, check_port(port, value, precision))
        if status is not Status.OK:
            return status, self._without_measurement(status)
        n, dtype = self.design.axes[0].plant.order, precision.dtype
        names = [port.name for port in self.declaration.operation("step").inputs]
        states = [
            np.array([inputs[name] for name in names[i * n : (i + 1) * n]], dtype=dtype)
            for i in range(2)
        ]
        points = [np.asarray(inputs[f"points_{a}"], dtype=dtype)[:count] for a in AXES]
        slow = [np.asarray(inputs[f"slow_{a}"], dtype=dtype)[:count] for a in AXES]
        return self.step(states, points, slow)

    def _without_measurement(self, status: Status) -> dict[str, Value]:
        """Both moved plans, and the points that they were made for: none, they may be unusable."""
        for axis in self.axes:
            axis.hold()
        self.planned[:] = 0
        return self._outputs(0, [status] * 2, [0, 0])

    def step(
        self, states: list[FloatArray], points: list[FloatArray], slow: list[FloatArray]
    ) -> tuple[Status, dict[str, Value]]:
        """States (n,), the points after the last one machined and their (19), (n_points,)."""
        own = [np.append(self.last[i], points[i]).astype(self._real) for i in range(2)]
        reach = [axis.foresee(state) for axis, state in zip(self.axes, states, strict=True)]
        planned = np.minimum(self.planned, points[0].size)
        indices = predicted_indices(
            (own[0], own[1]), (reach[0], reach[1]), planned, self.design.points
        )
        found, iterations = [], []
        for i, axis in enumerate(self.axes):
            reference = self._reference(np.append(self.last[i], slow[i]), indices)
            low, high = self._stroke(axis.design, own[i].astype(self._real), indices)
            status, count = axis.step(states[i], reference.astype(self._real), low, high)
            found.append(status)
            iterations.append(count)
        taken = int(indices[1])
        if Status.INFEASIBLE in found:
            # the moved plan does not keep what these points ask for: the tool waits
            taken = 0
            self.planned[:] = 0
        else:
            self.planned = np.append(indices[1:], indices[-1]) - taken
        self.last = np.array([path[taken] for path in own])
        status = max(found)
        if status is Status.OK and points[0].size == 0:
            status = Status.FINISHED
        return status, self._outputs(taken, found, iterations)

    def _reference(self, slow: FloatArray, indices: IntArray) -> FloatArray:
        """(V,) of (21): the point after those machined in each interval, or the first of them."""
        ahead = indices[1:] if self.design.after else indices[:-1]
        reference: FloatArray = slow[np.minimum(ahead + 1, slow.size - 1)]
        return reference

    def _stroke(
        self, design: AxisGovernorDesign, points: FloatArray, indices: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """(intervals,) least and greatest position that keep S_k, m."""
        stroke = self._real(design.program.stroke_m)
        ends = np.append(indices[1:], indices[-1])
        parts = [points[a : b + 1] for a, b in zip(indices, ends, strict=True)]
        greatest = np.array([np.max(part) for part in parts])
        least = np.array([np.min(part) for part in parts])
        return greatest - stroke, least + stroke

    def _outputs(self, taken: int, status: list[Status], iterations: list[int]) -> dict[str, Value]:
        outputs: dict[str, Value] = {"points_taken": taken}
        for i, name in enumerate(AXES):
            outputs[f"command_{name}"] = self.axes[i].plan[0]
            outputs[f"status_{name}"] = int(status[i])
            outputs[f"iterations_{name}"] = iterations[i]
        return outputs
