"""Critical regions on a plane: convex polygons, by cutting a rectangle with half-planes."""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray


def rectangle(width: float, height: float) -> FloatArray:
    """(4, 2) corners of |x| <= width, |y| <= height, counter-clockwise."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    result: FloatArray = corners * np.array([width, height])
    return result


def cut(polygon: FloatArray, normal: FloatArray, bound: float) -> FloatArray:
    """(v, 2) what of a convex polygon lies in normal . x <= bound; no corners where none does."""
    if polygon.shape[0] == 0:
        return polygon
    height = polygon @ normal - bound
    following = np.roll(height, -1)
    corners = []
    for i, (here, there) in enumerate(zip(height.tolist(), following.tolist(), strict=True)):
        start, end = polygon[i], polygon[(i + 1) % polygon.shape[0]]
        if here <= 0.0:
            corners.append(start)
        if (here < 0.0 < there) or (there < 0.0 < here):
            corners.append(start + (end - start) * (here / (here - there)))
    return np.array(corners) if len(corners) > 2 else np.empty((0, 2))


def section(
    h: FloatArray, k: FloatArray, plane: FloatArray, foot: FloatArray, frame: FloatArray
) -> FloatArray:
    """(v, 2) the part of {h eta <= k} on eta = plane x + foot within ``frame``.

    Args:
        h, k: (rows, r), (rows,); plane: (r, 2); foot: (r,); frame: (f, 2) convex.
    """
    polygon = frame
    for row, bound in zip(h @ plane, k - h @ foot, strict=True):
        polygon = cut(polygon, row, float(bound))
    return polygon


def area(polygon: FloatArray) -> float:
    """Of a polygon (v, 2)."""
    if polygon.shape[0] < 3:
        return 0.0
    x, y = polygon.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
