"""Affine functions of a parameter compared with zero and with each other, as polyhedra.

What cancels to ``CANCELLED`` of its terms is zero; the order of the rows then decides, as in the
method.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from servogen.explicit.tolerances import CANCELLED
from servogen.plants.statespace import FloatArray


@dataclass
class Conditions:
    """Affine functions that are to be negative (strict) or not positive; sizes of their terms."""

    functions: list[FloatArray] = field(default_factory=list)
    sizes: list[FloatArray] = field(default_factory=list)
    strict: list[npt.NDArray[np.bool_]] = field(default_factory=list)

    def add(self, functions: FloatArray, sizes: FloatArray, strict: bool | FloatArray) -> None:
        """(r, p + 1), (r,), one for all or (r,)."""
        self.functions.append(functions)
        self.sizes.append(sizes)
        self.strict.append(np.broadcast_to(np.asarray(strict, dtype=bool), sizes.shape))

    def polyhedron(self) -> tuple[FloatArray, FloatArray] | None:
        """Rows of unit length and bounds; None where a constant condition fails."""
        g = np.vstack(self.functions)
        size, strict = np.concatenate(self.sizes), np.concatenate(self.strict)
        length = np.sqrt(np.sum(g[:, :-1] ** 2, axis=1))
        nothing = CANCELLED * size
        constant = length <= nothing
        value = np.where(np.abs(g[:, -1]) <= nothing, 0.0, g[:, -1])
        if np.any(constant & ((value > 0.0) | (strict & (value == 0.0)))):
            return None
        g, length = g[~constant], length[~constant]
        return g[:, :-1] / length[:, None], -g[:, -1] / length


def comparisons(
    excess: FloatArray, beyond: FloatArray, size: FloatArray
) -> tuple[FloatArray, FloatArray, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Of every function (s, p + 1) that it is the greatest of them and ``beyond`` positive.

    Returns:
        rows (s, s, p) of unit length and bounds (s, s), row i of polyhedron i being what is beyond;
        which are constant, (s, s), and no rows; of which functions no constant row fails, (s,).
    """
    count = np.arange(excess.shape[0])
    g = excess[None, :] - excess[:, None]
    g[count, count] = -beyond
    terms = size[None, :] + size[:, None]
    length = np.sqrt(np.sum(g[:, :, :-1] ** 2, axis=2))
    constant = length <= CANCELLED * terms
    value = np.where(np.abs(g[:, :, -1]) <= CANCELLED * terms, 0.0, g[:, :, -1])
    strict = count[None, :] <= count[:, None]  # of equal ones the first is taken
    fails = constant & ((value > 0.0) | (strict & (value == 0.0)))
    # nowhere in the unit box
    fails |= g[:, :, -1] - np.sum(np.abs(g[:, :, :-1]), axis=2) > CANCELLED * terms
    length = np.where(constant, 1.0, length)
    return g[:, :, :-1] / length[:, :, None], -g[:, :, -1] / length, constant, ~fails.any(axis=1)


def snapped(functions: FloatArray, sizes: FloatArray) -> FloatArray:
    """Functions that cancelled are nothing: their roundings must not be compared."""
    gone = np.max(np.abs(functions), axis=1, initial=0.0) <= CANCELLED * sizes
    result: FloatArray = np.where(gone[:, None], 0.0, functions)
    return result
