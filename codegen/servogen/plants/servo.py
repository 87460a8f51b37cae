"""The closed position loop of a drive, as one third-order lag of unit gain."""

from __future__ import annotations

import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.motion import motion_form
from servogen.plants.statespace import StateSpace


def servo(bandwidth_rad_per_s: float, damping: float) -> StateSpace:
    """w^3 / ((s + w) (s^2 + 2 zeta w s + w^2)) with states p, v, a.

    Args:
        bandwidth_rad_per_s: w > 0, rad/s.
        damping: zeta > 0.

    Raises:
        PlantError: w or zeta not positive and finite.
    """
    for key, value, unit in (
        ("bandwidth_rad_per_s", bandwidth_rad_per_s, "a positive number of rad/s"),
        ("damping", damping, "a positive number"),
    ):
        if not (np.isfinite(value) and value > 0.0):
            raise PlantError(key, value, unit)
    w = float(bandwidth_rad_per_s)
    middle = 1.0 + 2.0 * float(damping)
    characteristic = np.array([w**3, middle * w**2, middle * w])
    return motion_form(characteristic, np.array([0.0, 0.0, w**3]))
