"""Lengths of SVG."""

from __future__ import annotations

import math
import re

METRES_PER_PIXEL = 0.0254 / 96.0
_PIXELS_PER_UNIT = {
    "": 1.0,
    "px": 1.0,
    "in": 96.0,
    "mm": 96.0 / 25.4,
    "cm": 96.0 / 2.54,
    "q": 96.0 / 101.6,
    "pt": 96.0 / 72.0,
    "pc": 16.0,
}
_LENGTH = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?)([a-z%]*)")


def length_in_pixels(text: str) -> float | None:
    """A length at 96 pixels to the inch, or None where it is none (also %, em and the like)."""
    match = _LENGTH.fullmatch(text.strip().lower())
    if match is None or match[2] not in _PIXELS_PER_UNIT:
        return None
    value = float(match[1]) * _PIXELS_PER_UNIT[match[2]]
    return value if math.isfinite(value) else None
