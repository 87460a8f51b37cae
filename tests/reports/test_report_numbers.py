"""Numbers as text: never rounded across a limit, never in another's locale."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.reports.numbers import number, percent


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (0.0, "0"),
        (1234567, "1\u202f234\u202f567"),
        (-3, "\u22123"),
        (0.034, "0.034"),
        (34.79140, "34.79"),
        (12345.678, "12\u202f346"),
        (1e-9, "1e\u22129"),
        (1.23456e-7, "1.235e\u22127"),
        (float("nan"), "nan"),
        (float("inf"), "inf"),
    ],
)
def test_numbers(value: float, text: str) -> None:
    assert number(value) == text


@settings(derandomize=True, deadline=None, max_examples=200)
@given(st.floats(-1e12, 1e12))
def test_a_number_reads_back_to_its_digits(value: float) -> None:
    read = float(number(value, 6).replace("\u202f", "").replace("\u2212", "-"))
    assert read == pytest.approx(value, rel=1e-5, abs=1e-300)


def test_percent_is_never_rounded_down_to_the_limit() -> None:
    assert percent(1.0) == "100\u202f%"
    assert percent(1.00001) == "> 100\u202f%"
    assert percent(0.9937) == "99.4\u202f%"
