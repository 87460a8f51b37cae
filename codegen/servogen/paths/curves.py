"""The geometry every reader translates its drawing into: strokes made of three kinds of segment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


class CurveSample(NamedTuple):
    """Points of a curve and their first two derivatives by the parameter, each (n, p), p 2 or 3."""

    points: FloatArray
    first: FloatArray
    second: FloatArray


class Segment(Protocol):
    """A smooth parametric curve in metres. ``breaks`` are parameters between which it is C2."""

    @property
    def breaks(self) -> FloatArray: ...

    def sample(self, parameters: FloatArray) -> CurveSample: ...

    def chord_errors(self, parameters: FloatArray) -> FloatArray:
        """Proven bounds (n-1,) on the distance (m) of the curve from its chords.

        ``parameters`` (n,) ascend or descend with the curve and lie within one span of ``breaks``.
        """
        ...


@dataclass(frozen=True)
class Line:
    """Straight from ``start`` to ``end`` (m), parameter 0 to 1."""

    start: tuple[float, ...]
    end: tuple[float, ...]

    @property
    def breaks(self) -> FloatArray:
        return np.array([0.0, 1.0])

    def sample(self, parameters: FloatArray) -> CurveSample:
        start, end = np.array(self.start), np.array(self.end)
        # The two-sided form gives both ends exactly.
        points = np.outer(1.0 - parameters, start) + np.outer(parameters, end)
        first = np.broadcast_to(end - start, points.shape)
        return CurveSample(points, first, np.zeros_like(points))

    def chord_errors(self, parameters: FloatArray) -> FloatArray:
        return np.zeros(len(parameters) - 1)


@dataclass(frozen=True)
class EllipticArc:
    """``center + cos(t) major + sin(t) minor`` (m) for t from ``t0`` to ``t1`` (rad, either way).

    The two axis vectors need not be perpendicular, so that every affine image of an arc of a
    circle is one of these. t1 < t0 runs backwards.
    """

    center: tuple[float, float]
    major: tuple[float, float]
    minor: tuple[float, float]
    t0: float
    t1: float

    @property
    def breaks(self) -> FloatArray:
        # A full turn is cut in two so that no span returns to its own start.
        return np.linspace(self.t0, self.t1, 3)

    def sample(self, parameters: FloatArray) -> CurveSample:
        center, major, minor = np.array(self.center), np.array(self.major), np.array(self.minor)
        cosine, sine = np.cos(parameters), np.sin(parameters)
        radial = np.outer(cosine, major) + np.outer(sine, minor)
        first = np.outer(cosine, minor) - np.outer(sine, major)
        return CurveSample(center + radial, first, -radial)

    def chord_errors(self, parameters: FloatArray) -> FloatArray:
        # With P the radius vector and Q its derivative half way, the curve at an angle s from
        # there is c + cos(s) P + sin(s) Q, and c + cos(h) P + sin(s) Q lies on the chord for
        # |s| <= h <= pi/2: they differ by (cos(s) - cos(h)) P.
        half = 0.5 * np.diff(parameters)
        _, _, second = self.sample(parameters[:-1] + half)
        return 2.0 * np.sin(0.5 * half) ** 2 * lengths(second)


@dataclass(frozen=True)
class Helix:
    """An arc in x and y along which z goes from ``z0`` to ``z1`` (m) in proportion to the angle."""

    arc: EllipticArc
    z0: float
    z1: float

    @property
    def breaks(self) -> FloatArray:
        return self.arc.breaks

    @property
    def _slope(self) -> float:
        """Metres per radian."""
        return (self.z1 - self.z0) / (self.arc.t1 - self.arc.t0)

    def sample(self, parameters: FloatArray) -> CurveSample:
        flat = self.arc.sample(parameters)
        share = (parameters - self.arc.t0) / (self.arc.t1 - self.arc.t0)
        height = (1.0 - share) * self.z0 + share * self.z1  # both ends exact
        points, first, second = (
            np.column_stack([of_arc, of_z])
            for of_arc, of_z in zip(
                flat,
                (height, np.full(len(share), self._slope), np.zeros(len(share))),
                strict=True,
            )
        )
        return CurveSample(points, first, second)

    def chord_errors(self, parameters: FloatArray) -> FloatArray:
        # The point of the chord that the arc's bound is to is off along z by the slope times
        # s - h sin(s) / sin(h), which is largest where cos(s) = sin(h) / h. The two
        # are not largest together: the bound is on the safe side.
        half = np.maximum(0.5 * np.abs(np.diff(parameters)), 1e-300)
        worst = np.arccos(np.minimum(np.sin(half) / half, 1.0))
        along = np.abs(self._slope * (worst - half * np.sin(worst) / np.sin(half)))
        bounds: FloatArray = np.hypot(self.arc.chord_errors(parameters), along)
        return bounds


def circular_arc(
    center: tuple[float, float], radius: float, start_angle: float, end_angle: float
) -> EllipticArc:
    """Arc of a circle between two angles (rad); clockwise if the end angle is the smaller one."""
    return EllipticArc(center, (radius, 0.0), (0.0, radius), start_angle, end_angle)


@dataclass(frozen=True)
class Nurbs:
    """A rational B-spline; a Bezier curve is the case of one span.

    ``control`` is (n, 2) in metres, ``weights`` (n,), ``knots`` (n + degree + 1,).
    """

    control: FloatArray
    weights: FloatArray
    knots: FloatArray
    degree: int

    @property
    def breaks(self) -> FloatArray:
        inside = self.knots[self.degree : len(self.knots) - self.degree]
        return np.unique(inside)

    def sample(self, parameters: FloatArray) -> CurveSample:
        homogeneous = np.column_stack([self.control * self.weights[:, None], self.weights])
        spline = BSpline(self.knots, homogeneous, self.degree)
        value, first, second = (spline(parameters, nu=order) for order in range(3))
        w = value[:, 2:]
        points = value[:, :2] / w
        d1 = (first[:, :2] - points * first[:, 2:]) / w
        d2 = (second[:, :2] - 2.0 * d1 * first[:, 2:] - points * second[:, 2:]) / w
        return CurveSample(points, d1, d2)

    def chord_errors(self, parameters: FloatArray) -> FloatArray:
        """The curve lies in the hull of the control points of each of its pieces."""
        points = self.sample(parameters).points
        step = np.diff(parameters)
        # Seen from the middle of the piece, so that a break at one of its ends is not looked
        # across; then to the Bernstein form on the piece.
        homogeneous = np.column_stack([self.control * self.weights[:, None], self.weights])
        spline = BSpline(self.knots, homogeneous, self.degree)
        middle = parameters[:-1] + 0.5 * step
        taylor = [
            spline(middle, nu=order) * (0.5 * step[:, None]) ** order / math.factorial(order)
            for order in range(self.degree + 1)
        ]
        control = np.einsum("ji,ink->jnk", _centred_to_bernstein(self.degree), np.array(taylor))
        weight = control[..., 2:]
        whole = (weight > 0.0).all(axis=(0, 2))
        positions = control[..., :2] / np.where(weight > 0.0, weight, 1.0)
        gaps = [_gap_to_chord(row, points[:-1], points[1:]) for row in positions]
        return np.where(whole, np.max(gaps, axis=0), np.inf)


def lengths(vectors: FloatArray) -> FloatArray:
    """Euclidean lengths (n,) of vectors (n, 2) or (n, 3)."""
    found: FloatArray = np.hypot(vectors[:, 0], vectors[:, 1])
    for column in vectors.T[2:]:
        found = np.hypot(found, column)  # a zero leaves the bits as they are
    return found


def _gap_to_chord(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Distance of points (n, 2) from the chords start-end (n, 2 each), in metres."""
    chord = end - start
    length2 = np.maximum((chord**2).sum(axis=1), 1e-300)
    along = np.clip(((points - start) * chord).sum(axis=1) / length2, 0.0, 1.0)
    return lengths(points - start - along[:, None] * chord)


def _centred_to_bernstein(degree: int) -> FloatArray:
    """(degree+1, degree+1): coefficients of u^i, u in [-1, 1], to Bernstein ones on that interval.

    By the blossom: control point j is the polar form at degree-j times -1 and j times +1, where
    u^i has the mean of all products of i of these arguments.
    """
    table = np.zeros((degree + 1, degree + 1))
    for j in range(degree + 1):
        for i in range(degree + 1):
            products = sum(
                math.comb(j, plus) * math.comb(degree - j, i - plus) * (-1) ** (i - plus)
                for plus in range(max(0, i - degree + j), min(i, j) + 1)
            )
            table[j, i] = products / math.comb(degree, i)
    return table


def bezier(control: FloatArray) -> Nurbs:
    """Bezier curve through (degree + 1, 2) control points in metres."""
    degree = len(control) - 1
    knots = np.concatenate([np.zeros(degree + 1), np.ones(degree + 1)])
    return Nurbs(control, np.ones(degree + 1), knots, degree)


@dataclass(frozen=True)
class Stroke:
    """One entity of a drawing: segments that follow one another without a gap.

    ``label`` names the entity in messages ("LWPOLYLINE #2F", "line 12"); ``feed_m_per_s`` is what
    the drawing says, or None for the project's feed.
    """

    label: str
    segments: tuple[Segment, ...]
    feed_m_per_s: float | None = None
