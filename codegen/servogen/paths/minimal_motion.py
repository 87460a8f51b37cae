"""Minimal motion (19)-(20): the least that a slow stage has to move so that a fast one reaches all.

One axis at a time. The fast stage reaches a stroke to either side of the slow one, so the slow
stage's reference x may be anywhere in a tube around the pattern, lower_j <= x_j <= upper_j. (20)
asks for the least distance covered, the sum of |x_{j+1} - x_j|, which many sequences have. Of these
the paper wants the one that stays away from the envelope and runs straight where it does not touch
it; that is the taut string, the shortest line through the tube over the index j, and no other:

- straight wherever it is strictly inside: it may bend on the envelope alone;
- away from the envelope wherever it can be: it bends around a bound that stands in its way (convex
  at an upper bound, concave at a lower one) and never the other way, as such a bend could be moved
  off the envelope, to the inside, and come out straighter.

A line with these two properties satisfies the optimality conditions of every cost that is a sum of
one convex function of the steps x_{j+1} - x_j (least at zero, where an end is free). So the taut
string has the least total variation, at once the least sum of squares, of which there is only one,
and the least largest step: with points that come at a fixed rate, the slowest slow stage.

It stays between the pattern's least and greatest coordinates (and its ends), so position limits
that the pattern keeps need no bound of their own.

Ends. The paper begins and ends on the pattern's own points, x_1 = w_1 and x_J = w_J: pass these as
``start`` and ``end``, as ``pattern_motion`` does. A free end costs nothing, so there the string
runs level: at the height of the first bend, which is settled by what the tube asks for later. Where
one constant serves for the whole path, every constant in the tube costs nothing; between two free
ends the middle of these is taken, the farthest from the envelope.

O(n). A path of more than ``SHORT`` points goes through compiled C where there is a gcc, any other
through its Python reference; both compute the same bits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from servogen.errors import InputError
from servogen.paths.curves import FloatArray
from servogen.paths.taut_compiled import has_compiler, taut_string_compiled
from servogen.paths.taut_string import heights_along, taut_string

# Below it Python is done before the compiler is.
SHORT = 4096
# So that a difference of two coordinates times a number of points is still a number.
LARGEST = 1e290
# Places are int32 in C.
MOST_POINTS = 2**31 - 1


def minimal_motion(
    lower: FloatArray, upper: FloatArray, *, start: float | None = None, end: float | None = None
) -> FloatArray:
    """The taut string through a tube, (19)-(20) for one axis.

    Args:
        lower, upper: (n,) bounds of the reference at every point of the pattern, in metres (or any
            unit), n >= 1. They may be equal.
        start, end: the reference at the first and at the last point, within the bounds there;
            None leaves it free. The paper's are the pattern's own points.

    Returns:
        (n,) the reference, in the unit of the bounds: every point within its bounds, exactly.

    Raises:
        InputError: arrays that are empty or of different shapes, a bound that is not finite or
            beyond ``LARGEST``, a lower bound above the upper one, an end outside its bounds.
    """
    return _solve(lower, upper, start, end)[0]


def look_ahead(
    lower: FloatArray, upper: FloatArray, *, start: float | None = None, end: float | None = None
) -> int:
    """The most points ahead of a point that must be known before its reference is.

    A window that sees as far gives the answer of the whole path.

    Args, Raises: as ``minimal_motion``.
    """
    return _solve(lower, upper, start, end)[1]


def tube_around(
    points: ArrayLike, stroke: float, margin: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Bounds (n,) of the reference: |x - w| <= delta - eps at every point w.

    Args:
        points: (n,) the pattern on one axis, in metres.
        stroke: delta, reach of the fast stage to either side, in metres.
        margin: eps, in metres, from 0 to the stroke; the paper wants it positive, so that a slow
            stage has room to converge to the reference.

    Raises:
        InputError: points that are not finite, a stroke or a margin out of range.
    """
    centre = np.asarray(points, dtype=np.float64)
    if not (np.isfinite(stroke) and stroke >= 0.0):
        raise InputError(None, "stroke", stroke, "a number from 0 on")
    if not 0.0 <= margin <= stroke:
        raise InputError(None, "margin", margin, f"from 0 to the stroke, {stroke:g}")
    _check_finite("points", centre)
    return centre - (stroke - margin), centre + (stroke - margin)


def pattern_motion(
    points: ArrayLike, stroke: ArrayLike, margin: float = 0.0, *, free_ends: bool = False
) -> FloatArray:
    """The minimal motion of a pattern, axis by axis.

    Args:
        points: (n, axes) the pattern, in metres. stroke: (axes,) or one for all; margin: see
            ``tube_around``. free_ends: by default the motion begins and ends on the pattern's
            first and last points, as in the paper.

    Returns:
        (n, axes) the slow stages' reference, in metres.

    Raises:
        InputError: as ``tube_around`` and ``minimal_motion``.
    """
    pattern = np.asarray(points, dtype=np.float64)
    if pattern.ndim != 2 or not pattern.size:
        raise InputError(None, "points", f"of shape {pattern.shape}", "one row for each point")
    strokes = np.broadcast_to(np.asarray(stroke, dtype=np.float64), pattern.shape[1:])
    motion = np.empty_like(pattern)
    for axis, reach in enumerate(strokes.tolist()):
        lower, upper = tube_around(pattern[:, axis], reach, margin)
        ends = (None, None) if free_ends else (pattern[0, axis], pattern[-1, axis])
        motion[:, axis] = _solve(lower, upper, *ends)[0]
    return motion


def _solve(
    lower: ArrayLike, upper: ArrayLike, start: float | None, end: float | None
) -> tuple[FloatArray, int]:
    """The reference and its look-ahead."""
    low, high = _checked(lower, upper)
    for key, value, at in (("start", start, 0), ("end", end, -1)):
        if value is None:
            continue
        if not low[at] <= value <= high[at]:
            expected = f"a number from {low[at]:.17g} to {high[at]:.17g}"
            raise InputError(None, key, value, expected)
        low[at] = high[at] = value
    level, last, seen = (float(low[0]), 0, 0) if start is not None else _level_run(low, high)
    rest, ahead = _string(low[last + 1 :], high[last + 1 :], level)
    return np.concatenate([np.full(last + 1, level), rest]), max(seen, ahead)


def _checked(lower: ArrayLike, upper: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Copies of the bounds."""
    low, high = np.array(lower, dtype=np.float64), np.array(upper, dtype=np.float64)
    if low.ndim != 1 or not 0 < low.size <= MOST_POINTS:
        raise InputError(None, "lower", f"of shape {low.shape}", "a list of one bound or more")
    if high.shape != low.shape:
        raise InputError(None, "upper", f"of shape {high.shape}", f"{low.shape}, as the lower ones")
    _check_finite("lower", low)
    _check_finite("upper", high)
    crossed = low > high
    if crossed.any():
        j = int(np.argmax(crossed))
        raise InputError(None, f"lower[{j}]", float(low[j]), f"at most the upper bound {high[j]:g}")
    return low, high


def _check_finite(key: str, values: FloatArray) -> None:
    """NaN fails the comparison too."""
    usable = np.abs(values) <= LARGEST
    if not usable.all():
        j = int(np.argmin(usable))
        raise InputError(None, f"{key}[{j}]", float(values[j]), f"a number of at most {LARGEST:g}")


def _level_run(low: FloatArray, high: FloatArray) -> tuple[float, int, int]:
    """How a string with a free start begins: level, at which height, until which point, and the
    point at which that is known.

    It is level until no height serves for all points so far. If it has to rise then, it stood as
    high as the lowest upper bound lets it and leaves there, and the other way round.
    """
    most, least = np.maximum.accumulate(low), np.minimum.accumulate(high)
    crossed = most > least
    if not crossed.any():
        return float(0.5 * most[-1] + 0.5 * least[-1]), low.size - 1, low.size - 1
    seen = int(np.argmax(crossed))
    rises = low[seen] > least[seen - 1]
    level = float(least[seen - 1] if rises else most[seen - 1])
    stands = (high if rises else low)[:seen] == level
    return level, seen - 1 - int(np.argmax(stands[::-1])), seen


def _string(low: FloatArray, high: FloatArray, start: float) -> tuple[FloatArray, int]:
    """The taut string (n,) from one point before the first, and its look-ahead."""
    if low.size > SHORT and has_compiler():
        return taut_string_compiled(low, high, start)
    lower, upper = low.tolist(), high.tolist()
    knots = taut_string(lower, upper, start)
    return np.array(heights_along(knots, lower, upper, low.size)), knots.look_ahead
