"""The contour of a project in time: a curve at its feed from rest to rest, or a timed drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servogen.errors import InputError
from servogen.paths.curves import lengths
from servogen.paths.geometry import ToolPath
from servogen.paths.load import load_tool_path
from servogen.paths.profile import MotionLimits
from servogen.paths.settings import PathSettings
from servogen.paths.timing import TimedPath, time_path
from servogen.precision import FloatArray
from servogen.project.contour_load import ContourProject
from servogen.project.contour_schema import ButterflyContour, CircleContour, ContourPath
from servogen.systems.contour_motion import PIECES, ContourMotion, butterfly, traced
from servogen.systems.judgement import of_the_project

# Of a butterfly: a whole curve in turns of its parameter, and its farthest point of these units.
BUTTERFLY_TURNS, BUTTERFLY_SIZE = 12.0, 5.050376
DENSE = 60_000
# Of its fastest velocity an axis may be asked for so much by a contour: the rest is to correct by.
VELOCITY_SHARE = 0.9
# Samples that the axes are held at the end, to see them come to rest.
REST = 200
# More samples than this (eight minutes at 2 kHz) are not held in memory with all between them.
MOST_SAMPLES = 1_000_000


@dataclass(frozen=True)
class ContourTask:
    """A contour and where its errors count.

    Attributes:
        motion: ``samples`` points and as many more as any preview needs, the last one repeated.
        moving: whether it begins at its feed, the machine with it.
        first, last: samples whose errors are judged, the last one excluded: of a curve its last
            repetition at the feed, of a drawing all until it ends.
        end: sample from which on the contour stands still.
    """

    motion: ContourMotion
    samples: int
    moving: bool
    first: int
    last: int
    end: int


def contour_task(project: ContourProject, gains: Sequence[float]) -> ContourTask:
    """The project's own contour.

    Args:
        gains: m/s per unit of command, of every axis.

    Raises:
        InputError: a drawing that cannot be read or timed, a contour that leaves the axes' reach or
            asks for more velocity than they have.
    """
    match project.contour:
        case ContourPath():
            task = _drawn(project, project.contour, gains)
        case CircleContour() | ButterflyContour():
            task = _curve(project, project.contour)
    _check_reach(project, task)
    _check_velocity(project, task, gains)
    return task


def at_feed_only(project: ContourProject, task: ContourTask, lead: int) -> ContourTask:
    """The project's curve without start and end, the machine already moving, as the paper's table
    has it: ``lead`` samples, then one repetition that counts. A drawing is as it was."""
    if isinstance(project.contour, ContourPath):
        return task
    curve = project.contour
    turn = _turn_samples(project, curve)
    fine = _fine(project, curve, np.arange((lead + turn + REST) * PIECES) * _step(project, curve))
    motion = _measured(curve, fine)
    return ContourTask(motion, lead + turn, True, lead, lead + turn, lead + turn)


def _step(project: ContourProject, curve: CircleContour | ButterflyContour) -> float:
    """Metres from one fine point to the next at the feed."""
    return curve.feed_m_per_s * project.sampling.sample_time_s / PIECES


def _turn_samples(project: ContourProject, curve: CircleContour | ButterflyContour) -> int:
    return round(_length(curve) / (curve.feed_m_per_s * project.sampling.sample_time_s))


def _length(curve: CircleContour | ButterflyContour) -> float:
    if isinstance(curve, CircleContour):
        return float(np.hypot(2.0 * np.pi * curve.radius_m, curve.rise_m))
    return float(_butterfly_length(curve)[1][-1])


def _butterfly_length(curve: ButterflyContour) -> tuple[FloatArray, FloatArray]:
    """(DENSE, 2) points of the whole curve, m, and the way to each of them."""
    turns = np.linspace(0.0, BUTTERFLY_TURNS, DENSE)
    dense = curve.size_m / BUTTERFLY_SIZE * butterfly(turns)
    ways = np.linalg.norm(np.diff(dense, axis=0), axis=1)
    return dense, np.concatenate([[0.0], np.cumsum(ways)])


def _fine(
    project: ContourProject, curve: CircleContour | ButterflyContour, along: FloatArray
) -> FloatArray:
    """(J, p) points of the curve so many metres (J,) from its beginning."""
    if isinstance(curve, CircleContour):
        turn = along / _length(curve)
        angle = 2.0 * np.pi * turn
        flat = curve.radius_m * np.column_stack([np.cos(angle), np.sin(angle)])
        height = curve.rise_m * turn
    else:
        dense, ways = _butterfly_length(curve)
        place = np.mod(along, ways[-1])
        flat = np.column_stack([np.interp(place, ways, column) for column in dense.T])
        height = np.zeros(len(along))
    axes = len(project.axes)
    return np.column_stack([flat, height])[:, :axes]


def _measured(curve: CircleContour | ButterflyContour, fine: FloatArray) -> ContourMotion:
    """With distances to the circle itself where it is one in the plane."""
    motion = traced(fine)
    if isinstance(curve, ButterflyContour) or fine.shape[1] > 2:
        return motion
    radius = curve.radius_m

    def distance(positions: FloatArray, first: int) -> FloatArray:
        result: FloatArray = np.abs(np.hypot(positions[:, 0], positions[:, 1]) - radius)
        return result

    return ContourMotion(motion.points, distance)


def _curve(project: ContourProject, curve: CircleContour | ButterflyContour) -> ContourTask:
    """From rest to the feed in a ramp, the repetitions, back to rest where they end."""
    period, feed = project.sampling.sample_time_s, curve.feed_m_per_s
    length = _length(curve) * curve.repetitions
    ramp = min(curve.ramp_s, length / feed)
    total = length / feed + ramp
    if total / period > MOST_SAMPLES:
        raise project.error(
            "contour.feed_m_per_s", feed, f"a feed that ends within {MOST_SAMPLES:,} samples"
        )
    end = int(np.ceil(total / period))
    time = np.arange((end + 2 * REST) * PIECES) * (period / PIECES)
    motion = _measured(curve, _fine(project, curve, _along(time, total, ramp, feed, length)))
    turn = _turn_samples(project, curve)
    last = int((total - ramp) / period)
    first = max(int(np.ceil(ramp / period)), last - turn)
    return ContourTask(motion, end + REST, False, min(first, last - 1), last, end)


def _along(time: FloatArray, total: float, ramp: float, feed: float, length: float) -> FloatArray:
    """Metres along the curve: the velocity rises and falls in a straight line."""
    half = 0.5 * feed / ramp if ramp > 0.0 else 0.0
    begun, left = np.clip(time, 0.0, total), np.clip(total - time, 0.0, total)
    cruise = feed * (begun - 0.5 * ramp)
    result: FloatArray = np.where(begun < ramp, half * begun**2, cruise)
    return np.where(left < ramp, length - half * left**2, np.minimum(result, length))


def _drawn(project: ContourProject, path: ContourPath, gains: Sequence[float]) -> ContourTask:
    """Timed, with the drawing's own points between those of two samples to measure distances to."""
    fastest = tuple(
        VELOCITY_SHARE * gain * table.command_limit
        for gain, (_, table) in zip(gains, project.axes, strict=True)
    )
    settings = PathSettings(
        tolerance_m=path.tolerance_m,
        feed_m_per_s=path.feed_m_per_s,
        feed_scale=path.feed_scale,
        join_tolerance_m=path.join_tolerance_m,
        tangential_acceleration_m_per_s2=path.tangential_acceleration_m_per_s2,
        centripetal_acceleration_m_per_s2=path.centripetal_acceleration_m_per_s2,
        corner_time_s=path.corner_time_s,
        traverse_feed_m_per_s=path.traverse_feed_m_per_s,
        layer_feeds_m_per_s=dict(path.layer_feeds_m_per_s),
    )
    motion_limits = MotionLimits(
        velocity_m_per_s=fastest,
        acceleration_m_per_s2=path.acceleration_limit_m_per_s2,
        tangential_acceleration_m_per_s2=path.tangential_acceleration_m_per_s2,
        centripetal_acceleration_m_per_s2=path.centripetal_acceleration_m_per_s2,
        corner_time_s=path.corner_time_s,
    )
    period = project.sampling.sample_time_s
    with of_the_project(project):
        tool_path = load_tool_path(settings, path.file, len(project.axes))
        _check_places(project, path, tool_path)
        timed = time_path(tool_path, motion_limits, period, path.feed_scale)
    end = len(timed.points) - 1
    if end > MOST_SAMPLES:
        raise project.error(
            "path.feed_m_per_s",
            path.feed_m_per_s,
            f"a feed that ends within {MOST_SAMPLES:,} samples",
        )
    fine = _between(timed)
    rest = np.repeat(fine[-1:], (end + 2 * REST) * PIECES - len(fine), axis=0)
    motion = traced(np.vstack([fine, rest]))
    return ContourTask(motion, end + REST, False, 0, end, end)


def _check_places(project: ContourProject, path: ContourPath, drawn: ToolPath) -> None:
    """Before it is timed: a drawing in the wrong unit is not a matter of its feed."""
    for a, (name, table) in enumerate(project.axes):
        beyond = np.flatnonzero(np.abs(drawn.points[:, a]) > table.position_limit_m)
        if beyond.size:
            at = int(beyond[0])
            limit = f"|{name}| of at most machine.{name}.position_limit_m"
            csv = "; a CSV file is in metres" if path.file.suffix.lower() == ".csv" else ""
            raise InputError(
                path.file,
                drawn.labels[max(at - 1, 0)],
                f"at {name} = {drawn.points[at, a]:.6g} m",
                f"{limit} = {table.position_limit_m!r}{csv}",
            )


def _between(timed: TimedPath) -> FloatArray:
    """(PIECES (K - 1) + 1, p) points on the drawing, every tenth a timed one (K, p)."""
    corners = np.asarray(timed.tool_path.points, dtype=np.float64)
    ways = np.concatenate([[0.0], np.cumsum(lengths(np.diff(corners, axis=0)))])
    places = ways[timed.piece] + np.linalg.norm(timed.points - corners[timed.piece], axis=1)
    count = len(timed.points)
    at = np.interp(np.arange(PIECES * (count - 1) + 1) / PIECES, np.arange(count), places)
    fine = np.column_stack([np.interp(at, ways, column) for column in corners.T])
    fine[::PIECES] = timed.points
    return fine


def _check_reach(project: ContourProject, task: ContourTask) -> None:
    for a, (name, table) in enumerate(project.axes):
        farthest = float(np.max(np.abs(task.motion.points[:, a])))
        if farthest > table.position_limit_m:
            raise project.fault(
                f"machine.{name}.position_limit_m",
                table.position_limit_m,
                f"at least {farthest:.6g} m, where the contour goes",
            )


def _check_velocity(project: ContourProject, task: ContourTask, gains: Sequence[float]) -> None:
    step = np.max(np.abs(np.diff(task.motion.points, axis=0)), axis=0)
    for a, (name, table) in enumerate(project.axes):
        asked = float(step[a]) / project.sampling.sample_time_s
        has = VELOCITY_SHARE * gains[a] * table.command_limit
        if asked > has:
            raise InputError(
                project.file,
                f"{'path' if isinstance(project.contour, ContourPath) else 'contour'}.feed_m_per_s",
                repr(project.contour.feed_m_per_s),
                f"at most {has:.4g} m/s along {name}, {VELOCITY_SHARE:.0%} of what "
                f"machine.{name}.command_limit = {table.command_limit!r} gives",
            )
