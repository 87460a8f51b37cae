"""One axis of the extended command governor (17), step by step; see its program for the rows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.command_governor_declaration import declare_axis_governor
from servogen.controllers.command_governor_design import AxisGovernorDesign
from servogen.controllers.command_governor_path import Reach
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
        self._limit, self._moves = cast(program.limit, p), cast(program.position, p)
        self.centre = self._real(program.centre_m)
        self._settle = cast(program.settle, p)
        self._scale = self._real(1.0 / program.scale_m)
        self.state_ports = self.declaration.operation("predict").inputs
        self._names = [port.name for port in self.state_ports]
        self.solver = ActiveSetSolver(design.solver)
        self.plan = np.zeros(program.variables, dtype=p.dtype)
        self.predicted = np.zeros(design.plant.order, dtype=p.dtype)
        self.ready = False
        self.standing = False  # at the end of its plan, which the last step left there
        self.waited = 0  # steps in a row that were at the cap besides: the next one goes on there

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
            case "predict":
                status = self._check(operation, given)
                usable = status is Status.OK
                ahead = self.advance(self._state(given)) if usable else self.predicted
                return status, dict(zip(self._names, ahead, strict=True))
            case "step":
                return self._checked_step(given)
        raise KeyError(operation)

    def _check(self, operation: str, inputs: Mapping[str, Value]) -> Status:
        if not self.ready:
            return Status.NOT_READY
        ports = self.declaration.operation(operation).inputs
        return max(check_port(port, inputs[port.name], self.design.precision) for port in ports)

    def _state(self, inputs: Mapping[str, Value]) -> FloatArray:
        return np.array([inputs[name] for name in self._names], dtype=self.design.precision.dtype)

    def _checked_step(self, inputs: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, {"command": self.centre, "iterations": 0, "standing": 0}
        status = self._check("step", inputs)
        if status is not Status.OK:
            return status, {"command": self.hold(), "iterations": 0, "standing": 0}
        dtype = self.design.precision.dtype
        reference, low, high = (
            np.asarray(inputs[name], dtype=dtype) for name in ("reference", "low", "high")
        )
        status, iterations = self.step(self._state(inputs), reference, low, high)
        told = {"command": self.plan[0], "iterations": iterations, "standing": int(self.standing)}
        return status, told

    def reset(self, position: Value) -> Status:
        port = self.declaration.operation("reset").inputs[0]
        status = check_port(port, position, self.design.precision)
        self.ready = status is Status.OK
        where = self._real(position) if self.ready else self.centre
        self.plan = np.full_like(self.plan, where)
        self.predicted = np.zeros_like(self.predicted)
        self.predicted[0] = where
        self.solver.forget()
        self.waited = 0
        return status

    def moved(self) -> FloatArray:
        """(V,) the plan one period on: the shifted register, the same rho."""
        return np.append(self.plan[1:], self.plan[-1])

    def foresee(self, state: FloatArray) -> Reach:
        """Points in reach of the moved plan from ``state`` (n,), interval by interval."""
        d = self.design
        origin = state[0]
        rows = d.solver.rows.product(self.moved() - origin, self._start(state))
        stroke, far = self._real(d.in_reach), self._real(d.farthest)
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
        self._go_on_with_none()
        command: np.floating = self.plan[0]
        return command

    def _accept(self, state: FloatArray, plan: FloatArray) -> None:
        far = self._real(self.design.reach.position_m * POSITION_FACTOR)
        self.plan = np.minimum(np.maximum(plan, -far), far)
        self.predicted = np.minimum(np.maximum(self.advance(state), -self._bound), self._bound)

    def advance(self, state: FloatArray) -> FloatArray:
        """A x + B v(0) of the plan."""
        result: FloatArray = matvec(self._a_columns, state) + self._b * self.plan[0]
        return result

    def step(
        self, state: FloatArray, reference: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[Status, int]:
        """State (n,), references (V,), positions allowed in every interval; absolute, m."""
        origin = state[0]
        below, above = self._bounds(origin, low, high)
        start = self._start(state)
        answer = self.solver.solve(reference - origin, start, below, above, self.waited > 0)
        status = answer.status
        if answer.z is not None:
            plan = answer.z + origin
        else:
            plan = self.moved()
            status = self._judge(plan - origin, start, below, above)
        rest = self.plan[-1]
        self._accept(state, plan)
        self.standing = self._stands(origin, rest)
        return self._patient(status), answer.iterations

    def _patient(self, status: Status) -> Status:
        """A stage at rest has the same program again, as long as the points and so its bounds stay.
        Begun anew it would be at the cap for ever: the next step goes on with it. After
        ``patience`` steps the plan at rest is its answer."""
        patience = self.design.patience
        if self.standing and status is Status.BACKUP:
            self.waited = min(self.waited + 1, patience)
        else:
            self._go_on_with_none()
        return Status.SUBOPTIMAL if self.waited == patience else status

    def _go_on_with_none(self) -> None:
        """The next step begins anew; rows that rounding does not let hold are no beginning."""
        self.waited = 0
        self.solver.drop_stalled()

    def _stands(self, position: np.floating, rest: np.floating) -> bool:
        """Whether the stage is at the end of the plan before and the new one leaves it there."""
        near = self._real(self.design.standing_m)
        places = np.concatenate([[position], self.predicted[:1], self.plan])
        return bool(np.all((places >= rest - near) & (places <= rest + near)))

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
