"""Trajectory-tracking MPC of a servo axis, step by step; see ``servo_mpc_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.design import Status, Value
from servogen.controllers.servo_mpc_design import FirstMove, ServoMpcDesign, declare_servo_mpc
from servogen.controllers.tracking_qp import TrackingQp
from servogen.controllers.wrapping import Wrapping
from servogen.precision import FloatArray, Precision
from servogen.qp.ordered import matvec
from servogen.qp.parametric_solver import Optimum, ParametricSolver


class SolvedMove:
    """The first move by solving the program in float64: the reference of every lookup."""

    def __init__(self, problem: TrackingQp, precision: Precision) -> None:
        self._solver = ParametricSolver(problem.qp)
        self._inputs = problem.plant.inputs
        self._dtype = precision.dtype

    def optimum(self, theta: FloatArray) -> Optimum:
        """All H_u inputs, stacked, and the active rows."""
        return self._solver.solve(np.asarray(theta, dtype=np.float64))

    def __call__(self, theta: FloatArray) -> tuple[Status, FloatArray]:
        """See ``FirstMove``."""
        found = self.optimum(theta)
        status = Status.OK if found.feasible else Status.INFEASIBLE
        return status, found.z[: self._inputs].astype(self._dtype)


class ServoMpc:
    """Reference of the emitted controller, bit for bit but for what ``first_move`` adds.

    An unusable measurement leaves the filter to its prediction; any unusable input, or a program
    without solution, moves the current to zero (as fast as (11) allows): the axis runs out against
    its friction, and nothing that was not measured accelerates it.
    """

    def __init__(self, design: ServoMpcDesign, first_move: FirstMove) -> None:
        self.design = design
        self.declaration = declare_servo_mpc(design)
        self.first_move = first_move
        self.precision = p = design.precision
        plant, found = design.problem.plant, design.filter
        self._on_state = cast(plant.a.T, p)
        self._on_input = cast(plant.b.T, p)
        self._on_output = cast(plant.c.T, p)
        self._gain_state = cast(found.on_increment.T, p)
        self._gain_output = cast((found.on_output - np.eye(plant.outputs)).T, p)
        self._bound = cast(found.increment_bound, p)
        self._low, self._high = (
            cast(side, p) for side in (design.input_bounds.lower, design.input_bounds.upper)
        )
        self._fall, self._rise = (
            cast(side, p) for side in (design.change_bounds.lower, design.change_bounds.upper)
        )
        self._limits_change = design.problem.constraints.change is not None
        self._wrapping = Wrapping(design.turn, design.reach, p)
        self._ports = {
            op.name: {port.name: port for port in op.inputs} for op in self.declaration.operations
        }
        self.ready = False
        self.theta = np.zeros(design.problem.layout.size, dtype=p.dtype)
        self._rest(np.zeros(plant.outputs, dtype=p.dtype))

    def _rest(self, position: FloatArray) -> None:
        plant, dtype = self.design.problem.plant, self.precision.dtype
        self.increment = np.zeros(plant.order, dtype=dtype)
        self.drift = np.zeros(plant.outputs, dtype=dtype)
        self.last = position
        self.previous = np.zeros(plant.inputs, dtype=dtype)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self._reset(given), {}
            case "step":
                return self._step(given)
        raise KeyError(operation)

    def _values(self, value: Value) -> FloatArray:
        return np.atleast_1d(np.asarray(value)).astype(self.precision.dtype)

    def _reset(self, given: Mapping[str, Value]) -> Status:
        status = check_port(self._ports["reset"]["position"], given["position"], self.precision)
        self.ready = status is Status.OK
        position = self._values(given["position"])
        self._rest(position if self.ready else np.zeros_like(position))
        return status

    def _step(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        if not self.ready:
            return Status.NOT_READY, self._output(np.zeros_like(self.previous))
        ports = self._ports["step"]
        seen = check_port(ports["position"], given["position"], self.precision)
        told = check_port(ports["reference"], given["reference"], self.precision)
        if seen is Status.OK:
            self._measure(self._values(given["position"]))
        status = max(seen, told)
        wanted = np.zeros_like(self.previous)
        if status is Status.OK:
            self._parameter(self._values(given["reference"]))
            status, move = self.first_move(self.theta)
            if status is Status.OK:
                wanted = move
        current = self._bounded(wanted)
        self._predict(current)
        return status, self._output(current)

    def _output(self, current: FloatArray) -> dict[str, Value]:
        return {"current": current[0] if current.size == 1 else current.copy()}

    def _measure(self, position: FloatArray) -> None:
        # the turn comes off first, and exactly: what is left is as small wherever the axis stands
        innovation = self._shortest(self._shortest(position - self.last) - self.drift)
        self.last = position
        increment = self.increment + matvec(self._gain_state, innovation)
        self.increment = self._within(increment)
        self.drift = matvec(self._gain_output, innovation)

    def _parameter(self, reference: FloatArray) -> None:
        """Every reference is reached from the one before, the first from the measurement: the axis
        may lag by nearly half a turn without a reference seeming to lie behind it."""
        layout = self.design.problem.layout
        m = self.last.size
        self.theta[layout.increment] = self.increment
        self.theta[layout.previous] = self.previous
        if not self._wrapping.comes_round:
            ahead = (reference.reshape(-1, m) - self.last) - self.drift
        else:
            before = np.vstack([self.last, reference.reshape(-1, m)[:-1]])
            ways = self._shortest((reference.reshape(-1, m) - before).ravel()).reshape(-1, m)
            ahead = np.add.accumulate(ways, axis=0) - self.drift
        self.theta[layout.reference] = ahead.ravel()
        if self.design.problem.constraints.signal is not None:
            self.theta[layout.signal] = self.last + self.drift

    def _shortest(self, differences: FloatArray) -> FloatArray:
        ways = [self._wrapping.shortest(value) for value in differences]
        return np.array(ways, dtype=self.precision.dtype)

    def _within(self, increment: FloatArray) -> FloatArray:
        result: FloatArray = np.minimum(np.maximum(increment, -self._bound), self._bound)
        return result

    def _bounded(self, wanted: FloatArray) -> FloatArray:
        """Within (11) of the last input, then within (10), which it never leaves."""
        if self._limits_change:
            wanted = np.maximum(wanted, self.previous + self._fall)
            wanted = np.minimum(wanted, self.previous + self._rise)
        result: FloatArray = np.minimum(np.maximum(wanted, self._low), self._high)
        return result

    def _predict(self, current: FloatArray) -> None:
        moved = matvec(self._on_state, self.increment)
        moved = moved + matvec(self._on_input, current - self.previous)
        self.increment = self._within(moved)
        drift = self.drift + matvec(self._on_output, self.increment)
        if self._wrapping.comes_round:
            drift = self._shortest(drift)
        else:
            reach = self.precision.dtype.type(2.0 * self.design.reach)
            drift = np.minimum(np.maximum(drift, -reach), reach)
        self.drift = drift
        self.previous = current
