"""Arguments of programs: numbers and tables that can be used, or a sentence."""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.errors import ProgramError


def whole(key: str, value: object, low: int, high: int) -> None:
    """A whole number of a range, or a ``ProgramError``."""
    if isinstance(value, int | np.integer) and not isinstance(value, bool) and low <= value <= high:
        return
    raise ProgramError(key, value, f"a whole number from {low} to {high}")


def matrix(key: str, given: object, empty: bool = False) -> FloatArray:
    """A table of finite numbers, in float64; ``empty``: it may have no rows.

    Raises:
        ProgramError: it is not one.
    """
    try:
        values = np.array(given)
        if np.iscomplexobj(values):
            raise TypeError
        values = values.astype(np.float64)
    except (OverflowError, TypeError, ValueError):
        raise ProgramError(key, None, "a matrix of numbers") from None
    if values.ndim != 2 or not (values.size or (empty and values.shape[1])):
        raise ProgramError(key, f"of shape {values.shape}", "a matrix with a row at least")
    if not np.all(np.isfinite(values)):
        raise ProgramError(key, "not finite", "finite numbers")
    return values
