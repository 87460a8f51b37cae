"""Extended command governor (17)-(18) of both axes; see ``command_governor_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import check_port
from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_declaration import AXES, declare_command_governor
from servogen.controllers.command_governor_design import AxisGovernorDesign, CommandGovernorDesign
from servogen.controllers.command_governor_path import IntArray, Reach, predicted_indices
from servogen.controllers.design import Status, Value
from servogen.controllers.mpc_design import POSITION_FACTOR
from servogen.precision import FloatArray


class CommandGovernor:
    """Reference of both axes; see ``declare_command_governor`` for its operations."""

    def __init__(self, design: CommandGovernorDesign) -> None:
        self.design = design
        self.declaration = declare_command_governor(design)
        self.axes = (AxisGovernor(design.axes[0]), AxisGovernor(design.axes[1]))
        self._real = design.precision.dtype.type
        self.planned = np.zeros(design.axes[0].intervals, dtype=np.int64)
        self.last = np.zeros(2, dtype=self._real)
        self.home = self.last.copy()  # its reference
        self.lost = False

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self.reset([given[f"position_{axis}"] for axis in AXES]), {}
            case "predict":
                return self._predict(given)
            case "step":
                return self._checked_step(given)
        raise KeyError(operation)

    def reset(self, position: list[Value]) -> Status:
        status = max(axis.reset(p) for axis, p in zip(self.axes, position, strict=True))
        self.planned[:] = 0
        self.last = np.array([axis.plan[0] for axis in self.axes])
        self.home = self.last.copy()
        self.lost = False
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
            return status, self._unusable(status, inputs)
        dtype = precision.dtype
        points = [np.asarray(inputs[f"points_{a}"], dtype=dtype)[:count] for a in AXES]
        slow = [np.asarray(inputs[f"slow_{a}"], dtype=dtype)[:count] for a in AXES]
        return self.step(self._states(inputs), points, slow)

    def _states(self, inputs: Mapping[str, Value]) -> list[FloatArray]:
        """(n,) of each axis: as measured, or where its own model expects it if that is no use."""
        precision, states = self.design.precision, []
        for name, axis in zip(AXES, self.axes, strict=True):
            own = [(port, inputs[f"{name}_{port.name}"]) for port in axis.state_ports]
            usable = all(check_port(port, value, precision) is Status.OK for port, value in own)
            measured = np.array([value for _, value in own], dtype=precision.dtype)
            states.append(measured if usable else axis.predicted.copy())
        return states

    def _unusable(self, status: Status, inputs: Mapping[str, Value]) -> dict[str, Value]:
        """A period without the points, which may be what is unusable: the tool waits, and the plan
        is one that keeps it in reach."""
        none = [np.zeros(0, dtype=self._real)] * 2
        _, outputs = self.step(self._states(inputs), none, none)
        return outputs | {f"status_{axis}": int(status) for axis in AXES}

    def _predict(self, inputs: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        """Of each axis by itself: one without a usable measurement goes on from its own model."""
        worst, outputs = Status.OK, dict[str, Value]()
        for name, axis in zip(AXES, self.axes, strict=True):
            own = {p.name: inputs[f"{name}_{p.name}"] for p in axis.state_ports}
            status, ahead = axis.call("predict", own)
            worst = max(worst, status)
            outputs |= {f"{name}_{key}": value for key, value in ahead.items()}
        return worst, outputs

    def step(
        self, states: list[FloatArray], points: list[FloatArray], slow: list[FloatArray]
    ) -> tuple[Status, dict[str, Value]]:
        """States (n,), the points after the last one machined and their (19), (n_points,)."""
        own = [np.append(self.last[i], points[i]).astype(self._real) for i in range(2)]
        reach = [axis.foresee(state) for axis, state in zip(self.axes, states, strict=True)]
        planned = np.minimum(self.planned, points[0].size)
        self.lost = self.lost and not self._back(reach)
        indices = predicted_indices(
            (own[0], own[1]), (reach[0], reach[1]), planned, self.design.points
        )
        found, iterations = [], []
        for i, axis in enumerate(self.axes):
            reference = self._reference(np.append(self.last[i], slow[i]), indices)
            low, high = self._stroke(axis.design, own[i].astype(self._real), indices)
            if self.lost:
                far = self._far(axis.design) + self._real(axis.design.program.stroke_m)
                low, high = np.full_like(low, -far), np.full_like(high, far)
                reference = np.full_like(reference, self.home[i])
            status, count = axis.step(states[i], reference.astype(self._real), low, high)
            found.append(status)
            iterations.append(count)
        taken = int(indices[1])
        status = max(*found, Status.INFEASIBLE) if self.lost else max(found)
        self.lost = status is Status.INFEASIBLE
        if self.lost:
            # the moved plan does not keep what these points ask for: the tool waits
            taken = 0
            self.planned[:] = 0
        else:
            self.planned = np.append(indices[1:], indices[-1]) - taken
        self.last = np.array([path[taken] for path in own])
        if taken:
            self.home = np.array([part[taken - 1] for part in slow]).astype(self._real)
        return self._told(status, points[0].size, indices), self._outputs(taken, found, iterations)

    def _told(self, status: Status, count: int, indices: IntArray) -> Status:
        """Of a period that went well: whether there is no point, or none in reach."""
        if status >= Status.BACKUP:
            return status
        if count == 0:
            return Status.FINISHED
        standing = all(axis.standing for axis in self.axes)
        return Status.UNREACHABLE if indices[-1] == 0 and standing else status

    def _back(self, reach: list[Reach]) -> bool:
        """Whether the moved plans keep the tool, where it waits, in reach for ever."""
        return all(
            bool(np.all((axis.least <= last) & (last <= axis.greatest)))
            for axis, last in zip(reach, self.last, strict=True)
        )

    def _far(self, design: AxisGovernorDesign) -> np.floating:
        """No point is farther from zero, m."""
        far: np.floating = self._real(design.reach.position_m * POSITION_FACTOR)
        return far

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
