"""The lookup of a first move, step by step; see ``lookup_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.design import Status, Value
from servogen.controllers.lookup_design import LookupDesign, declare_lookup
from servogen.explicit.lookup import TreeLookup, evaluate_clips
from servogen.precision import FloatArray, IntArray
from servogen.qp.ordered import matvec


class Lookup:
    """Reference of the emitted lookup, bit for bit but for the sign of a zero; a ``FirstMove``."""

    def __init__(self, design: LookupDesign) -> None:
        self.design = design
        self.declaration = declare_lookup(design)
        p = design.precision
        form = design.form
        self._form = form.rounded(p.dtype) if isinstance(form, TreeLookup) else form
        self._safe = cast(design.safe, p)
        self._theta = self.declaration.operation("find").inputs[0]
        edge = design.feasible
        self._edge_rows = None if edge is None else cast(edge.rows.T, p)
        self._edge_bounds = None if edge is None else cast(edge.bounds, p)

    def __call__(self, theta: FloatArray) -> tuple[Status, FloatArray]:
        """See ``FirstMove``."""
        status, move, _ = self._find(theta)
        return status, move

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        assert operation == "find"
        status, move, law = self._find(np.asarray((inputs or {})["theta"]))
        outputs: dict[str, Value] = {"move": move}
        if isinstance(self._form, TreeLookup):
            outputs["law"] = law
        return status, outputs

    def many(self, theta: FloatArray) -> tuple[IntArray, FloatArray]:
        """(N,) laws (zeros without a tree) and (N, nu) moves of theta (N, p), all of them in range
        and feasible."""
        dtype = self.design.precision.dtype
        if isinstance(self._form, TreeLookup):
            return self._form.find(theta, dtype)
        return np.zeros(len(theta), dtype=np.int64), evaluate_clips(self._form, theta, dtype)

    def _find(self, theta: FloatArray) -> tuple[Status, FloatArray, int]:
        with np.errstate(over="ignore"):
            given = theta.astype(self.design.precision.dtype)
        status = check_port(self._theta, given, self.design.precision)
        if status is Status.OK and not self._feasible(given):
            status = Status.INFEASIBLE
        if status is not Status.OK:
            return status, self._safe.copy(), -1
        law, moves = self.many(given[None])
        return status, moves[0], int(law[0])

    def _feasible(self, theta: FloatArray) -> bool:
        if self._edge_rows is None or self._edge_bounds is None:
            return True
        return bool(np.all(matvec(self._edge_rows, theta) <= self._edge_bounds))
