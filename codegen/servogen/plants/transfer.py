"""Transfer functions, descending powers of s, to motion states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.motion import check_relative_degree, motion_form
from servogen.plants.statespace import FloatArray, StateSpace


def _polynomial(key: str, coefficients: Sequence[float]) -> FloatArray:
    """Coefficients as an array without leading zeros."""
    array = np.asarray(coefficients, dtype=np.float64)
    if array.ndim != 1 or array.size == 0 or not np.all(np.isfinite(array)):
        raise PlantError(key, list(coefficients), "finite coefficients, highest power of s first")
    array = np.trim_zeros(array, "f")
    if array.size == 0:
        raise PlantError(key, list(coefficients), "a coefficient that is not zero")
    return array


def transfer_function(numerator: Sequence[float], denominator: Sequence[float]) -> StateSpace:
    """Numerator / denominator (descending powers of s, position command to position, m/m).

    Raises:
        PlantError: empty, zero or not finite coefficients, order below three, or fewer than three
            more poles than zeros.
    """
    num, den = _polynomial("numerator", numerator), _polynomial("denominator", denominator)
    n = den.size - 1
    if n < 3:
        raise PlantError("denominator", list(denominator), "at least third order")
    if num.size > n - 2:
        raise PlantError("numerator", list(numerator), "three more poles than zeros")
    num, den = num / den[0], den / den[0]
    padded = np.concatenate([np.zeros(n - num.size), num])  # of s^(n-1) .. s^0
    markov = np.zeros(n)
    for i in range(n):  # den * (markov series in 1/s) = num, power by power
        markov[i] = padded[i] - den[1 : i + 1] @ markov[i - 1 :: -1][:i] if i else padded[0]
    rate = float(np.max(np.abs(np.roots(den)))) or 1.0
    check_relative_degree(markov / rate ** np.arange(1, n + 1))
    return motion_form(den[:0:-1], markov)
