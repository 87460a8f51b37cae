"""Tool path to timed points: where an ideal machine would be every T_f.

toppra is not used: it times smooth splines under joint limits in continuous time, while here the
binding limit is the second difference of the samples at the corners of a polyline, which it does
not see; the look-ahead below needs nothing but numpy and is exact for piecewise straight paths.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from servogen.errors import InputError
from servogen.paths.curves import FloatArray, IntArray
from servogen.paths.geometry import ToolPath
from servogen.paths.profile import (
    MotionLimits,
    Profile,
    build_profile,
    look_ahead,
    piece_lengths,
    piece_speed_limits,
    vertex_speed_limits,
)

# More points than this (an hour and more at 0.2 ms) is a wrong unit or a feed near zero.
MOST_POINTS = 20_000_000
_MOST_ROUNDS = 40


@dataclass(frozen=True)
class TimedPath:
    """Points (h+1, p) in metres, q(0) .. q(h), one every ``sample_time_s``, read-only.

    ``piece`` (h+1,) is the piece of ``tool_path`` on which each point lies.
    """

    points: FloatArray
    sample_time_s: float
    piece: IntArray
    tool_path: ToolPath

    @property
    def duration_s(self) -> float:
        """Time from the first point to the last, in seconds."""
        return (len(self.points) - 1) * self.sample_time_s


def time_path(
    tool_path: ToolPath, limits: MotionLimits, sample_time_s: float, feed_scale: float = 1.0
) -> TimedPath:
    """Time a path for the ideal machine, from rest to rest.

    The points lie on the polyline, the first and the last on its ends. Their first differences
    stay within the velocity limit and their second differences within the acceleration limit, per
    axis and at every sample, corners included: where the local rules leave a rest (several corners
    within one sample), the place is slowed down and timed again. The duration is stretched to a
    whole number of samples.

    Raises:
        InputError: limits that contradict one another, or a path that cannot be timed in a
            reasonable number of points.
    """
    _check_limits(limits)
    length = piece_lengths(tool_path)
    piece_limit = piece_speed_limits(tool_path, limits, feed_scale)
    vertex_limit = vertex_speed_limits(tool_path, limits, piece_limit, sample_time_s)
    vertex_at = np.concatenate([[0.0], np.cumsum(length)])
    for _ in range(_MOST_ROUNDS):
        speed = look_ahead(vertex_limit, length, limits.tangential_acceleration_m_per_s2)
        profile = build_profile(speed, piece_limit, length, limits.tangential_acceleration_m_per_s2)
        distance = _sample(profile, sample_time_s)
        points, piece = _on_polyline(tool_path, vertex_at, distance)
        excess = _acceleration_excess(points, sample_time_s, limits.acceleration_m_per_s2)
        if not excess.any():
            points.setflags(write=False)
            piece.setflags(write=False)
            return TimedPath(points, sample_time_s, piece, tool_path)
        vertex_limit = _slowed(vertex_limit, speed, vertex_at, distance, excess)
    raise InputError(
        None,
        "path.tangential_acceleration_m_per_s2",
        limits.tangential_acceleration_m_per_s2,
        "accelerations small enough that every corner keeps the machine's limit",
    )


def count_steps(
    tool_path: ToolPath, limits: MotionLimits, sample_time_s: float, feed_scale: float
) -> int:
    """Number h of steps q(0) .. q(h) that ``time_path`` would make."""
    return len(time_path(tool_path, limits, sample_time_s, feed_scale).points) - 1


def find_feed_scale(
    tool_path: ToolPath, limits: MotionLimits, sample_time_s: float, points: int
) -> float:
    """The feed scale at which the timed path has exactly ``points`` steps, by bisection.

    Returns the middle of the interval of scales that give that number, so that rounding cannot
    change it.

    Raises:
        InputError: no feed scale gives the number.
    """

    def steps(scale: float) -> int:
        return count_steps(tool_path, limits, sample_time_s, scale)

    fastest = _bisect(lambda scale: steps(scale) <= points, 1e-3, 1e3)
    slowest = _bisect(lambda scale: steps(scale) < points, 1e-3, 1e3)
    middle = 0.5 * (fastest + slowest)
    if steps(middle) != points:
        raise InputError(None, "path.feed_scale", middle, f"a scale that gives {points} steps")
    return middle


def _bisect(holds: Callable[[float], bool], low: float, high: float) -> float:
    """The smallest scale at which ``holds`` becomes true, to the last bits that matter."""
    while high / low > 1.0 + 1e-10:
        middle = math.sqrt(low * high)
        if holds(middle):
            high = middle
        else:
            low = middle
    return high


def _check_limits(limits: MotionLimits) -> None:
    for name in ("tangential_acceleration_m_per_s2", "centripetal_acceleration_m_per_s2"):
        value = getattr(limits, name)
        if not 0.0 < value <= limits.acceleration_m_per_s2:
            raise InputError(
                None,
                f"path.{name}",
                value,
                f"more than 0 and at most the fast stage's {limits.acceleration_m_per_s2:g} m/s^2",
            )


def _sample(profile: Profile, sample_time_s: float) -> FloatArray:
    """Arc length at every sample; time is stretched so that the last sample is the end."""
    duration = profile.duration_s
    if not duration / sample_time_s <= MOST_POINTS:  # infinite and no number too
        raise InputError(
            None,
            "path.feed_m_per_s",
            f"such that the path takes {duration:.0f} s"
            if duration < 1e12
            else f"such that the path takes {duration:.3g} s",
            f"feeds and units that give at most {MOST_POINTS} points",
        )
    steps = max(math.ceil(duration / sample_time_s - 1e-9), 2)
    times = np.arange(steps + 1, dtype=np.float64) * (profile.duration_s / steps)
    distance = profile.distance_at(times)
    distance[-1] = profile.length_m
    return distance


def _on_polyline(
    tool_path: ToolPath, vertex_at: FloatArray, distance: FloatArray
) -> tuple[FloatArray, IntArray]:
    last = len(vertex_at) - 2
    piece = np.clip(np.searchsorted(vertex_at, distance, side="right") - 1, 0, last)
    share = np.clip((distance - vertex_at[piece]) / np.diff(vertex_at)[piece], 0.0, 1.0)
    start, end = tool_path.points[piece], tool_path.points[piece + 1]
    points = (1.0 - share)[:, None] * start + share[:, None] * end
    points[-1] = tool_path.points[-1]
    return points, piece.astype(np.int64)


def _acceleration_excess(
    points: FloatArray, sample_time_s: float, acceleration_limit: float
) -> FloatArray:
    """How many times the limit each inner sample's second difference is, 0 where it is kept."""
    padded = np.vstack([points[:1], points, points[-1:]])  # at rest before and after
    second = np.abs(np.diff(padded, 2, axis=0)).max(axis=1) / sample_time_s**2
    ratio = second / acceleration_limit
    return np.where(ratio > 1.0, ratio, 0.0)


def _slowed(
    vertex_limit: FloatArray,
    speed: FloatArray,
    vertex_at: FloatArray,
    distance: FloatArray,
    excess: FloatArray,
) -> FloatArray:
    """Lower the limit of the vertices around each sample that breaks the acceleration limit."""
    at = np.flatnonzero(excess)
    last = len(distance) - 1
    low = np.searchsorted(vertex_at, distance[np.maximum(at - 1, 0)], side="left")
    high = np.searchsorted(vertex_at, distance[np.minimum(at + 1, last)], side="right")
    alone = low == high  # no vertex within reach: slow the piece's two ends
    low, high = np.maximum(low - alone, 0), np.minimum(high + alone, len(vertex_at))
    count = high - low
    around = np.repeat(low - np.cumsum(count) + count, count) + np.arange(count.sum())
    factor = np.repeat(0.97 / np.minimum(excess[at], 2.0), count)
    slowed: FloatArray = vertex_limit.copy()
    np.minimum.at(slowed, around, factor * speed[around])
    return slowed
