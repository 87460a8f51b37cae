"""What rows of a program round to wherever the active-set method computes them.

z = z_unc - V lambda and A z are sums: of N + q and of N products, through a plant of n states of
n + 1 at every step. Each operation rounds to at most u = eps / 2 of what it makes, so that a row is
wrong by no more than u times the number of operations a term passes times the sum of the terms'
sizes, |A| (|z_unc| + |V| lambda), to first order. The multipliers come from the factor of the set's
products, which has errors of the same kind and the same sizes, once more.

While that is less than ``accept``, rows of the set are at their bounds to ``accept`` after one
step, and none is met a second time. z_unc and lambda are bounded over the whole box of parameters,
not over each piece: what is told is too large rather than too small.
"""

from __future__ import annotations

import numpy as np

from servogen.explicit.iteration_program import IterationProgram
from servogen.plants.statespace import FloatArray
from servogen.qp.row_tables import StageRows

# The row's own sums, and those of the products and the factor that its multiplier is made with.
_TWICE = 2.0


class Rounding:
    """The most of any place so far, ``most``, in the rows' units."""

    def __init__(self, program: IterationProgram, middle: FloatArray, half: FloatArray) -> None:
        def size(on_theta: FloatArray) -> FloatArray:
            """The terms of |on_theta (theta, 1)| over the box."""
            result: FloatArray = np.abs(on_theta[:, :-1]) @ (np.abs(middle) + half)
            return result + np.abs(on_theta[:, -1])

        tables = program.tables
        on_variables, on_start = program.sizes()
        free = on_variables @ size(program.free)
        if program.start is not None:
            free = free + on_start @ size(program.start)
        self._free = free
        vectors = tables.inverse.astype(np.float64) @ program.rows().T
        self._each = on_variables @ np.abs(vectors)
        rows, n = tables.rows, on_variables.shape[1]
        deep = rows.steps * (rows.order + rows.inputs) if isinstance(rows, StageRows) else n
        self._operations = float(n + deep)
        self._unit = 0.5 * float(np.finfo(tables.inverse.dtype).eps)
        self.most = 0.0
        self.met((), np.zeros((0, middle.size + 1)))

    def met(self, sides: tuple[int, ...], dual: FloatArray) -> None:
        """A place with this set and its multipliers, (q, p + 1) on (t, 1) of the unit box."""
        own = [side // 2 for side in sides]
        pulled = self._each[:, own] @ np.sum(np.abs(dual), axis=1)
        terms = float(np.max(self._free + pulled))
        self.most = max(self.most, _TWICE * (self._operations + len(own)) * self._unit * terms)
