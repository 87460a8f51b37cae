"""The shortest way round: against exact arithmetic, and at exactly half a turn."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.errors import DesignError
from servogen.controllers.wrapping import Wrapping
from servogen.precision import FLOAT32, FLOAT64, PRECISIONS

MANY = settings(max_examples=400, deadline=None, derandomize=True)
NAMES = st.sampled_from(["float32", "float64"])


def exact(difference: float, turn: float) -> Fraction:
    """In (-turn/2, turn/2], in rational numbers."""
    left = Fraction(difference) % Fraction(turn)
    return left if left <= Fraction(turn) / 2 else left - Fraction(turn)


@MANY
@given(
    name=NAMES,
    difference=st.floats(-72_000.0, 72_000.0, width=32),
    turn=st.sampled_from([360.0, 1.0, 24.0, 4095.0]),
)
def test_equals_exact_arithmetic(name: str, difference: float, turn: float) -> None:
    reach = min(36_000.0, (4095.0 * turn) / 2)
    difference = math.fmod(difference, 2 * reach)
    precision = PRECISIONS[name]
    wrapping = Wrapping(turn, reach, precision)
    value = precision.dtype.type(difference)
    assert Fraction(float(wrapping.shortest(value))) == exact(float(value), turn)


@MANY
@given(name=NAMES, turns=st.integers(-199, 199), steps=st.integers(-3, 3))
def test_half_a_turn_goes_the_positive_way(name: str, turns: int, steps: int) -> None:
    """Exactly there, and in the numbers next to it."""
    dtype = PRECISIONS[name].dtype.type
    wrapping = Wrapping(360.0, 36_000.0, PRECISIONS[name])
    value = dtype(180.0 + 360.0 * turns)
    toward = dtype(math.copysign(math.inf, steps))
    for _ in range(abs(steps)):
        value = np.nextafter(value, toward)
    way = wrapping.shortest(value)
    assert Fraction(float(way)) == exact(float(value), 360.0)
    assert (way > 0) == (steps <= 0)


def test_an_axis_that_does_not_come_round_keeps_its_differences() -> None:
    assert Wrapping(0.0, 1e6, FLOAT64).shortest(720.5) == 720.5


@pytest.mark.parametrize(("turn", "reach"), [(0.5, 1.0), (-360.0, 1.0), (5000.0, 1.0), (1.0, 1e6)])
def test_turns_that_would_round_are_refused(turn: float, reach: float) -> None:
    with pytest.raises(DesignError):
        Wrapping(turn, reach, FLOAT32)
