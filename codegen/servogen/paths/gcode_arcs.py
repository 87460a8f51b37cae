"""Arcs of G-code, given by an offset to the centre or by a radius.

A file's numbers are rounded, so start, end and centre never quite agree. As common controls do,
radii that differ by up to 5 um, or by up to 0.1 % and 0.5 mm, count as equal; the centre is then
moved to the nearest point that has the same distance from both ends, so that the arc meets both.
Where that would carry off a nearly full circle, the centre stays and the end is missed by the
difference of the radii.
"""

from __future__ import annotations

import math

from servogen.paths.curves import EllipticArc, Line, Segment, circular_arc

ROUNDING_M = 5e-6
ROUNDING_SHARE = 1e-3
ROUNDING_MOST_M = 5e-4
# Flatter arcs are lines: their centre is too far away for double precision.
FLATTEST_SAG_M = 1e-9

Point = tuple[float, float]


class ArcError(ValueError):
    """A contradictory arc; ``value`` and ``expected`` are the parts of an InputError."""

    def __init__(self, value: str, expected: str) -> None:
        super().__init__(f"{value}, expected {expected}")
        self.value = value
        self.expected = expected


def arc_by_center(start: Point, end: Point, offset: Point, clockwise: bool) -> EllipticArc:
    """Arc around ``start + offset``; a full circle where start and end are the same. Metres.

    Raises:
        ArcError: the centre is at the start, or the ends' distances from it disagree.
    """
    center = (start[0] + offset[0], start[1] + offset[1])
    first, last = math.dist(start, center), math.dist(end, center)
    if first == 0.0:
        raise ArcError("an arc of radius 0", "I or J other than 0")
    difference = abs(first - last)
    if difference > max(ROUNDING_M, min(ROUNDING_SHARE * first, ROUNDING_MOST_M)):
        value = f"an arc of radius {_mm(first)} at its start and {_mm(last)} at its end"
        raise ArcError(value, "I and J that give the same radius at both ends")
    arc = _arc(start, end, center, clockwise)
    if start != end:
        moved = _on_bisector(start, end, center)
        if abs(arc.t1 - arc.t0) <= math.pi or math.dist(moved, center) <= 10.0 * difference:
            return _arc(start, end, moved, clockwise)
    return arc


def arc_by_radius(start: Point, end: Point, radius: float, clockwise: bool) -> Segment:
    """Arc of a radius (m) between two points, the longer one if the radius is below 0.

    Raises:
        ArcError: the ends are the same or further apart than twice the radius.
    """
    chord, size = math.dist(start, end), abs(radius)
    if chord == 0.0:
        raise ArcError("an arc by R that ends at its start", "I and J for a full circle")
    if 0.5 * chord > size + ROUNDING_M:
        value = f"an arc of radius {_mm(size)} between points {_mm(chord)} apart"
        raise ArcError(value, f"|R| of at least {_mm(0.5 * chord)}")
    if radius > 0.0 and chord**2 < 8.0 * size * FLATTEST_SAG_M:
        return Line(start, end)
    height = math.sqrt(max(size**2 - 0.25 * chord**2, 0.0))
    # The centre of the shorter counter-clockwise arc is to the left of the chord.
    side = height if clockwise == (radius < 0.0) else -height
    along = ((end[0] - start[0]) / chord, (end[1] - start[1]) / chord)
    center = (
        0.5 * (start[0] + end[0]) - side * along[1],
        0.5 * (start[1] + end[1]) + side * along[0],
    )
    return _arc(start, end, center, clockwise)


def _on_bisector(start: Point, end: Point, center: Point) -> Point:
    """The nearest point to ``center`` that has one distance from both ends."""
    chord = (end[0] - start[0], end[1] - start[1])
    length2 = chord[0] ** 2 + chord[1] ** 2
    middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
    along = ((center[0] - middle[0]) * chord[0] + (center[1] - middle[1]) * chord[1]) / length2
    return (center[0] - along * chord[0], center[1] - along * chord[1])


def _arc(start: Point, end: Point, center: Point, clockwise: bool) -> EllipticArc:
    radius = math.dist(start, center)
    first = math.atan2(start[1] - center[1], start[0] - center[0])
    last = math.atan2(end[1] - center[1], end[0] - center[0])
    sweep = (first - last if clockwise else last - first) % (2.0 * math.pi)
    if sweep == 0.0:
        sweep = 2.0 * math.pi
    return circular_arc(center, radius, first, first - sweep if clockwise else first + sweep)


def _mm(length_m: float) -> str:
    return f"{1e3 * length_m:.6g} mm"
