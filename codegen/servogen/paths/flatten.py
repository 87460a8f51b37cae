"""Curves to polylines that know how curved they are."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from servogen.paths.curves import BoolArray, CurveSample, FloatArray, Line, Segment, lengths

# Below this radius the corner rule of the timing governs, not the curvature.
SMALLEST_RADIUS_M = 1e-6
# Directions that agree within this angle belong to one curve.
SMOOTH_ANGLE_RAD = 1e-4
_SCAN = 65
_MOST_ROUNDS = 40
MOST_PIECES = 2_000_000  # of one span: more is a tolerance out of all proportion


class TooFine(ValueError):
    """A curve would be cut into more than MOST_PIECES; the text says into how many."""


@dataclass(frozen=True)
class Flatness:
    """How finely curves are divided.

    ``tolerance_m`` bounds the chord error. A vertex on radius r turns the velocity
    sqrt(``centripetal`` r) by half of ``centripetal`` times ``turn_time_s``, so that samples taken
    every ``turn_time_s`` see the curve and not its polygon.
    """

    tolerance_m: float
    centripetal_acceleration_m_per_s2: float
    turn_time_s: float


@dataclass(frozen=True)
class Polyline:
    """Vertices (n, p), p 2 or 3, in metres, which lie inside a curve, and its radius there."""

    points: FloatArray
    smooth: BoolArray
    radius_m: FloatArray


def flatten(segments: tuple[Segment, ...], flatness: Flatness) -> Polyline:
    """Flatten segments that follow one another; the gaps between them are closed by the caller.

    Returns a polyline whose every piece is within ``flatness.tolerance_m`` of the curve, by the
    proven bounds of ``Segment.chord_errors``. Vertices
    where two segments meet count as smooth when the two directions agree.

    Raises:
        TooFine: a curve so long or a tolerance so small that it would take too many pieces.
    """
    spans = [
        _flatten_span(segment, float(low), float(high), flatness)
        for segment in segments
        for low, high in zip(segment.breaks[:-1], segment.breaks[1:], strict=True)
    ]
    points = np.vstack([spans[0].points, *[span.points[1:] for span in spans[1:]]])
    radius = spans[0].radius_m
    smooth = spans[0].smooth
    for before, after in pairwise(spans):
        joint_radius = min(before.radius_m[-1], after.radius_m[0])
        joint_smooth = math.isfinite(joint_radius) and _agree(before, after)
        radius = np.concatenate([radius[:-1], [joint_radius], after.radius_m[1:]])
        smooth = np.concatenate([smooth[:-1], [joint_smooth], after.smooth[1:]])
    return Polyline(points, smooth, radius)


def curvature_radius(sample: CurveSample) -> FloatArray:
    """Radius of curvature (n,) in metres, inf where straight, never under SMALLEST_RADIUS_M."""
    speed = lengths(sample.first)
    cross = areas(sample.first, sample.second)
    straight = cross <= 1e-9 * speed**3  # radius over 1e9 m
    radius = np.where(straight, np.inf, speed**3 / np.where(straight, 1.0, cross))
    floored: FloatArray = np.maximum(radius, SMALLEST_RADIUS_M)
    return floored


def areas(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n,) of the parallelograms between vectors (n, 2) or (n, 3) each."""
    found: FloatArray = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    if a.shape[1] == 3:
        for i, j in ((1, 2), (2, 0)):
            found = np.hypot(found, a[:, i] * b[:, j] - a[:, j] * b[:, i])
    return found


def _flatten_span(segment: Segment, low: float, high: float, flatness: Flatness) -> Polyline:
    """Flatten one C2 span, with vertices as dense as its curvature asks for."""
    if isinstance(segment, Line):
        return Polyline(
            np.array([segment.start, segment.end]), np.zeros(2, dtype=bool), np.full(2, np.inf)
        )
    parameters = _spread(segment, np.linspace(low, high, _SCAN), flatness)
    for _ in range(_MOST_ROUNDS):
        error = segment.chord_errors(parameters)
        coarse = np.flatnonzero(error > flatness.tolerance_m)
        if coarse.size == 0:
            break
        middle = 0.5 * (parameters[coarse] + parameters[coarse + 1])
        parameters = np.insert(parameters, coarse + 1, middle)
    sample = segment.sample(parameters)
    smooth = np.ones(len(parameters), dtype=bool)
    smooth[[0, -1]] = False
    return Polyline(sample.points, smooth, curvature_radius(sample))


def _spread(segment: Segment, scan: FloatArray, flatness: Flatness) -> FloatArray:
    """Parameters spaced by the local step length that chord error and turning allow."""
    sample = segment.sample(scan)
    radius = curvature_radius(sample)
    chord_step = np.sqrt(8.0 * radius * 0.9 * flatness.tolerance_m)
    turn_step = (
        0.5 * flatness.turn_time_s * np.sqrt(flatness.centripetal_acceleration_m_per_s2 * radius)
    )
    step = np.maximum(np.minimum(chord_step, turn_step), 0.1 * flatness.tolerance_m)
    density = lengths(sample.first) / step
    grown = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(scan) * (density[1:] + density[:-1]))])
    if scan[-1] < scan[0]:
        grown = -grown
    pieces = max(2, math.ceil(grown[-1]))
    if pieces > MOST_PIECES:
        raise TooFine(str(pieces))
    parameters = np.interp(np.linspace(0.0, grown[-1], pieces + 1), grown, scan)
    parameters[[0, -1]] = scan[[0, -1]]
    return parameters


def _agree(before: Polyline, after: Polyline) -> bool:
    """Whether two spans meet without a corner, judged by their polygons' turning."""
    incoming = before.points[-1] - before.points[-2]
    outgoing = after.points[1] - after.points[0]
    across = float(areas(incoming[None], outgoing[None])[0])
    turn = math.atan2(across, float(incoming @ outgoing))
    expected = 0.5 * (
        math.hypot(*incoming) / before.radius_m[-1] + math.hypot(*outgoing) / after.radius_m[0]
    )
    return bool(turn <= 1.05 * expected + SMOOTH_ANGLE_RAD)
