"""Small drawings for the tests, and what is measured on paths."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
from numpy.typing import NDArray

from servogen.paths.curves import Segment, Stroke
from servogen.paths.profile import MotionLimits
from servogen.paths.settings import PathSettings
from servogen.paths.timing import TimedPath

FloatArray = NDArray[np.float64]
SETTINGS = PathSettings()
LIMITS = MotionLimits(
    velocity_m_per_s=0.6,
    acceleration_m_per_s2=49.05,
    tangential_acceleration_m_per_s2=24.5,
    centripetal_acceleration_m_per_s2=34.3,
    corner_time_s=2e-4,
)
PERIOD_S = 2e-4
SVG = '<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>'
MM = 'width="100mm" height="100mm" viewBox="0 0 100 100"'


def dxf_file(folder: Path, draw: Callable[[Any], None], units: int = 4) -> Path:
    """A DXF drawing: ``draw`` gets the document (its model space is ``document.modelspace()``)."""
    document = ezdxf.new("R2000", units=units)
    draw(document)
    file = folder / "drawing.dxf"
    document.saveas(file)
    return file


def svg_file(folder: Path, body: str, head: str = MM) -> Path:
    """An SVG drawing, in millimetres without another head."""
    return text_file(folder, "drawing.svg", SVG.format(head=head, body=body))


def text_file(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def dense(segment: Segment, count: int = 4001) -> FloatArray:
    """Points (count, 2) along a segment, in metres."""
    breaks = segment.breaks
    return segment.sample(np.linspace(breaks[0], breaks[-1], count)).points


def ends(stroke: Stroke) -> FloatArray:
    """First and last point (2, 2) of a stroke."""
    first, last = stroke.segments[0], stroke.segments[-1]
    begin = first.sample(first.breaks[:1]).points
    return np.vstack([begin, last.sample(last.breaks[-1:]).points])


def middle(segment: Segment) -> FloatArray:
    """The point (2,) half way by the parameter."""
    breaks = segment.breaks
    return segment.sample(np.array([0.5 * (breaks[0] + breaks[-1])])).points[0]


def distance_from_polyline(points: FloatArray, vertices: FloatArray) -> FloatArray:
    """Distance (n,) of points from the nearest piece of a polyline."""
    best = np.full(len(points), np.inf)
    for start, end in pairwise(vertices):
        chord = end - start
        along = np.clip((points - start) @ chord / max(chord @ chord, 1e-300), 0.0, 1.0)
        gap = points - start - along[:, None] * chord
        best = np.minimum(best, np.linalg.norm(gap, axis=1))
    return best


def peak_velocity(timed: TimedPath) -> float:
    """The largest first difference of an axis, in m/s."""
    return float(np.abs(np.diff(timed.points, axis=0)).max() / timed.sample_time_s)


def peak_acceleration(timed: TimedPath) -> float:
    """The largest second difference of an axis, from rest to rest, in m/s^2."""
    padded = np.vstack([timed.points[:1], timed.points, timed.points[-1:]])
    return float(np.abs(np.diff(padded, 2, axis=0)).max() / timed.sample_time_s**2)
