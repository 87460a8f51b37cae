"""Contours in time, with the distance to them: a circle, and any curve at constant feed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from servogen.precision import FloatArray

# Pieces of a curve between two samples that a distance is measured to: their own distance from the
# curve is a hundredth of that of a piece from sample to sample.
PIECES = 10
# Samples before and after the one that was due among whose points the nearest is sought: a curve
# that crosses itself passes by again much later, and a tool that was held up is far behind.
BEHIND, NEAR = 60, 20
# Samples before and after the nearest of these points whose pieces are measured to: past a corner
# that is taken within one the nearest piece may be on the other leg.
AROUND = 2
# Parameters at which a curve is sampled to find its length.
DENSE = 40_000


@dataclass(frozen=True)
class ContourMotion:
    """A contour in time.

    points: (K, p) one per sample, m. distance: (J,) m to it, of positions (J, p) at samples
    from a given one on.
    """

    points: FloatArray
    distance: Callable[[FloatArray, int], FloatArray]


def circle(
    radius_m: float, feed_m_per_s: float, sample_time_s: float, points: int
) -> ContourMotion:
    """About the origin, from (radius, 0) on, anticlockwise."""
    angle = np.arange(points) * (feed_m_per_s * sample_time_s / radius_m)
    path = radius_m * np.column_stack([np.cos(angle), np.sin(angle)])

    def distance(positions: FloatArray, first: int) -> FloatArray:
        result: FloatArray = np.abs(np.hypot(positions[:, 0], positions[:, 1]) - radius_m)
        return result

    return ContourMotion(path, distance)


def butterfly(turn: FloatArray) -> FloatArray:
    """(K, 2) Fay's curve of parameters (K,) in turns of 2 pi: it closes after twelve, crosses
    itself and bends sharply; its largest radius is about five."""
    t = 2.0 * np.pi * turn
    radius = np.exp(np.cos(t)) - 2.0 * np.cos(4.0 * t) + np.sin(t / 12.0) ** 5
    return np.column_stack([radius * np.sin(t), radius * np.cos(t)])


def at_feed(
    curve: Callable[[FloatArray], FloatArray],
    end: float,
    feed_m_per_s: float,
    sample_time_s: float,
) -> ContourMotion:
    """The curve from parameter 0 to ``end``, metres, in points of equal distance along it."""
    dense = curve(np.linspace(0.0, end, DENSE))
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    places = np.arange(0.0, length[-1], feed_m_per_s * sample_time_s / PIECES)
    fine = np.column_stack([np.interp(places, length, column) for column in dense.T])
    return traced(fine)


def traced(fine: FloatArray) -> ContourMotion:
    """Of points (K, p), every tenth (``PIECES``) of which is due at a sample; distances are to
    the pieces between them."""
    fine = np.asarray(fine, dtype=np.float64)

    def distance(positions: FloatArray, first: int) -> FloatArray:
        due = PIECES * (first + np.arange(len(positions)))
        nearest, least = due, np.full(len(positions), np.inf)
        for offset in range(-PIECES * BEHIND, PIECES * NEAR + 1, PIECES):
            at = np.clip(due + offset, 0, len(fine) - 1)
            square = np.sum((positions - fine[at]) ** 2, axis=1)
            nearest, least = np.where(square < least, at, nearest), np.minimum(least, square)
        least = np.full(len(positions), np.inf)
        for offset in range(-PIECES * AROUND, PIECES * AROUND):
            at = np.clip(nearest + offset, 0, len(fine) - 2)
            least = np.minimum(least, _to_pieces(positions, fine[at], fine[at + 1]))
        return least

    return ContourMotion(fine[::PIECES], distance)


def _to_pieces(points: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    """(J,) distances of points to the pieces from begin to end, which may be points themselves."""
    way = end - begin
    square = np.sum(way * way, axis=1)
    share = np.sum((points - begin) * way, axis=1) / np.where(square > 0.0, square, 1.0)
    nearest = begin + np.clip(share, 0.0, 1.0)[:, None] * way
    result: FloatArray = np.linalg.norm(points - nearest, axis=1)
    return result
