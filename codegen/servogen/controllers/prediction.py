"""Prediction (8) and the reference beyond the trajectory horizon, as matrices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from servogen.controllers.errors import DesignError
from servogen.controllers.velocity_form import velocity_form
from servogen.plants.sampled import Sampled
from servogen.plants.statespace import FloatArray, read_only

Extension = Literal["zero_order", "first_order"]


@dataclass(frozen=True)
class Horizons:
    """``prediction`` H_p, ``trajectory`` H_t and ``control`` H_u, in sample times.

    Raises:
        DesignError: a horizon below one, or H_t or H_u above H_p.
    """

    prediction: int
    trajectory: int
    control: int

    def __post_init__(self) -> None:
        for key in ("prediction", "trajectory", "control"):
            value = getattr(self, key)
            if value < 1 or value > self.prediction:
                most = "" if key == "prediction" else " and at most the prediction horizon"
                raise DesignError(key, value, f"at least 1{most}")


@dataclass(frozen=True)
class Prediction:
    """y(i|k) - y(k) for i = 1..H_p, stacked, as (8) has it.

    on_increment: (H_p m, n) Psi without the columns of y, which are identities.
    on_change: (H_p m, H_u l) Theta.
    """

    on_increment: FloatArray
    on_change: FloatArray


def predict(plant: Sampled, steps: int, control: int) -> Prediction:
    """(8) over ``steps`` samples, for inputs that change over ``control`` of them."""
    form = velocity_form(plant)
    n, m, inputs = plant.order, plant.outputs, plant.inputs
    power = form.c.copy()
    responses = []  # c a^i b
    on_increment = np.zeros((steps, m, n))
    for i in range(steps):
        responses.append(power @ form.b)
        power = power @ form.a
        on_increment[i] = power[:, :n]
    on_change = np.zeros((steps, m, control, inputs))
    for i in range(steps):
        for j in range(min(i + 1, control)):
            on_change[i, :, j] = responses[i - j]
    return Prediction(
        read_only(on_increment.reshape(steps * m, n)),
        read_only(on_change.reshape(steps * m, control * inputs)),
    )


def extension(horizons: Horizons, kind: Extension, outputs: int) -> FloatArray:
    """(H_p m, H_t m) the references 1..H_p made of the first H_t, Lambda of the paper.

    ``zero_order`` keeps the last one; ``first_order`` goes on by the last difference. Every row
    sums to one, so references relative to anything are extended to references relative to it.

    Raises:
        DesignError: ``first_order`` with a trajectory horizon below two.
    """
    last = horizons.trajectory
    if kind == "first_order" and last < 2:
        raise DesignError("trajectory", last, "at least 2 for the first-order hold")
    rows = np.zeros((horizons.prediction, last))
    for i in range(1, horizons.prediction + 1):
        beyond = i - last
        if beyond <= 0:
            rows[i - 1, i - 1] = 1.0
        elif kind == "zero_order":
            rows[i - 1, last - 1] = 1.0
        else:
            rows[i - 1, last - 2 :] = (-float(beyond), 1.0 + beyond)
    return read_only(np.kron(rows, np.eye(outputs)))
