"""Sampled plants (1) with any number of inputs and outputs, as a drive's controller sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.plants.errors import PlantError
from servogen.plants.statespace import Discrete, FloatArray, StateSpace, discretise, read_only


@dataclass(frozen=True)
class Sampled:
    """x(k+1) = a x(k) + b u(k), y(k) = c x(k), u held over ``sample_time_s`` (1).

    Args:
        a: (n, n), b: (n, l), c: (m, n). Copied, float64, read-only.

    Raises:
        PlantError: shapes that do not fit, or numbers that are not finite.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    sample_time_s: float

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        _check(self.a, self.b, self.c)
        if not (np.isfinite(self.sample_time_s) and self.sample_time_s > 0.0):
            raise PlantError("sample_time_s", self.sample_time_s, "a positive number of seconds")

    @property
    def order(self) -> int:
        """n, number of states."""
        return int(self.a.shape[0])

    @property
    def inputs(self) -> int:
        """l, number of inputs."""
        return int(self.b.shape[1])

    @property
    def outputs(self) -> int:
        """m, number of outputs."""
        return int(self.c.shape[0])

    @staticmethod
    def of(plant: Discrete) -> Sampled:
        """A plant of one input and one output."""
        return Sampled(plant.a, plant.b[:, None], plant.c[None, :], plant.sample_time_s)


def hold(a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike, sample_time_s: float) -> Sampled:
    """Exact zero-order hold of dx/dt = a x + b u, y = c x, column of b by column.

    Args:
        a: (n, n), b: (n, l), c: (m, n).

    Raises:
        PlantError: shapes that do not fit, or numbers that are not finite.
    """
    continuous = Sampled(np.asarray(a), np.asarray(b), np.asarray(c), sample_time_s)
    parts = [
        discretise(StateSpace(continuous.a, column, continuous.c[0]), sample_time_s)
        for column in continuous.b.T
    ]
    held = np.stack([part.b for part in parts], axis=1)
    return Sampled(parts[0].a, held, continuous.c, sample_time_s)


def _check(a: FloatArray, b: FloatArray, c: FloatArray) -> None:
    if a.ndim != 2 or a.shape[0] != a.shape[1] or a.shape[0] == 0:
        raise PlantError("a", f"of shape {a.shape}", "a square matrix")
    n = a.shape[0]
    if b.ndim != 2 or b.shape[0] != n or b.shape[1] == 0:
        raise PlantError("b", f"of shape {b.shape}", f"{n} rows, one per state")
    if c.ndim != 2 or c.shape[1] != n or c.shape[0] == 0:
        raise PlantError("c", f"of shape {c.shape}", f"rows of {n} numbers, one per state")
    for name, array in (("a", a), ("b", b), ("c", c)):
        if not np.all(np.isfinite(array)):
            raise PlantError(name, "not finite", "finite numbers")
