"""Affine images of segments, exact for all three kinds."""

from __future__ import annotations

import numpy as np

from servogen.paths.curves import EllipticArc, FloatArray, Line, Nurbs, Segment


def transformed(segment: Segment, matrix: FloatArray) -> Segment:
    """The image of a segment under a (3, 3) matrix in homogeneous coordinates."""

    (a, c, e), (b, d, f) = matrix[:2].tolist()

    def vector(xy: tuple[float, ...], shift: float = 1.0) -> tuple[float, float]:
        x, y = xy
        return (a * x + c * y + shift * e, b * x + d * y + shift * f)

    match segment:
        case Line():
            return Line(vector(segment.start), vector(segment.end))
        case EllipticArc():
            center, major = vector(segment.center), vector(segment.major, 0.0)
            return EllipticArc(center, major, vector(segment.minor, 0.0), segment.t0, segment.t1)
        case Nurbs():
            control = [vector((x, y)) for x, y in segment.control.tolist()]
            return Nurbs(np.array(control), segment.weights, segment.knots, segment.degree)
    raise TypeError(f"no rule for {type(segment).__name__}")
