"""Steady-state Kalman filter of one axis for what its encoder does not show.

The paper leaves the observer to the reader. What moves an axis other than its input is taken to act
where the input does; what the encoder hides is its quantum, uniform over one count. The position is
kept relative to the last measurement, so that no number of the filter grows with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.controllers.contour_axis import AxisModel
from servogen.controllers.contour_recursion import RICCATI_RESIDUAL
from servogen.controllers.errors import DesignError
from servogen.plants.statespace import FloatArray, read_only


@dataclass(frozen=True)
class AxisObserver:
    """Correction by the innovation v: xi += on_hidden v, the position's estimate less what is
    measured becomes on_position v.

    on_hidden: (n - 1,). on_position: between -1 (what is measured is not looked at) and 0 (it is
    taken as it is). decay: largest magnitude of the filter's poles.
    """

    on_hidden: FloatArray
    on_position: float
    decay: float


def axis_observer(model: AxisModel, disturbance: float, measurement: float) -> AxisObserver:
    """The stationary gain.

    Args:
        disturbance: standard deviation of what is added to the input, in its unit.
        measurement: that of the measured position, m; of an encoder its count over sqrt(12).

    Raises:
        DesignError: one of them not above zero, or an axis without such a filter.
    """
    for key, value in (("disturbance", disturbance), ("measurement", measurement)):
        if not (np.isfinite(value) and value > 0.0):
            raise DesignError(f"{key}_noise", value, "a number above zero")
    n = model.order
    # positions in units of the measurement's noise, the rest as it is
    scale = np.concatenate([[measurement], np.ones(n - 1)])
    a, b = model.a * scale[None, :] / scale[:, None], model.b / scale
    noise, seen, unit = disturbance**2 * np.outer(b, b), np.eye(n)[:1], np.eye(1)
    try:
        with np.errstate(all="ignore"):
            p = scipy.linalg.solve_discrete_are(a.T, seen.T, noise, unit)
    except (np.linalg.LinAlgError, ValueError):
        raise DesignError("a", None, "an axis whose filter's Riccati equation is solved") from None
    gain = p[:, 0] / (p[0, 0] + 1.0)
    residual = a @ (p - np.outer(gain, p[0])) @ a.T + noise - p
    closed = a - np.outer(a @ gain, seen[0])
    decay = float(np.max(np.abs(np.linalg.eigvals(closed))))
    if not (np.max(np.abs(residual)) <= RICCATI_RESIDUAL * np.max(np.abs(p)) and decay < 1.0):
        raise DesignError("a", None, "an axis whose filter's Riccati equation is solved accurately")
    gain = gain * scale / measurement
    return AxisObserver(read_only(gain[1:]), float(gain[0]) - 1.0, decay)
