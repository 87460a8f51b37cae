"""The two methods that solve the program of a tracking MPC, as its reference runs them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servogen.controllers.design import Status
from servogen.controllers.mpc_design import MpcDesign
from servogen.precision import FloatArray
from servogen.qp import active_set_factor, dual_active_set, pqp
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.qp.pqp import PqpTables


@dataclass(frozen=True)
class Answer:
    """``z`` (N,) the plan relative to the position; None, with status BACKUP: none was found."""

    z: FloatArray | None
    status: Status
    iterations: int


class MpcSolver(Protocol):
    """One method, with what a call leaves to the next."""

    def forget(self) -> None:
        """What the last call left."""
        ...

    def solve(
        self, free: FloatArray, start: FloatArray, below: FloatArray, above: FloatArray
    ) -> Answer:
        """From the unconstrained optimum ``free`` (N,), the state ``start`` (n,) of the plant
        behind the rows, and their bounds (m,)."""
        ...


def mpc_solver(design: MpcDesign) -> MpcSolver:
    """The one that the design has tables of."""
    if isinstance(design.solver, ActiveSetTables):
        return ActiveSetSolver(design.solver)
    return PqpSolver(design, design.solver)


class PqpSolver:
    """(20)-(21), from the last duals one sample on."""

    def __init__(self, design: MpcDesign, tables: PqpTables) -> None:
        self.design, self.tables = design, tables
        self.forget()

    def forget(self) -> None:
        self.upper, self.lower = np.array(self.tables.floor), np.array(self.tables.floor)

    def solve(
        self, free: FloatArray, start: FloatArray, below: FloatArray, above: FloatArray
    ) -> Answer:
        tables, qp = self.tables, self.design.qp
        rows = tables.rows.product(free, start)
        slack_upper, slack_lower = above - rows, rows - below
        if np.all(slack_upper >= 0) and np.all(slack_lower >= 0):
            self.forget()
            return Answer(free, Status.OK, 0)
        shifted = (
            pqp.shift_duals(dual, qp.rows_per_step, qp.terminal_rows, tables.floor, tables.ceiling)
            for dual in (self.upper, self.lower)
        )
        result = pqp.solve(tables, self.design.tol, slack_upper, slack_lower, *shifted)
        self.upper, self.lower = result.upper, result.lower
        if not result.feasible:
            return Answer(None, Status.BACKUP, result.iterations)
        status = Status.OK if result.converged else Status.SUBOPTIMAL
        return Answer(free - result.correction, status, result.iterations)


class ActiveSetSolver:
    """The dual active-set method, from the last working set."""

    def __init__(self, tables: ActiveSetTables) -> None:
        self.tables = tables
        self.forget()

    def forget(self) -> None:
        self.work = active_set_factor.empty_set(self.tables)

    def drop_stalled(self) -> None:
        """A working set that ended in refinements is left."""
        self.work.size *= 1 - int(self.work.stalled)
        self.work.stalled = False

    def solve(
        self,
        free: FloatArray,
        start: FloatArray,
        below: FloatArray,
        above: FloatArray,
        resume: bool = False,
    ) -> Answer:
        """``resume``: go on from where the last call ended at its cap."""
        result = dual_active_set.solve(self.tables, self.work, free, below, above, start, resume)
        if not result.optimal:
            return Answer(None, Status.BACKUP, result.iterations)
        return Answer(result.z, Status.OK, result.iterations)
