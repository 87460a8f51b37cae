"""Numbers as C text that reads back to the same bits."""

from __future__ import annotations

import numpy as np

from servogen.precision import Precision


def real_literal(value: float, precision: Precision) -> str:
    """Shortest decimal that the target type reads back exactly, with its suffix.

    Raises:
        ValueError: NaN, infinity, or a value beyond the type's range.
    """
    rounded = precision.dtype.type(value)
    if not np.isfinite(rounded):
        raise ValueError(f"{value!r} is no finite {precision.name}")
    text = np.format_float_positional(rounded, unique=True, trim="0")
    scientific = np.format_float_scientific(rounded, unique=True, trim="0")
    if len(scientific) < len(text):
        text = scientific
    if precision.dtype.type(text) != rounded:
        raise ValueError(f"{text} does not read back to {value!r} in {precision.name}")
    return text + ("f" if precision.is_float32 else "")
