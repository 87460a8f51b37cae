"""Tracking MPC (16) of one axis; Corollary 1 is what its solver falls back on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.design import Status, Value
from servogen.controllers.mpc_design import POSITION_FACTOR, MpcDesign, declare_mpc, state_bounds
from servogen.controllers.mpc_solver import mpc_solver
from servogen.precision import FloatArray
from servogen.qp.ordered import matvec


class TrackingMpc:
    """Reference of the emitted MPC, bit for bit; see ``declare_mpc`` for its operations."""

    def __init__(self, design: MpcDesign) -> None:
        self.design = design
        self.declaration = declare_mpc(design)
        self._real = design.precision.dtype.type
        p = design.precision
        self._a_columns = cast(design.plant.a.T, p)
        self._b = cast(design.plant.b, p)
        self._terminal_reference = cast(design.qp.terminal_reference, p)
        self._terminal_position = cast(design.qp.terminal_position, p)
        self._terminal_bound = cast(design.qp.terminal_bound, p)
        self._bound = cast(state_bounds(design.plant.order, design.limits), p)
        self._names = [port.name for port in self.declaration.operation("candidate").inputs]
        self.ready = False
        self.plan = np.zeros(design.horizon, dtype=p.dtype)
        self.predicted = np.zeros(design.plant.order, dtype=p.dtype)
        self._start_scale = cast(1.0 / design.qp.state_scale, p)
        self.solver = mpc_solver(design)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self.reset(given["position"]), {}
            case "seed":
                status = self._check(operation, given)
                usable = status is Status.OK
                self.seed(self._real(given["command"]) if usable else self.plan[-1])
                return status, {}
            case "candidate":
                status = self._check(operation, given)
                state = self._state(given) if status is Status.OK else self.predicted
                return status, dict(zip(self._names, self.candidate(state), strict=True))
            case "hold":
                status = self._check(operation, given)
                usable = status is Status.OK
                command, state = self.hold(
                    self._real(given["reference"]) if usable else self.plan[-1]
                )
                outputs: dict[str, Value] = dict(zip(self._names, state, strict=True))
                return status, {"command": command, **outputs}
            case "step":
                return self._checked_step(given)
        raise KeyError(operation)

    def _check(self, operation: str, inputs: Mapping[str, Value]) -> Status:
        ports = self.declaration.operation(operation).inputs
        return max(check_port(port, inputs[port.name], self.design.precision) for port in ports)

    def _state(self, inputs: Mapping[str, Value]) -> FloatArray:
        return np.array([inputs[name] for name in self._names], dtype=self.design.precision.dtype)

    def _checked_step(self, inputs: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        real = self._real
        nothing: dict[str, Value] = {"command": self.plan[0], "iterations": 0}
        if not self.ready:
            return Status.NOT_READY, nothing
        status = self._check("step", inputs)
        if status is not Status.OK:
            return status, {"command": self.hold(self.plan[-1])[0], "iterations": 0}
        as_real = {k: np.asarray(inputs[k], dtype=real) for k in ("reference", "low", "high")}
        status, command, iterations = self.step(
            self._state(inputs), as_real["reference"], as_real["low"], as_real["high"]
        )
        return status, {"command": command, "iterations": iterations}

    def reset(self, position: Value) -> Status:
        port = self.declaration.operation("reset").inputs[0]
        status = check_port(port, position, self.design.precision)
        self.ready = status is Status.OK
        where = self._real(position) if self.ready else self._real(0.0)
        self.plan = np.full(self.design.horizon, where, dtype=self._real)
        self.predicted = np.zeros_like(self.predicted)
        self.predicted[0] = where
        self.solver.forget()
        return status

    def advance(self, state: FloatArray, command: np.floating) -> FloatArray:
        """A x + B u of (11)."""
        result: FloatArray = matvec(self._a_columns, state) + self._b * command
        return result

    def seed(self, command: np.floating) -> None:
        """Shift the plan and append ``command``; the machine stands meanwhile."""
        self.plan = np.append(self.plan[1:], command)

    def candidate(self, state: FloatArray) -> FloatArray:
        """(n,) state after the commands u_1..u_{N-1} of the last plan, from ``state``."""
        for command in self.plan[1:]:
            state = self.advance(state, command)
        return state

    def hold(self, reference: np.floating) -> tuple[np.floating, FloatArray]:
        """Command of the shifted plan and the state (n,) it is predicted to meet."""
        state = self.predicted
        self._accept(state, np.append(self.plan[1:], reference))
        return self.plan[0], state

    def _accept(self, state: FloatArray, plan: FloatArray) -> None:
        limit = self._real(self.design.limits.position_m * POSITION_FACTOR)
        self.plan = np.minimum(np.maximum(plan, -limit), limit)
        ahead = self.advance(state, self.plan[0])
        self.predicted = np.minimum(np.maximum(ahead, -self._bound), self._bound)

    def step(
        self, state: FloatArray, reference: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[Status, np.floating, int]:
        """State (n,), references (N+1,), position bounds (N,); all absolute, in metres."""
        d = self.design
        origin, rest = state[0], state[1:]
        relative = reference - origin
        free = matvec(d.plan_state, rest) + matvec(d.plan_reference, relative)
        below, above = self._bounds(origin, relative, low, high)
        start = self._start(state)
        answer = self.solver.solve(free, start, below, above)
        status = answer.status
        if answer.z is not None:
            plan = answer.z + origin
        else:
            plan = np.append(self.plan[1:], reference[-1])
            status = self._judge(plan - origin, start, below, above)
        self._accept(state, plan)
        return status, self.plan[0], answer.iterations

    def _bounds(
        self, origin: np.floating, relative: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Bounds of the rows (m,), drawn in by the margin."""
        real, d = self._real, self.design
        m = d.rows
        per_step, first = d.qp.rows_per_step, m - d.qp.terminal_rows
        scale, margin = real(1.0 / d.limits.fast_range_m), real(d.tol.margin)
        above = np.ones(m, dtype=real) - margin
        below = -above
        above[0:first:per_step] = (high - origin) * scale - margin
        below[0:first:per_step] = (low - origin) * scale + margin
        centre = self._terminal_reference * relative[-1] + self._terminal_position * origin
        above[first:] = (self._terminal_bound - centre) - margin
        below[first:] = (-self._terminal_bound - centre) + margin
        return below, above

    def _start(self, state: FloatArray) -> FloatArray:
        """(n,) what the rows start from: the state in their units, from its own position on."""
        start = state * self._start_scale
        start[0] = self._real(0.0)
        return start

    def _judge(
        self, relative: FloatArray, start: FloatArray, below: FloatArray, above: FloatArray
    ) -> Status:
        """BACKUP where the plan, relative to the position, keeps the true bounds."""
        rows = self.design.solver.rows.product(relative, start)
        margin = self._real(self.design.tol.margin)
        inside = np.all(rows <= above + margin) and np.all(rows >= below - margin)
        return Status.BACKUP if inside else Status.INFEASIBLE
