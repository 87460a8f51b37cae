"""The finite-preview controller of Tomizuka and Whitney, constant gains, no contour error.

The infinite horizon's Riccati equation gives the feedback; the preview's gains fall off by the
closed loop's own matrix. What lies beyond the preview goes in through the state wanted at its end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.contour_estimate import wanted_state
from servogen.controllers.contour_recursion import stationary
from servogen.controllers.errors import DesignError
from servogen.plants.statespace import Discrete, FloatArray, read_only


@dataclass(frozen=True)
class FinitePreview:
    """Of one axis: u = -feedback x + ahead (y_d(k+1), ..., y_d(k+N)).

    feedback: (n,). ahead: (N,). decay: largest modulus of the closed loop.
    """

    feedback: FloatArray
    ahead: FloatArray
    decay: float

    def command(self, state: FloatArray, wanted: FloatArray) -> float:
        """For a state (n,) and the points (N,) ahead."""
        return float(self.ahead @ wanted - self.feedback @ state)


def finite_preview(
    axis: Discrete, tracking: float, control: float, preview: int, held: bool = False
) -> FinitePreview:
    """With weights per square metre and per squared input.

    Args:
        held: beyond the preview the contour stands at its last point, as if what is not known were
            a random walk; False: it goes on at its last velocity.

    Raises:
        DesignError: fewer than two points, weights not above zero, an axis without H_s or whose
            wanted state cannot be told.
    """
    if preview < 2:
        raise DesignError("preview", preview, "two points at least")
    for key, value in (("tracking_weight", tracking), ("control_weight", control)):
        if not (np.isfinite(value) and value > 0.0):
            raise DesignError(key, value, "a number above zero")
    h = stationary(axis, tracking, control)
    price = float(axis.b @ h @ axis.b) + control
    feedback = (axis.b @ h @ axis.a) / price
    closed = axis.a - np.outer(axis.b, feedback)
    found = wanted_state(axis)
    back, ahead = axis.b / price, np.zeros(preview)
    for j in range(preview - 1):
        ahead[j] = tracking * float(back @ axis.c)
        back = closed @ back
    ahead[-1] += float(back @ h @ found.on_position)
    if not held:
        advance = float(back @ h @ found.on_advance)
        ahead[-1] += advance
        ahead[-2] -= advance
    decay = float(np.max(np.abs(np.linalg.eigvals(closed))))
    return FinitePreview(read_only(feedback), read_only(ahead), decay)
