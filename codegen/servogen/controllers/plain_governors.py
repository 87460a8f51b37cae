"""Governors of one command that knows nothing of a path: (6) of paper 4 and its special cases.

- Extended command governor, any auxiliary dynamics (2): of all auxiliary states and final commands
  that keep the limits for ever, those of least |x - x_r|_Q^2 + |r - rho|_R^2.
- Command governor: no auxiliary state. The command is rho; with one command per axis the program is
  to take the end of an interval that is nearer.
- Scalar reference governor: the command moves towards r by the largest share of the way that all
  axes allow, one share for all of them. It never leaves the line from the last command to r, where
  a command governor may; of a single axis both give the same command.

Each falls back on what it was: the auxiliary state moved on with the same rho, the same command.
They are for comparison and run in Python alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.controllers.qp_solver_design import design_qp_solver
from servogen.plants.statespace import FloatArray
from servogen.precision import FLOAT64
from servogen.qp.active_set_factor import empty_set
from servogen.qp.dual_active_set import solve
from servogen.sets.extended import ExtendedSet

# Bounds are drawn in by this share of a limit, nine tenths of which an answer may use up.
MARGIN = 1e-6
# A command on the boundary of the set is outside a period later by what rows left out as implied
# may be passed by, 1e-9 of a limit, and by rounding.
ROUNDING = 1e-8


class ExtendedGovernor:
    """(6), and (17) without S_k, of one axis with any auxiliary dynamics.

    A reference that is known ahead is turned into the auxiliary state x_r whose sequence is nearest
    to it, which for orthonormal sequences (a shift register, Laguerre) is a product.

    Args:
        weight: (aux, aux) Q, symmetric, positive definite, never growing along the dynamics: what
            the convergence (c) rests on. reference_weight: R, above zero. cap: iterations.

    Raises:
        DesignError: weights of which (c) is not known, or no auxiliary state.
    """

    def __init__(
        self, admissible: ExtendedSet, weight: FloatArray, reference_weight: float, cap: int = 200
    ) -> None:
        order = admissible.auxiliary.order
        if order == 0:
            raise DesignError("auxiliary", "none", "states: without, use CommandGovernorLaw")
        if weight.shape != (order, order) or not admissible.auxiliary.never_grows(weight):
            expected = "positive definite and never growing along the auxiliary dynamics"
            raise DesignError("weight", f"of shape {weight.shape}", expected)
        if not reference_weight > 0.0:
            raise DesignError("reference_weight", reference_weight, "above zero")
        self.admissible = admissible
        hessian = np.zeros((order + 1, order + 1))
        hessian[:-1, :-1] = weight + weight.T
        hessian[-1, -1] = 2.0 * reference_weight
        own = np.column_stack([admissible.h_aux, admissible.h_rho])
        self._used = np.any(own != 0.0, axis=1)
        rows = own[self._used]
        norm = np.sqrt(np.einsum("ij,ij->i", rows, np.linalg.solve(hessian, rows.T).T))
        accept = 0.9 * MARGIN / float(np.max(norm))
        self._design = design_qp_solver("governor", FLOAT64, hessian, rows, cap, accept)
        self._work = empty_set(self._design.tables)
        self.auxiliary: FloatArray = np.zeros(order)
        self.rho = 0.0
        self.iterations = 0

    def reset(self, position: float) -> None:
        """Stand still at a position, m."""
        self._work = empty_set(self._design.tables)
        self.auxiliary = np.zeros_like(self.auxiliary)
        self.rho = position

    def wished(self, reference: FloatArray) -> FloatArray:
        """(aux,) x_r for ``reference`` (K + 1,): r of this period, of the next ones, and the last
        one for ever."""
        periods = reference.size - 1
        outputs = self.admissible.auxiliary.outputs(periods)
        result: FloatArray = outputs.T @ (reference[:-1] - reference[-1])
        return result

    def step(self, state: FloatArray, reference: FloatArray) -> tuple[Status, float]:
        """Status and command (m) from ``state`` (n,) for ``reference`` (K + 1,), K from 0 on, m."""
        target = self.admissible
        moved = state.copy()
        moved[0] -= target.centre_m
        at = (target.h_x @ moved)[self._used]
        free = np.append(self.wished(reference), reference[-1] - target.centre_m)
        scale, reach = self._design.scale, 1.0 - MARGIN
        found = solve(
            self._design.tables, self._work, free, (-reach - at) * scale, (reach - at) * scale
        )
        self.iterations = found.iterations
        if found.optimal:
            self.auxiliary, self.rho = (
                found.z[:-1].astype(np.float64),
                float(found.z[-1]) + target.centre_m,
            )
            return Status.OK, self.command
        self.auxiliary = target.auxiliary.a @ self.auxiliary
        inside = target.contains(state, self.auxiliary, self.rho)
        return Status.BACKUP if inside else Status.INFEASIBLE, self.command

    @property
    def command(self) -> float:
        """v of (2), m."""
        return float(self.admissible.auxiliary.c @ self.auxiliary) + self.rho


class CommandGovernorLaw:
    """The command governor of one axis: the admissible command nearest to r."""

    def __init__(self, admissible: ExtendedSet) -> None:
        _without_auxiliary(admissible)
        self.admissible = admissible
        self.command = 0.0

    def reset(self, position: float) -> None:
        """Stand still at a position, m."""
        self.command = position

    def step(self, state: FloatArray, reference: float) -> tuple[Status, float]:
        """Status and command (m) from ``state`` (n,); the last command where none is admissible."""
        least, most = self.admissible.interval(state, np.zeros(0))
        if least > most:
            inside = self.admissible.contains(state, np.zeros(0), self.command, ROUNDING)
            return Status.BACKUP if inside else Status.INFEASIBLE, self.command
        self.command = min(max(reference, least), most)
        return Status.OK, self.command


class ReferenceGovernor:
    """The scalar reference governor of any number of axes."""

    def __init__(self, admissible: Sequence[ExtendedSet]) -> None:
        for target in admissible:
            _without_auxiliary(target)
        self.admissible = tuple(admissible)
        self.command = np.zeros(len(self.admissible))
        self.share = 0.0

    def reset(self, position: FloatArray) -> None:
        """Stand still at a position (axes,), m."""
        self.command = np.array(position, dtype=np.float64)

    def step(
        self, states: Sequence[FloatArray], reference: FloatArray
    ) -> tuple[Status, FloatArray]:
        """Status and commands (axes,), m, from a state (n,) of each axis; ``share`` is how much of
        the way was taken."""
        share, status = 1.0, Status.OK
        for i, (target, state) in enumerate(zip(self.admissible, states, strict=True)):
            least, most = target.interval(state, np.zeros(0))
            now, way = float(self.command[i]), float(reference[i] - self.command[i])
            if not target.contains(state, np.zeros(0), now, ROUNDING):
                share, status = 0.0, Status.INFEASIBLE
            elif way != 0.0:
                share = min(share, ((most if way > 0.0 else least) - now) / way)
        self.share = share = max(share, 0.0)
        self.command = self.command + share * (reference - self.command)
        return status, self.command


def _without_auxiliary(admissible: ExtendedSet) -> None:
    if admissible.auxiliary.order:
        raise DesignError("auxiliary", admissible.auxiliary.name, "none")
