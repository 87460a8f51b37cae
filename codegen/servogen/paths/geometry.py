"""The continuous tool path: one stroke of a polyline that knows its curves and its origin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from servogen.errors import InputError
from servogen.paths.curves import BoolArray, FloatArray, Line, Stroke, lengths
from servogen.paths.flatten import MOST_PIECES, Flatness, Polyline, TooFine, flatten
from servogen.paths.ordering import Run, as_given, order_strokes
from servogen.paths.settings import PathSettings

JOIN_LABEL = "joining move"
# No machine of this kind is larger: a wrong unit, or a number gone wild.
FARTHEST_M = 1000.0
SHORTEST_M = 1e-12
_FINITE = f"finite coordinates and sizes, none above {FARTHEST_M:g} m"


@dataclass(frozen=True)
class ToolPath:
    """A continuous polyline in metres, one stroke.

    ``points`` (n, p) m, p 2 or 3, are vertices within tolerance of the true curve;
    ``feed_m_per_s`` (n-1,) is the programmed feed of each piece; ``smooth`` (n,) is True where a
    vertex lies inside a curve and is no corner; ``radius_m`` (n,) is the curve's radius at the
    vertex, inf on straight pieces; ``labels`` (n-1,) says where each piece comes from ("line 12",
    "ARC #3").
    """

    points: FloatArray
    feed_m_per_s: FloatArray
    smooth: BoolArray
    radius_m: FloatArray
    labels: tuple[str, ...]


def build_tool_path(
    strokes: list[Stroke], settings: PathSettings, file: Path, *, reorder: bool
) -> ToolPath:
    """Flatten strokes, order them (``reorder``) or keep them as given, and join them into one.

    Raises:
        InputError: nothing to draw, a coordinate that is not finite, a stroke of no length.
    """
    if not strokes:
        raise InputError(file, "drawing", None, "at least one line or curve in it")
    flatness = Flatness(
        settings.tolerance_m, settings.centripetal_acceleration_m_per_s2, settings.corner_time_s
    )
    lines = [_checked_polyline(stroke, flatness, file) for stroke in strokes]
    starts = np.array([line.points[0] for line in lines])
    ends = np.array([line.points[-1] for line in lines])
    runs = (
        order_strokes(starts, ends, settings.join_tolerance_m) if reorder else as_given(len(lines))
    )
    return _assemble(strokes, lines, runs, settings)


def _checked_polyline(stroke: Stroke, flatness: Flatness, file: Path) -> Polyline:
    for segment in stroke.segments:
        if isinstance(segment, Line):
            _check_reach([segment.start, segment.end], stroke, file)
            continue
        breaks = segment.breaks
        with np.errstate(all="ignore"):
            probe = segment.sample(breaks).points
        if not np.isfinite(breaks).all():
            raise InputError(file, stroke.label, None, _FINITE)
        _check_reach(probe, stroke, file)
    try:
        line = flatten(stroke.segments, flatness)
    except TooFine as error:
        expected = f"at most {MOST_PIECES}: a larger path.tolerance_m or path.corner_time_s"
        raise InputError(file, stroke.label, f"cut into {error} pieces", expected) from error
    if not np.isfinite(line.points).all():
        raise InputError(file, stroke.label, None, _FINITE)
    if np.ptp(line.points, axis=0).max() <= SHORTEST_M:
        raise InputError(file, stroke.label, "of length zero", "a line or curve with a length")
    return line


def _check_reach(points: ArrayLike, stroke: Stroke, file: Path) -> None:
    farthest = np.abs(points).max()
    if np.isfinite(farthest) and farthest <= FARTHEST_M:
        return
    value = f"{farthest:.6g} m from the origin" if np.isfinite(farthest) else None
    raise InputError(file, stroke.label, value, _FINITE)


def _assemble(
    strokes: list[Stroke], lines: list[Polyline], runs: list[Run], settings: PathSettings
) -> ToolPath:
    """One polyline out of all, with a joining move wherever two do not meet."""
    points: list[FloatArray] = []
    smooth: list[BoolArray] = []
    radius: list[FloatArray] = []
    feed: list[FloatArray] = []
    labels: list[str] = []
    tail: FloatArray | None = None
    for run in runs:
        stroke, line = strokes[run.index], lines[run.index]
        step = -1 if run.reverse else 1
        own = line.points[::step]
        skip = 0
        if tail is not None:
            if lengths(own[:1] - tail)[0] <= settings.join_tolerance_m:
                skip = 1  # the shared vertex is there already
            else:
                feed.append(np.array([settings.traverse_feed_m_per_s]))
                labels.append(JOIN_LABEL)
        points.append(own[skip:])
        smooth.append(line.smooth[::step][skip:])
        radius.append(line.radius_m[::step][skip:])
        if skip:
            radius[-2] = radius[-2].copy()
            radius[-2][-1] = min(radius[-2][-1], line.radius_m[::step][0])
        own_feed = settings.feed_m_per_s if stroke.feed_m_per_s is None else stroke.feed_m_per_s
        feed.append(np.full(len(own) - 1, own_feed))
        labels.extend([stroke.label] * (len(own) - 1))
        tail = own[-1]
    return _without_repeats(
        np.vstack(points),
        np.concatenate(feed),
        np.concatenate(smooth),
        np.concatenate(radius),
        labels,
    )


def _without_repeats(
    points: FloatArray,
    feed: FloatArray,
    smooth: BoolArray,
    radius: FloatArray,
    labels: list[str],
) -> ToolPath:
    """Drop pieces of no length (1 pm), which joining within the tolerance can leave."""
    length = lengths(np.diff(points, axis=0))
    keep = length > SHORTEST_M
    vertex = np.concatenate([[True], keep])
    return ToolPath(
        points[vertex],
        feed[keep],
        smooth[vertex],
        radius[vertex],
        tuple(label for label, kept in zip(labels, keep.tolist(), strict=True) if kept),
    )
