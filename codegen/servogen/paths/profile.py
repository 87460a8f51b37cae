"""The fastest speed profile along a polyline that keeps the limits of an ideal machine.

Classic look-ahead: a speed limit at every vertex (feed, curve, corner), a backward and a forward
pass with the tangential acceleration, then accelerate - cruise - brake on every piece.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from servogen.paths.curves import FloatArray, lengths
from servogen.paths.geometry import ToolPath

# Share of the acceleration limit that corners may use: rounding and the curve beside a corner
# need the rest.
CORNER_SHARE = 0.98


@dataclass(frozen=True)
class MotionLimits:
    """Limits of the ideal machine, per axis, and how a path uses them (SI units).

    ``velocity_m_per_s`` is one number for all axes, or one for each.
    """

    velocity_m_per_s: float | tuple[float, ...]
    acceleration_m_per_s2: float
    tangential_acceleration_m_per_s2: float
    centripetal_acceleration_m_per_s2: float
    corner_time_s: float


@dataclass(frozen=True)
class Profile:
    """Phases of constant tangential acceleration; arrays (k,) with phase starts, and the total."""

    time_s: FloatArray
    distance_m: FloatArray
    speed_m_per_s: FloatArray
    acceleration_m_per_s2: FloatArray
    duration_s: float
    length_m: float

    def distance_at(self, times: FloatArray) -> FloatArray:
        """Arc length travelled at given instants (s), in metres."""
        phase = np.clip(np.searchsorted(self.time_s, times, side="right") - 1, 0, None)
        since = times - self.time_s[phase]
        travelled = since * (
            self.speed_m_per_s[phase] + 0.5 * self.acceleration_m_per_s2[phase] * since
        )
        distance: FloatArray = np.minimum(self.distance_m[phase] + travelled, self.length_m)
        return distance


def piece_lengths(path: ToolPath) -> FloatArray:
    """Length of each piece (n-1,) in metres."""
    return lengths(np.diff(path.points, axis=0))


def piece_speed_limits(path: ToolPath, limits: MotionLimits, feed_scale: float) -> FloatArray:
    """Feed of each piece (n-1,), no faster than any axis may move, in m/s."""
    direction = np.abs(np.diff(path.points, axis=0)) / piece_lengths(path)[:, None]
    with np.errstate(divide="ignore"):  # an axis that does not move does not limit
        machine = np.min(np.array(limits.velocity_m_per_s) / direction, axis=1)
    speeds: FloatArray = np.minimum(feed_scale * path.feed_m_per_s, machine)
    return speeds


def vertex_speed_limits(
    path: ToolPath, limits: MotionLimits, piece_limit: FloatArray, sample_time_s: float
) -> FloatArray:
    """Speed limit at each vertex (n,) in m/s: feed on both sides, curve radius, corner.

    A corner changes the velocity vector at once. Its second difference at T_f is that change over
    T_f plus, by symmetry, half the tangential acceleration times the change of direction; the sum
    must stay within the machine's acceleration.
    """
    length = piece_lengths(path)
    limit = np.full(len(path.points), np.inf)
    limit[:-1] = piece_limit
    limit[1:] = np.minimum(limit[1:], piece_limit)
    limit = np.minimum(limit, np.sqrt(limits.centripetal_acceleration_m_per_s2 * path.radius_m))
    direction = np.diff(path.points, axis=0) / length[:, None]
    turn = np.maximum(lengths(np.diff(direction, axis=0)), 1e-12)
    corner_time = min(limits.corner_time_s, sample_time_s)
    room = CORNER_SHARE * limits.acceleration_m_per_s2
    room_left = np.maximum(room - 0.5 * limits.tangential_acceleration_m_per_s2 * turn, 0.1 * room)
    corner = corner_time * room_left / turn
    # Corners closer together than one sample act as a curve.
    spacing = 0.5 * (length[1:] + length[:-1])
    dense = (corner * sample_time_s > spacing) & ~path.smooth[1:-1]
    curve = np.sqrt(limits.centripetal_acceleration_m_per_s2 * spacing / turn)
    limit[1:-1] = np.minimum(limit[1:-1], np.where(dense, np.minimum(curve, corner), corner))
    limit[0] = limit[-1] = 0.0
    speeds: FloatArray = limit
    return speeds


def look_ahead(limit: FloatArray, length: FloatArray, acceleration: float) -> FloatArray:
    """The highest vertex speeds (n,) under ``limit`` that the acceleration can link."""
    square: list[float] = (limit**2).tolist()
    gain: list[float] = (2.0 * acceleration * length).tolist()
    for i in range(len(gain) - 1, -1, -1):
        reachable = square[i + 1] + gain[i]
        if square[i] > reachable:
            square[i] = reachable
    for i, step in enumerate(gain):
        reachable = square[i] + step
        if square[i + 1] > reachable:
            square[i + 1] = reachable
    speed: FloatArray = np.sqrt(np.array(square))
    return speed


def build_profile(
    speed: FloatArray, piece_limit: FloatArray, length: FloatArray, acceleration: float
) -> Profile:
    """Accelerate to the piece's limit, cruise, brake: three phases for each piece."""
    before, after = speed[:-1], speed[1:]
    peak2 = np.minimum(
        np.maximum(piece_limit**2, np.maximum(before**2, after**2)),
        0.5 * (before**2 + after**2) + acceleration * length,
    )
    peak = np.sqrt(np.maximum(peak2, np.maximum(before**2, after**2)))
    rise = (peak**2 - before**2) / (2.0 * acceleration)
    fall = (peak**2 - after**2) / (2.0 * acceleration)
    level = np.maximum(length - rise - fall, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        # a feed so small that its square is zero takes for ever: told when the profile is sampled
        durations = np.column_stack(
            [(peak - before) / acceleration, level / peak, (peak - after) / acceleration]
        ).ravel()
    distances = np.column_stack([rise, level, fall]).ravel()
    ends = np.cumsum(durations)
    return Profile(
        time_s=np.concatenate([[0.0], ends[:-1]]),
        distance_m=np.concatenate([[0.0], np.cumsum(distances)[:-1]]),
        speed_m_per_s=np.column_stack([before, peak, peak]).ravel(),
        acceleration_m_per_s2=np.tile([acceleration, 0.0, -acceleration], len(length)),
        duration_s=float(ends[-1]),
        length_m=math.fsum(length.tolist()),
    )
