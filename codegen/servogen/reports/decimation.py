"""Fewer points, same picture: what a plot keeps of a long signal or curve."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from servogen.precision import FloatArray, IntArray


def keep_extremes(values: FloatArray, buckets: int) -> IntArray:
    """Ascending indices of the least and greatest value in each of ``buckets`` equal stretches.

    The first and the last sample stay too. At most 2 buckets + 2 indices; all of them if that is
    no fewer. A peak of a single sample is never lost, nor moved in time.

    Args:
        values: (n,).
    """
    n = values.size
    if buckets < 1:
        raise ValueError("at least one bucket")
    if n <= 2 * buckets + 2:
        return np.arange(n)
    edges = np.linspace(0, n, buckets + 1).astype(np.int64)
    kept = [np.array([0, n - 1])]
    for begin, end in pairwise(edges.tolist()):
        part = values[begin:end]
        kept.append(np.array([begin + int(np.argmin(part)), begin + int(np.argmax(part))]))
    return np.unique(np.concatenate(kept))


def simplify(points: FloatArray, tolerance: float) -> IntArray:
    """Ascending indices of vertices whose polyline stays within ``tolerance`` of all ``points``.

    Ramer, Douglas and Peucker, with the distance to the chord between kept vertices as a segment.

    Args:
        points: (n, 2).
    """
    n = len(points)
    if n <= 2:
        return np.arange(n)
    kept = np.zeros(n, dtype=bool)
    kept[[0, n - 1]] = True
    open_parts = [(0, n - 1)]
    while open_parts:
        begin, end = open_parts.pop()
        if end - begin < 2:
            continue
        distance = _to_segment(points[begin + 1 : end], points[begin], points[end])
        far = int(np.argmax(distance))
        if distance[far] > tolerance:
            middle = begin + 1 + far
            kept[middle] = True
            open_parts += [(begin, middle), (middle, end)]
    return np.flatnonzero(kept)


def _to_segment(points: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    along = end - begin
    length = float(along @ along)
    share = np.clip((points - begin) @ along / length, 0.0, 1.0) if length > 0.0 else 0.0
    nearest = begin + np.multiply.outer(np.broadcast_to(share, len(points)), along)
    result: FloatArray = np.hypot(*(points - nearest).T)
    return result
