"""An axis in the coordinates in which its controller computes: position, and what is not position.

An integrator's position is in every state of an identified model. In float32 differences of such
states would lose what they are made of; so the state is written x = v y + N xi, with c v = 1 and
c N = 0, where v moves least: (A - I) v is zero for an exact integrator. Then y enters the law
only through coefficients of that size, as the difference to a reference, and xi is small wherever
the axis stands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.controllers.errors import DesignError
from servogen.plants.statespace import Discrete, FloatArray, read_only

# The terms of a sum of impulse responses that are left out are below this share of it.
NEGLIGIBLE = 1e-12
# Samples after which a response that has not died away counts as one that does not.
LONGEST = 200_000


@dataclass(frozen=True)
class AxisModel:
    """x(k+1) = a x(k) + b u(k) with x = (y, xi) and y = x[0].

    Attributes:
        a: (n, n). b: (n,).
        drift: (n,) first column of A less that of the identity, not rounded by their difference.
        to_state: (n, n) original state of (y, xi); from_state its inverse.
        input_limit: largest magnitude of the input.
        reach: largest magnitude of y.

    xi are in shares of the largest values that inputs within the limit and positions within reach
    can make of them: none is ever beyond one.
    """

    plant: Discrete
    a: FloatArray
    b: FloatArray
    drift: FloatArray
    to_state: FloatArray
    from_state: FloatArray
    input_limit: float
    reach: float

    @property
    def order(self) -> int:
        """n."""
        return int(self.b.size)

    @property
    def hidden(self) -> int:
        """Number of xi."""
        return self.order - 1


def axis_model(plant: Discrete, input_limit: float, reach: float) -> AxisModel:
    """The axis in those coordinates.

    Raises:
        DesignError: limits not above zero, an output that shows nothing, or a mode other than the
            position's that does not decay.
    """
    for key, value in (("input_limit", input_limit), ("reach", reach)):
        if not (np.isfinite(value) and value > 0.0):
            raise DesignError(key, value, "a number above zero")
    if not np.any(plant.c):
        raise DesignError("c", None, "an output that shows the axis")
    if not np.any(plant.b):
        raise DesignError("b", None, "an input that moves the axis")
    still = _still(plant)
    hidden = np.asarray(scipy.linalg.null_space(plant.c[None, :]))
    to_state = np.column_stack([still, hidden])
    from_state = np.linalg.inv(to_state)
    a = from_state @ plant.a @ to_state
    drift = from_state @ (plant.a @ still - still)
    b = from_state @ plant.b
    largest = _largest(a[1:, 1:], np.column_stack([b[1:] * input_limit, drift[1:] * reach]))
    scale = np.concatenate([[1.0], largest])
    a = a * scale[None, :] / scale[:, None]
    drift = drift / scale
    a[:, 0] = drift + np.eye(plant.order)[0]
    return AxisModel(
        plant, read_only(a), read_only(b / scale), read_only(drift),
        read_only(to_state * scale[None, :]), read_only(from_state / scale[:, None]),
        float(input_limit), float(reach),
    )  # fmt: skip


def _still(plant: Discrete) -> FloatArray:
    """(n,) v with c v = 1 for which (A - I) v is least."""
    shown = plant.c / float(plant.c @ plant.c)
    if plant.order == 1:
        return np.asarray(shown)
    hidden = np.asarray(scipy.linalg.null_space(plant.c[None, :]))
    moves = plant.a - np.eye(plant.order)
    share = np.linalg.lstsq(moves @ hidden, -moves @ shown, rcond=None)[0]
    result: FloatArray = shown + hidden @ share
    return result


def _largest(a: FloatArray, drive: FloatArray) -> FloatArray:
    """Sums of the magnitudes of the impulse responses: what bounded inputs can reach, or one where
    that is nothing."""
    if a.size and not np.max(np.abs(np.linalg.eigvals(a))) < 1.0:
        raise DesignError("a", None, "an axis of which every mode but its position's decays")
    total, response = np.zeros(drive.shape[0]), drive
    for _ in range(LONGEST):
        total = total + np.sum(np.abs(response), axis=1)
        response = a @ response
        if np.all(np.max(np.abs(response), axis=1, initial=0.0) <= NEGLIGIBLE * total):
            return np.where(total > 0.0, total, 1.0)
    raise DesignError("a", None, "an axis of which every mode but its position's decays sooner")
