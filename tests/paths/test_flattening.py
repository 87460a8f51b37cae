"""Flattening: the chord error is kept, and no more vertices are spent than that takes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from drawings import SETTINGS, dense, distance_from_polyline
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from servogen.errors import InputError
from servogen.paths.curves import (
    EllipticArc,
    Helix,
    Line,
    Nurbs,
    Segment,
    Stroke,
    bezier,
    circular_arc,
)
from servogen.paths.flatten import Flatness, flatten
from servogen.paths.geometry import build_tool_path

# Without the turning rule, so that the tolerance alone decides.
COARSE = Flatness(tolerance_m=2e-5, centripetal_acceleration_m_per_s2=34.3, turn_time_s=1.0)
coordinate = st.floats(-0.1, 0.1)
point = st.tuples(coordinate, coordinate)


@st.composite
def curves(draw: st.DrawFn) -> Segment:
    """Arcs of sheared ellipses, helices, Bezier curves, rational splines of degree 2 to 5."""
    kind = draw(st.sampled_from(["arc", "helix", "bezier", "nurbs"]))
    if kind in ("arc", "helix"):
        sweep = draw(st.floats(0.05, 6.28)) * draw(st.sampled_from([-1.0, 1.0]))
        start = draw(st.floats(-7.0, 7.0))
        arc = EllipticArc(draw(point), draw(point), draw(point), start, start + sweep)
        return arc if kind == "arc" else Helix(arc, draw(coordinate), draw(coordinate))
    if kind == "bezier":
        return bezier(np.array(draw(st.lists(point, min_size=3, max_size=6))))
    degree = draw(st.integers(2, 5))
    control = np.array(draw(st.lists(point, min_size=degree + 2, max_size=degree + 4)))
    inner = len(control) - degree - 1
    knots = np.concatenate([np.zeros(degree), np.linspace(0, 1, inner + 2), np.ones(degree)])
    weight = st.floats(0.2, 5.0)
    weights = np.array(draw(st.lists(weight, min_size=len(control), max_size=len(control))))
    return Nurbs(control, weights, knots, degree)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(curves())
def test_no_curve_leaves_its_polyline_by_more_than_the_tolerance(curve: Segment) -> None:
    line = flatten((curve,), COARSE)
    assert distance_from_polyline(dense(curve, 1500), line.points).max() <= COARSE.tolerance_m


@settings(derandomize=True, deadline=None, max_examples=40)
@given(curves(), st.integers(3, 40))
def test_the_bound_on_the_chord_error_is_one(curve: Segment, pieces: int) -> None:
    """Piece by piece, on divisions that the flattening would not choose."""
    for low, high in zip(curve.breaks[:-1], curve.breaks[1:], strict=True):
        parameters = np.linspace(low, high, pieces + 1)
        points = curve.sample(parameters).points
        bounds = curve.chord_errors(parameters)
        for k in range(pieces):
            between = curve.sample(np.linspace(parameters[k], parameters[k + 1], 40)).points
            error = distance_from_polyline(between, points[k : k + 2]).max()
            assert error <= bounds[k] * (1.0 + 1e-9) + 1e-15


def test_the_bound_is_exact_for_circles_and_close_for_beziers() -> None:
    circle = circular_arc((0.0, 0.0), 0.05, 0.0, math.pi)
    assert_allclose(circle.chord_errors(np.array([0.0, 0.5])), 0.05 * (1 - math.cos(0.25)))
    cubic = bezier(np.array([[0, 0], [0.01, 0.02], [0.03, 0.02], [0.04, 0.0]]))
    parameters = np.linspace(0.0, 1.0, 65)
    points = cubic.sample(parameters).points
    halves = cubic.sample(parameters[:-1] + 0.5 / 64).points
    errors = np.array(
        [distance_from_polyline(halves[k : k + 1], points[k : k + 2])[0] for k in range(64)]
    )
    assert (cubic.chord_errors(parameters) <= 1.4 * errors).all()


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6])
def test_vertices_are_about_as_few_as_the_tolerance_allows(tolerance: float) -> None:
    flatness = Flatness(tolerance, 34.3, 1.0)
    line = flatten((circular_arc((0.0, 0.0), 0.05, 0.0, 2.0 * math.pi),), flatness)
    fewest = math.pi / math.acos(1.0 - tolerance / 0.05)
    assert fewest <= len(line.points) - 1 <= 1.1 * fewest + 2


def test_radius_and_smoothness_are_known_along_arcs() -> None:
    line = flatten((circular_arc((0.0, 0.0), 0.02, 1.0, 4.0),), COARSE)
    assert_allclose(line.radius_m, 0.02)
    assert line.smooth.tolist() == [False] + [True] * (len(line.points) - 2) + [False]


def test_ellipses_are_finer_where_they_turn_faster() -> None:
    line = flatten((EllipticArc((0, 0), (0.05, 0), (0, 0.01), 0.0, 2 * math.pi),), COARSE)
    assert line.radius_m.min() == pytest.approx(0.01**2 / 0.05, rel=1e-6)
    assert line.radius_m.max() == pytest.approx(0.05**2 / 0.01, rel=1e-2)


def test_joints_are_smooth_only_where_directions_agree() -> None:
    arc = circular_arc((0.0, 0.01), 0.01, -0.5 * math.pi, 0.0)
    tangent = flatten((Line((-0.01, 0.0), (0.0, 0.0)), arc), COARSE)
    assert bool(tangent.smooth[1])
    for angle_deg in (10.0, 90.0):
        angle = math.radians(angle_deg)
        before = (-0.01 * math.cos(angle), -0.01 * math.sin(angle))
        corner = flatten((Line(before, (0.0, 0.0)), arc), COARSE)
        assert not corner.smooth[1]
    between = flatten((Line((0, 0), (1e-2, 0)), Line((1e-2, 0), (2e-2, 0))), COARSE)
    assert not between.smooth[1]


def test_curves_are_fine_enough_for_the_samples() -> None:
    """A vertex turns the velocity by half of the centripetal acceleration times the turn time."""
    flatness = Flatness(1e-3, 34.3, 2e-4)
    line = flatten((circular_arc((0.0, 0.0), 0.05, 0.0, 2.0),), flatness)
    speed = math.sqrt(34.3 * 0.05)
    direction = np.diff(line.points, axis=0)
    turn = np.hypot(*np.diff(direction / np.hypot(*direction.T)[:, None], axis=0).T)
    assert (speed * turn).max() <= 0.5 * 34.3 * 2e-4 * 1.01


def test_a_cusp_is_flattened_too() -> None:
    cusp = bezier(np.array([[0, 0], [0.02, 0.02], [0, 0.02], [0.02, 0]]))
    line = flatten((cusp,), COARSE)
    assert distance_from_polyline(dense(cusp), line.points).max() <= COARSE.tolerance_m


def test_a_tolerance_out_of_proportion_is_refused(tmp_path: Path) -> None:
    circle = Stroke("CIRCLE #1", (circular_arc((0.0, 0.0), 900.0, 0.0, 6.0),))
    fine = SETTINGS.__class__(tolerance_m=1e-9, corner_time_s=1e-6)
    with pytest.raises(InputError, match=r"CIRCLE #1 is cut into \d+ pieces, expected at most"):
        build_tool_path([circle], fine, tmp_path / "a.dxf", reorder=True)
