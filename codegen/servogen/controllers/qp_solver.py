"""Reference of the emitted quadratic program; see ``qp_solver_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import check_port
from servogen.controllers.design import Status, Value
from servogen.controllers.qp_solver_design import QpSolverDesign, declare_qp_solver
from servogen.precision import FloatArray
from servogen.qp.active_set_factor import empty_set
from servogen.qp.dual_active_set import solve
from servogen.qp.ordered import matvec


class QpSolver:
    """The active-set method with its working set, bit for bit as in C."""

    def __init__(self, design: QpSolverDesign) -> None:
        self.design = design
        self.declaration = declare_qp_solver(design)
        self._zeros = np.zeros(design.tables.rows.variables, dtype=design.precision.dtype)
        self.work = empty_set(design.tables)
        self.z, self.ready = self._zeros, False

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        match operation:
            case "reset":
                self.work = empty_set(self.design.tables)
                self.z, self.ready = self._zeros, True
                return Status.OK, {}
            case "step":
                status, iterations = self._checked(inputs or {})
                return status, {"z": self.z, "iterations": iterations}
        raise KeyError(operation)

    def _checked(self, inputs: Mapping[str, Value]) -> tuple[Status, int]:
        if not self.ready:
            return Status.NOT_READY, 0
        ports, precision = self.declaration.operation("step").inputs, self.design.precision
        status = max(check_port(port, inputs[port.name], precision) for port in ports)
        if status is not Status.OK:
            return status, 0
        given = (np.asarray(inputs[port.name], dtype=precision.dtype) for port in ports)
        return self.step(*given)

    def step(self, linear: FloatArray, low: FloatArray, high: FloatArray) -> tuple[Status, int]:
        """f (N,), bounds (m,): the optimum to ``z``, or ``z`` as it was; iterations."""
        tables = self.design.tables
        free = -matvec(tables.inverse, linear)
        scale = self.design.scale
        result = solve(tables, self.work, free, low * scale, high * scale)
        if result.optimal:
            self.z = result.z
            return Status.OK, result.iterations
        return (Status.INFEASIBLE if result.infeasible else Status.BACKUP), result.iterations
