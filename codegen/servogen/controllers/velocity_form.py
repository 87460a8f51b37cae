"""The velocity form (1)-(5): increments of state and input, so that the input is integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.sampled import Sampled
from servogen.plants.statespace import FloatArray, read_only


@dataclass(frozen=True)
class VelocityForm:
    """x(k+1) = a x(k) + b du(k), y(k) = c x(k) with x = (dx_p, y) (4), (5).

    a: (n+m, n+m), b: (n+m, l), c: (m, n+m). Nothing but y itself depends on y, whatever the plant:
    a move of the output and of all references together changes no increment.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    order: int  # n


def velocity_form(plant: Sampled) -> VelocityForm:
    """(2)-(5) of a plant of any number of inputs and outputs."""
    n, m = plant.order, plant.outputs
    a = np.block([[plant.a, np.zeros((n, m))], [plant.c @ plant.a, np.eye(m)]])
    b = np.vstack([plant.b, plant.c @ plant.b])
    c = np.hstack([np.zeros((m, n)), np.eye(m)])
    return VelocityForm(read_only(a), read_only(b), read_only(c), n)
