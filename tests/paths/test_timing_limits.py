"""Timed paths: the limits of the ideal machine, the ends, the number of samples."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from drawings import (
    LIMITS,
    PERIOD_S,
    SETTINGS,
    distance_from_polyline,
    peak_acceleration,
    peak_velocity,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.errors import InputError
from servogen.paths.curves import Helix, Line, Segment, Stroke, bezier, circular_arc
from servogen.paths.geometry import ToolPath, build_tool_path
from servogen.paths.places import describe_point
from servogen.paths.timing import count_steps, find_feed_scale, time_path

FILE = Path("drawing.dxf")
ROUNDING = 1.0 + 1e-9


def tool_path(*strokes: Stroke) -> ToolPath:
    return build_tool_path(list(strokes), SETTINGS, FILE, reorder=False)


def polyline(*points: tuple[float, ...], feed: float = 0.6) -> ToolPath:
    pieces = pairwise(points)
    return tool_path(*(Stroke(f"line {k}", (Line(*ends),), feed) for k, ends in enumerate(pieces)))


@st.composite
def tool_paths(draw: st.DrawFn) -> ToolPath:
    """Lines, arcs and Bezier curves end to end, from microns to decimetres."""
    size = 10.0 ** draw(st.floats(-6.0, -0.9))
    step = st.floats(-1.0, 1.0).filter(lambda value: abs(value) > 1e-3)
    x, y = 0.0, 0.0
    strokes = []
    for number in range(draw(st.integers(1, 8))):
        to = (x + size * draw(step), y + size * draw(step))
        segment: Segment = Line((x, y), to)
        kind = draw(st.sampled_from(["line", "arc", "bezier"]))
        if kind == "arc":
            radius, turn = size * abs(draw(step)), 6.0 * draw(step)
            begin = 3.0 * draw(step)
            center = (x - radius * math.cos(begin), y - radius * math.sin(begin))
            segment = circular_arc(center, radius, begin, begin + turn)
            angle = begin + turn
            to = (center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle))
        elif kind == "bezier":
            inner = [(x + size * draw(step), y + size * draw(step)) for _ in range(2)]
            segment = bezier(np.array([(x, y), *inner, to]))
        strokes.append(Stroke(f"{kind} {number}", (segment,), 10.0 ** draw(st.floats(-2.0, 1.0))))
        x, y = to
    return tool_path(*strokes)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(tool_paths(), st.sampled_from([1e-4, 2e-4, 1e-3]))
def test_limits_hold_at_every_sample(path: ToolPath, period_s: float) -> None:
    timed = time_path(path, LIMITS, period_s)
    assert peak_acceleration(timed) <= 49.05 * ROUNDING
    assert peak_velocity(timed) <= 0.6 * ROUNDING
    assert np.array_equal(timed.points[0], path.points[0])
    assert np.array_equal(timed.points[-1], path.points[-1])
    assert len(timed.piece) == len(timed.points)
    assert (np.diff(timed.piece) >= 0).all()
    ends = path.points[timed.piece], path.points[timed.piece + 1]
    chosen = np.linspace(0, len(timed.points) - 1, 40).astype(int)
    for k in chosen.tolist():
        piece = np.array([ends[0][k], ends[1][k]])
        assert distance_from_polyline(timed.points[k : k + 1], piece)[0] <= 1e-12


@pytest.mark.parametrize("angle_deg", [1.0, 10.0, 45.0, 90.0, 135.0, 179.0, 180.0])
def test_corners_keep_the_acceleration_and_are_not_stopped_at(angle_deg: float) -> None:
    angle = math.radians(angle_deg)
    end = (0.05 + 0.05 * math.cos(angle), 0.05 * math.sin(angle))
    timed = time_path(polyline((0, 0), (0.05, 0), end), LIMITS, PERIOD_S)
    assert peak_acceleration(timed) <= 49.05 * ROUNDING
    speed = np.hypot(*np.diff(timed.points, axis=0).T) / PERIOD_S
    inner = speed[len(speed) // 4 : -len(speed) // 4]
    assert inner.min() > 0.4 * 49.05 * PERIOD_S / (2.0 * math.sin(0.5 * angle))


def test_zigzag_of_corners_within_one_sample() -> None:
    points = [(2e-6 * k, 3e-6 * (k % 2)) for k in range(400)]
    timed = time_path(polyline(*points), LIMITS, PERIOD_S)
    assert peak_acceleration(timed) <= 49.05 * ROUNDING


@pytest.mark.parametrize("step_m", [1e-6, 3e-6, 1e-5])
def test_random_walks_of_steps_shorter_than_a_sample(step_m: float) -> None:
    """Where the rule for single corners does not do, the place is slowed down and timed again."""
    for seed in range(12):
        steps = np.random.default_rng(seed).normal(scale=step_m, size=(200, 2))
        points = [tuple(point) for point in np.cumsum(steps, axis=0).tolist()]
        timed = time_path(polyline(*points), LIMITS, PERIOD_S)
        assert peak_acceleration(timed) <= 49.05 * ROUNDING


def test_straight_line_takes_its_trapezoid() -> None:
    """0.6 m/s at 24.5 m/s^2: length over speed, and speed over acceleration once more."""
    timed = time_path(polyline((0, 0), (0.3, 0)), LIMITS, PERIOD_S)
    ideal = 0.3 / 0.6 + 0.6 / 24.5
    assert ideal <= timed.duration_s < ideal + PERIOD_S
    assert timed.duration_s == pytest.approx((len(timed.points) - 1) * PERIOD_S)
    assert peak_acceleration(timed) <= 24.5 * 1.001


def test_every_axis_can_have_its_own_velocity_limit() -> None:
    limits = replace(LIMITS, velocity_m_per_s=(0.6, 0.3, 0.05))
    path = polyline((0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0), (0.1, 0.1, 0.02), feed=5.0)
    timed = time_path(path, limits, PERIOD_S)
    fastest = np.abs(np.diff(timed.points, axis=0)).max(axis=0) / PERIOD_S
    assert fastest == pytest.approx([0.6, 0.3, 0.05], rel=1e-3)
    assert peak_acceleration(timed) <= 49.05 * ROUNDING


def test_a_helix_keeps_its_feed_along_the_path_and_the_limit_of_its_curvature() -> None:
    """Its radius of curvature is r (1 + (p / r)^2) with a pitch of p a radian."""
    arc = circular_arc((0.0, 0.0), 1e-3, 0.0, 2.0 * math.pi)
    helix = Stroke("helix", (Helix(arc, 0.0, 2.0 * math.pi * 1e-3),), 0.6)
    timed = time_path(tool_path(helix), LIMITS, PERIOD_S)
    speed = np.linalg.norm(np.diff(timed.points, axis=0), axis=1) / PERIOD_S
    assert np.median(speed) == pytest.approx(math.sqrt(34.3 * 2e-3), rel=0.02)


def test_velocity_limit_is_per_axis() -> None:
    timed = time_path(polyline((0, 0), (0.2, 0.2), feed=5.0), LIMITS, PERIOD_S)
    assert 0.599 < peak_velocity(timed) <= 0.6 * ROUNDING
    assert np.hypot(*np.diff(timed.points, axis=0).T).max() / PERIOD_S > 0.84


def test_curves_are_slowed_to_their_centripetal_limit() -> None:
    circle = Stroke("circle", (circular_arc((0.0, 0.0), 1e-3, 0.0, 2.0 * math.pi),), 0.6)
    timed = time_path(tool_path(circle), LIMITS, PERIOD_S)
    speed = np.hypot(*np.diff(timed.points, axis=0).T) / PERIOD_S
    assert np.median(speed) == pytest.approx(math.sqrt(34.3 * 1e-3), rel=0.02)
    slower = replace(LIMITS, centripetal_acceleration_m_per_s2=10.0)
    assert len(time_path(tool_path(circle), slower, PERIOD_S).points) > 1.5 * len(timed.points)


def test_feeds_and_their_scale() -> None:
    path = polyline((0, 0), (0.1, 0), (0.3, 0), feed=0.1)
    for scale in (0.5, 1.0, 2.0):
        timed = time_path(path, LIMITS, PERIOD_S, scale)
        assert peak_velocity(timed) == pytest.approx(0.1 * scale, rel=1e-3)


def test_very_short_paths() -> None:
    timed = time_path(polyline((0, 0), (1e-9, 0)), LIMITS, PERIOD_S)
    assert len(timed.points) == 3
    assert timed.points[-1].tolist() == [1e-9, 0.0]


def test_points_cannot_be_written_to_and_are_the_same_again() -> None:
    path = polyline((0, 0), (0.1, 0.05), (0.2, 0))
    timed, again = (time_path(path, LIMITS, PERIOD_S) for _ in range(2))
    assert timed.points.tobytes() == again.points.tobytes()
    with pytest.raises(ValueError, match="read-only"):
        timed.points[0] = 1.0


def test_feed_scale_for_a_number_of_steps() -> None:
    path = polyline((0, 0), (0.1, 0.05), (0.2, 0), (0.2, 0.1), feed=0.3)
    steps = count_steps(path, LIMITS, PERIOD_S, 1.0) + 137
    scale = find_feed_scale(path, LIMITS, PERIOD_S, steps)
    assert scale < 1.0
    for near in (scale, scale * (1 + 1e-6), scale * (1 - 1e-6)):
        assert count_steps(path, LIMITS, PERIOD_S, near) == steps


def test_no_feed_scale_makes_a_path_instant() -> None:
    with pytest.raises(InputError, match="a scale that gives 5 steps"):
        find_feed_scale(polyline((0, 0), (0.1, 0)), LIMITS, PERIOD_S, 5)


def test_a_path_without_end_is_refused() -> None:
    with pytest.raises(InputError, match=r"path.feed_m_per_s is such that the path takes \d+ s"):
        time_path(polyline((0, 0), (1, 0), feed=1e-6), LIMITS, PERIOD_S)


@pytest.mark.parametrize("name", ["tangential", "centripetal"])
def test_more_than_the_machine_has_is_refused(name: str) -> None:
    key = f"{name}_acceleration_m_per_s2"
    with pytest.raises(InputError, match=f"path.{key} is 50.0, expected more than 0 and at most"):
        time_path(polyline((0, 0), (1, 0)), replace(LIMITS, **{key: 50.0}), PERIOD_S)


def test_points_are_named_by_place() -> None:
    timed = time_path(polyline((0.1, 0), (0.1, -0.05), (0.2, 0)), LIMITS, PERIOD_S)
    last = len(timed.points) - 1
    assert describe_point(timed, 0) == "point 0 at (0.1000 m, 0.0000 m), line 0"
    deep = time_path(polyline((0, 0, 0), (0.1, 0, -0.02)), LIMITS, PERIOD_S)
    assert "(0.0000 m, 0.0000 m, 0.0000 m), line 0" in describe_point(deep, 0)
    assert describe_point(timed, last) == f"point {last} at (0.2000 m, 0.0000 m), line 1"


def test_a_quarter_of_a_million_points_take_seconds() -> None:
    rng = np.random.default_rng(7)
    corners = np.cumsum(rng.normal(scale=0.02, size=(900, 2)), axis=0)
    path = polyline(*(tuple(corner) for corner in corners.tolist()), feed=0.5)
    begin = time.perf_counter()
    timed = time_path(path, LIMITS, PERIOD_S)
    assert len(timed.points) > 230_000
    assert time.perf_counter() - begin < 5.0
