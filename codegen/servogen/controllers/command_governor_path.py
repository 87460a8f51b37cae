"""Which points of the path each period of a plan machines: the predicted indices of paper 4.

The path's points are numbered from the last one machined, 0. Interval i of the plan begins with
``indices[i]`` points machined and ends with ``indices[i + 1]``; the last interval, all that follows
the plan, machines none. In each interval the tool is at the point that it begins with, and then at
those it machines: all of them must be within the stroke of the stage at both ends of the interval,
which by (15) is all that happens between. A point can end an interval only if the next one can
begin with it.

The points that the last plan gave to an interval are not asked again: the programs kept them, to
their own tolerance, and a stricter question here would be a standstill for good. So the plan before
can always be continued. Where the taking of more points ends badly, the last point taken that can
wait from then on is waited at; where that is no more than the last plan had, its indices are taken
up again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.precision import FloatArray

IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Reach:
    """Points in reach of one axis in every interval: ``least``, ``greatest`` (intervals,), m."""

    least: FloatArray
    greatest: FloatArray


def predicted_indices(
    points: tuple[FloatArray, FloatArray],
    reach: tuple[Reach, Reach],
    planned: IntArray,
    most: int,
) -> IntArray:
    """The largest indices, interval after interval, that end well.

    Args:
        points: of both axes, (1 + n,) m; [0] is the last one machined.
        reach: of both axes, by the plan that is continued.
        planned: (intervals,) indices of that plan, from 0, never falling.
        most: M, points of an interval.
    """
    intervals, last = planned.size, points[0].size - 1
    following = np.append(planned, planned[-1])
    indices = np.zeros(intervals, dtype=np.int64)
    for i in range(intervals - 1):
        begin = int(indices[i])
        end = min(begin + most, last)
        run = _run(points, reach, begin, end, i, int(following[i + 1]))
        ends = _ending(points, reach, begin, run, i + 1, following)
        if ends >= 0:
            indices[i + 1] = ends
        elif not _wait(points, reach, indices, i + 1, int(planned[i + 1])):
            _rejoin(indices, planned, i + 1)
    return indices


def _wait(
    points: tuple[FloatArray, FloatArray],
    reach: tuple[Reach, Reach],
    indices: IntArray,
    until: int,
    planned: int,
) -> bool:
    """Wait for interval ``until`` at the last point taken, beyond ``planned``, that is in reach in
    all intervals from the one after it was taken; False, and nothing done, where there is none."""
    least = [axis.least[until] for axis in reach]
    greatest = [axis.greatest[until] for axis in reach]
    for i in range(until - 1, -1, -1):
        # taken in interval i - 1: from the indices at its beginning to those at its end
        first = max(int(indices[i - 1]) if i else 0, planned + 1)
        for j, axis in enumerate(reach):
            least[j] = max(least[j], axis.least[i])
            greatest[j] = min(greatest[j], axis.greatest[i])
        for point in range(int(indices[i]), first - 1, -1):
            if all(
                low <= own[point] <= high
                for own, low, high in zip(points, least, greatest, strict=True)
            ):
                indices[i : until + 1] = point
                return True
    return False


def _rejoin(indices: IntArray, planned: IntArray, until: int) -> None:
    """Take up the indices planned, up to ``until``, from the last interval whose own they hold."""
    held = np.flatnonzero(indices[:until] <= planned[1 : until + 1])
    from_here = int(held[-1]) + 1
    indices[from_here : until + 1] = planned[from_here : until + 1]


def _inside(
    points: tuple[FloatArray, FloatArray], reach: tuple[Reach, Reach], where: slice, interval: int
) -> npt.NDArray[np.bool_]:
    inside = np.ones(len(points[0][where]), dtype=bool)
    for own, axis in zip(points, reach, strict=True):
        part = own[where]
        inside &= (part >= axis.least[interval]) & (part <= axis.greatest[interval])
    return inside


def _run(
    points: tuple[FloatArray, FloatArray],
    reach: tuple[Reach, Reach],
    begin: int,
    end: int,
    interval: int,
    planned: int,
) -> int:
    """Last point, at most ``end``, up to which all after ``begin`` are in reach or planned."""
    first = max(begin, min(planned, end))
    beyond = np.flatnonzero(~_inside(points, reach, slice(first + 1, end + 1), interval))
    return first + int(beyond[0]) if beyond.size else end


def _ending(
    points: tuple[FloatArray, FloatArray],
    reach: tuple[Reach, Reach],
    begin: int,
    run: int,
    following: int,
    planned: IntArray,
) -> int:
    """Last point, ``begin`` to ``run``, with which interval ``following`` can begin; -1: none."""
    good = _inside(points, reach, slice(begin, run + 1), following)
    numbers = np.arange(begin, run + 1)
    good |= (numbers >= planned[following]) & (numbers <= planned[following + 1])
    return begin + int(np.flatnonzero(good)[-1]) if np.any(good) else -1
