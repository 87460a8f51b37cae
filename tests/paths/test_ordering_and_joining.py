"""Order, direction and joining of strokes."""

from __future__ import annotations

import itertools
from pathlib import Path
from random import Random

import numpy as np
import pytest
from drawings import SETTINGS
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from servogen.paths.curves import EllipticArc, Line, Stroke, circular_arc
from servogen.paths.geometry import JOIN_LABEL, ToolPath, build_tool_path
from servogen.paths.ordering import order_strokes

FILE = Path("drawing.dxf")
Point = tuple[float, float]


def line(label: str, start: Point, end: Point, feed: float | None = None) -> Stroke:
    return Stroke(label, (Line(start, end),), feed)


def joined(*strokes: Stroke, reorder: bool = True) -> ToolPath:
    return build_tool_path(list(strokes), SETTINGS, FILE, reorder=reorder)


def test_strokes_that_meet_are_chained_and_turned_round() -> None:
    path = joined(line("a", (0, 0), (1, 0)), line("b", (2, 1), (2, 0)), line("c", (1, 0), (2, 0)))
    assert path.labels == ("a", "c", "b")
    assert_allclose(path.points, [[0, 0], [1, 0], [2, 0], [2, 1]])


def test_a_chain_grows_at_both_ends() -> None:
    path = joined(line("b", (1, 0), (2, 0)), line("a", (1, 0), (0, 0)))
    assert path.labels == ("a", "b")
    assert_allclose(path.points[:, 0], [0, 1, 2])


def test_chains_are_visited_by_the_nearest_end() -> None:
    path = joined(
        line("first", (0, 0), (1, 0)), line("far", (9, 0), (5, 0)), line("near", (3, 0), (2, 0))
    )
    assert path.labels == ("first", JOIN_LABEL, "near", JOIN_LABEL, "far")
    assert_allclose(path.points[:, 0], [0, 1, 2, 3, 5, 9])


def test_joining_moves_have_the_traverse_feed() -> None:
    path = joined(line("a", (0, 0), (1, 0), 0.1), line("b", (2, 0), (3, 0)))
    assert path.feed_m_per_s.tolist() == [
        0.1,
        SETTINGS.traverse_feed_m_per_s,
        SETTINGS.feed_m_per_s,
    ]


@pytest.mark.parametrize(("gap", "pieces"), [(0.9e-5, 2), (1.1e-5, 3)])
def test_gaps_within_the_tolerance_are_no_moves(gap: float, pieces: int) -> None:
    path = joined(line("a", (0, 0), (1, 0)), line("b", (1 + gap, 0), (2, 0)))
    assert len(path.labels) == pieces


def test_the_order_of_a_program_is_kept() -> None:
    strokes = [line("a", (0, 0), (1, 0)), line("b", (5, 0), (4, 0)), line("c", (1, 0), (2, 0))]
    path = joined(*strokes, reorder=False)
    assert path.labels == ("a", JOIN_LABEL, "b", JOIN_LABEL, "c")


def test_a_reversed_arc_keeps_its_curvature() -> None:
    arc = Stroke("arc", (circular_arc((1.0, 0.01), 0.01, 0.5, -0.5 * np.pi),))
    path = joined(line("a", (0, 0), (1, 0)), arc)
    assert path.labels[0] == "a"
    assert set(path.labels[1:]) == {"arc"}
    assert_allclose(path.radius_m[1:], 0.01)
    assert bool(path.smooth[2:-1].all())
    assert_allclose(path.points[-1], [1 + 0.01 * np.cos(0.5), 0.01 + 0.01 * np.sin(0.5)])


def test_a_reversed_ellipse_is_curved_where_it_was() -> None:
    """From the tip, radius b^2/a, to the flat side, radius a^2/b; cut the other way round."""
    quarter = EllipticArc((1.0, -0.01), (0.04, 0.0), (0.0, 0.01), 0.0, 0.5 * np.pi)
    path = joined(line("a", (0, 0), (1, 0)), Stroke("ellipse", (quarter,)))
    assert_allclose(path.points[-1], [1.04, -0.01])
    assert_allclose(path.radius_m[[1, -1]], [0.16, 0.0025])


def test_pieces_of_no_length_are_dropped() -> None:
    stroke = Stroke("a", (Line((0, 0), (1, 0)), Line((1, 0), (1, 0)), Line((1, 0), (1, 1))))
    path = joined(stroke)
    assert len(path.points) == len(path.labels) + 1 == 3


@settings(derandomize=True, deadline=None, max_examples=80)
@given(st.lists(st.integers(1, 5), min_size=1, max_size=5), st.randoms(use_true_random=False))
def test_every_stroke_once_and_no_chain_broken(lengths: list[int], random: Random) -> None:
    """Chains of strokes, shuffled and turned round: one jump fewer than there are chains."""
    pairs = []
    for row, length in enumerate(lengths):
        places = [(float(k), float(row)) for k in range(length + 1)]
        random.shuffle(places)
        pairs += [random.sample(ends, 2) for ends in itertools.pairwise(places)]
    random.shuffle(pairs)
    starts, ends = (np.array([pair[side] for pair in pairs]) for side in (0, 1))
    runs = order_strokes(starts, ends, 1e-5)
    assert sorted(run.index for run in runs) == list(range(len(pairs)))
    assert runs == order_strokes(starts, ends, 1e-5)
    begins = [(ends if run.reverse else starts)[run.index] for run in runs]
    stops = [(starts if run.reverse else ends)[run.index] for run in runs]
    jumps = sum(not np.array_equal(a, b) for a, b in zip(stops[:-1], begins[1:], strict=True))
    assert jumps == len(lengths) - 1
