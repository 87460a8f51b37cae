"""The Appendix: the state wanted at the end of the preview, x_d(k + N_p), from its last two points.

Beyond them the contour is taken to go on at constant velocity, which an axis with one integrator
follows under a constant input. Both unknowns come from n + 1 outputs in a row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.errors import DesignError
from servogen.plants.statespace import Discrete, FloatArray, read_only

# Of the matrix in balanced columns: it is 2e3 for the paper's y axis, of order five; beyond this
# more than half of the digits of a float64 are lost.
CONDITION = 1e8


@dataclass(frozen=True)
class WantedState:
    """x_d = on_position y_d(N) + on_advance (y_d(N) - y_d(N-1)), both (n,); ``condition`` of the
    matrix that was solved."""

    on_position: FloatArray
    on_advance: FloatArray
    condition: float


def wanted_state(axis: Discrete) -> WantedState:
    """Of an axis of any order.

    The outputs after j samples are c A^j x_d + c (A^{j-1} + ... + I) b u. A position is metres per
    metre and the input's column metres per its unit, 1e-5 of it here: columns are brought to one
    size first, by powers of two, which round nothing.

    Raises:
        DesignError: an axis for which the matrix is singular or nearly so.
    """
    n = axis.order
    matrix = np.zeros((n + 1, n + 1))
    power, driven = np.array(axis.c), 0.0
    for j in range(n + 1):
        matrix[j, :n], matrix[j, n] = power, driven
        driven = driven + float(power @ axis.b)
        power = power @ axis.a
    size = np.max(np.abs(matrix), axis=0)
    if not np.all(size > 0.0):
        raise DesignError("c", None, "an axis that its output shows whole")
    scaled = matrix / 2.0 ** np.round(np.log2(size))
    condition = float(np.linalg.cond(scaled))
    if not condition < CONDITION:
        said = f"an axis whose state n + 1 outputs tell, to {condition:.1e}"
        raise DesignError("a", said, f"a condition below {CONDITION:.0e}")
    positions = np.column_stack([np.ones(n + 1), np.arange(n + 1.0)])
    found = np.linalg.solve(scaled, positions) / (2.0 ** np.round(np.log2(size)))[:, None]
    return WantedState(read_only(found[:n, 0]), read_only(found[:n, 1]), condition)
