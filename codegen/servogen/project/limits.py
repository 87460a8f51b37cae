"""Limits of a quantity in a project file: one number to either side of zero, or the two sides."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

# Below this a unit is wrong, and squares and quotients leave the range of float64 or float32.
LEAST = 1e-9
LARGEST_LIMIT = 1e6

Limits = tuple[float, float]


def _limits(value: object) -> object:
    """A number above 0 is a limit to either side, a list of two the lower and the upper one."""
    if isinstance(value, bool):
        raise ValueError("no number")
    low, high = (-value, value) if isinstance(value, int | float) else _two(value)
    if not (-LARGEST_LIMIT <= low < high <= LARGEST_LIMIT and high - low >= LEAST):
        raise ValueError("no limits")
    return (float(low) + 0.0, float(high))


def _around_zero(value: Limits) -> Limits:
    if not value[0] <= 0.0 <= value[1]:
        raise ValueError("zero is not between them")
    return value


def _on_either_side(value: Limits) -> Limits:
    if not value[0] < 0.0 < value[1]:
        raise ValueError("zero is not inside")
    return value


def _two(value: object) -> Limits:
    if not isinstance(value, list) or len(value) != 2 or bool in map(type, value):
        raise ValueError("neither a number nor two")
    if not all(isinstance(each, int | float) for each in value):
        raise ValueError("neither a number nor two")
    return value[0], value[1]


def as_written(limits: Limits) -> float | list[float]:
    """Limits as a file says them: one number where they are the same to either side."""
    return limits[1] if limits[0] == -limits[1] else list(limits)


AnyLimits = Annotated[Limits, BeforeValidator(_limits)]
LimitsAroundZero = Annotated[Limits, BeforeValidator(_limits), AfterValidator(_around_zero)]
LimitsEitherSide = Annotated[Limits, BeforeValidator(_limits), AfterValidator(_on_either_side)]
