"""What a project file says about its path, typed and in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class PathSettings:
    """The ``[path]`` table of a project file, without the file name.

    ``feed_m_per_s`` is used wherever the drawing gives no feed; ``layer_feeds_m_per_s`` maps a
    layer name (compared without regard to case) to its feed. ``corner_time_s`` is the time within
    which the tool may change its velocity vector at a corner; it also sets how finely curves are
    divided, so that one division turns the velocity by less than the machine can in that time.
    """

    tolerance_m: float = 5e-6
    feed_m_per_s: float = 0.3
    feed_scale: float = 1.0
    join_tolerance_m: float = 1e-5
    tangential_acceleration_m_per_s2: float = 24.5
    centripetal_acceleration_m_per_s2: float = 34.3
    corner_time_s: float = 2e-4
    traverse_feed_m_per_s: float = 0.6
    layer_feeds_m_per_s: Mapping[str, float] = field(default_factory=dict)
