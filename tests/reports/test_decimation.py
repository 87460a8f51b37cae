"""Decimation: every peak stays, and the curve stays where it was."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from servogen.reports.decimation import keep_extremes, simplify

SETTINGS = settings(derandomize=True, deadline=None, max_examples=80)
finite = st.floats(-1e6, 1e6)


@SETTINGS
@given(hnp.arrays(float, st.integers(1, 400), elements=finite), st.integers(1, 50))
def test_extremes_of_every_stretch_stay(values: np.ndarray, buckets: int) -> None:
    kept = keep_extremes(values, buckets)
    assert np.all(np.diff(kept) > 0)
    assert kept[0] == 0
    assert kept[-1] == values.size - 1
    assert kept.size <= max(2 * buckets + 2, 1)
    edges = np.linspace(0, values.size, buckets + 1).astype(int)
    for begin, end in pairwise(edges.tolist()):
        inside = kept[(kept >= begin) & (kept < end)]
        if end > begin and values.size > 2 * buckets + 2:
            assert values[inside].max() == values[begin:end].max()
            assert values[inside].min() == values[begin:end].min()


def test_a_single_sample_peak_among_250000_stays_at_its_time() -> None:
    values = np.sin(np.arange(250_000) / 1000.0)
    values[123_457] = 1.5
    kept = keep_extremes(values, 3000)
    assert 123_457 in kept
    assert kept.size <= 6002


def test_short_signals_stay_whole() -> None:
    assert keep_extremes(np.zeros(100), 49).tolist() == list(range(100))


def test_no_bucket_is_refused() -> None:
    with pytest.raises(ValueError, match="bucket"):
        keep_extremes(np.zeros(10), 0)


@SETTINGS
@given(
    hnp.arrays(float, st.tuples(st.integers(1, 120), st.just(2)), elements=st.floats(-10, 10)),
    st.floats(1e-3, 2.0),
)
def test_simplified_curve_is_within_tolerance_of_every_point(
    points: np.ndarray, tolerance: float
) -> None:
    kept = simplify(points, tolerance)
    assert kept[0] == 0
    assert kept[-1] == len(points) - 1
    for begin, end in pairwise(kept.tolist()):
        for point in points[begin : end + 1]:
            assert _distance(point, points[begin], points[end]) <= tolerance * (1 + 1e-9)


def _distance(point: np.ndarray, begin: np.ndarray, end: np.ndarray) -> float:
    along = end - begin
    length = along @ along
    share = min(max((point - begin) @ along / length, 0.0), 1.0) if length > 0 else 0.0
    return float(np.hypot(*(point - begin - share * along)))


def test_a_straight_line_needs_its_ends_only_and_a_corner_stays() -> None:
    leg = np.linspace(0.0, 1.0, 1001)
    line = np.stack([leg, 2.0 * leg], axis=1)
    assert simplify(line, 1e-9).tolist() == [0, 1000]
    corner = np.vstack([line, line[-1] + np.stack([leg[1:], -leg[1:]], axis=1)])
    assert simplify(corner, 1e-9).tolist() == [0, 1000, 2000]


def test_a_closed_curve_does_not_collapse() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    circle[-1] = circle[0]
    assert 20 < simplify(circle, 1e-3).size < 200
