"""Faults of a project that show only when its plants, sets and path are built.

Each function builds a part and raises an InputError that names the key or the place at fault, so
whoever needs the part gets it from here, judged.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from servogen.errors import InputError
from servogen.paths.load import load_tool_path
from servogen.paths.places import describe_point
from servogen.paths.timing import TimedPath, time_path
from servogen.plants.build import fast_plant, slow_plant
from servogen.plants.errors import PlantError
from servogen.plants.statespace import FloatArray, StateSpace
from servogen.project.load import Project
from servogen.project.machine import Axis
from servogen.project.settings import (
    PathProject,
    axis_limits,
    motion_limits,
    path_settings,
    stage_settings,
)
from servogen.sets.admissible import AdmissibleSet, maximal_admissible_set
from servogen.sets.errors import SetError

# How far inside its set, in shares of the limits, a pair counts as an interior one: what the
# linear programs that made the set resolve.
INTERIOR_MARGIN = 1e-9
_CHUNK = 200_000  # points judged at a time, so that a long path needs no gigabytes

_SET_KEYS = {
    "steady_state_tightening": "controller.governor.steady_state_tightening",
    "inter_sample_rows": "controller.governor.inter_sample_rows",
    "position_m": "machine.{axis}.slow.position_limit_m",
    "velocity_m_per_s": "machine.{axis}.slow.velocity_limit_m_per_s",
    "acceleration_m_per_s2": "machine.{axis}.slow.acceleration_limit_m_per_s2",
    "fast_range_m": "machine.{axis}.fast.range_m",
}


@dataclass(frozen=True)
class AxisPlants:
    """Both stages of one axis, continuous, states p, v, a, ..., unit dc gain."""

    slow: StateSpace
    fast: StateSpace


@dataclass(frozen=True)
class Plants:
    """Both axes."""

    x: AxisPlants
    y: AxisPlants


@dataclass(frozen=True)
class Sets:
    """O-infinity (Result 1) of both axes, with the governor's tightening and inter-sample rows."""

    x: AdmissibleSet
    y: AdmissibleSet


def check_plants(project: Project) -> Plants:
    """Build the stages.

    Raises:
        InputError: a stage that is unstable, of a dc gain other than one, of relative degree
            below three, not readable, or a fast stage that is no faster than its slow one.
    """
    x = _axis_plants(project, "x", project.machine.x)
    same = project.machine.y == project.machine.x
    return Plants(x, x if same else _axis_plants(project, "y", project.machine.y))


def check_sets(project: Project, plants: Plants) -> Sets:
    """Compute O-infinity of both axes.

    Raises:
        InputError: limits or a tightening for which there is none.
    """
    x = _axis_set(project, "x", project.machine.x, plants.x)
    same = plants.y is plants.x and project.machine.y == project.machine.x
    return Sets(x, x if same else _axis_set(project, "y", project.machine.y, plants.y))


def timed_path(project: PathProject) -> TimedPath:
    """Read the drawing and time it for the ideal machine; see ``paths``.

    Raises:
        InputError: the drawing cannot be read, or the path cannot be timed.
    """
    with of_the_project(project):
        tool_path = load_tool_path(path_settings(project), project.path.file)
        limits, period = motion_limits(project), project.sampling.fast_sample_time_s
        return time_path(tool_path, limits, period, project.path.feed_scale)


def check_path(project: Project, timed: TimedPath, sets: Sets) -> None:
    """Judge a path against the machine: its workspace and Theorem 1's hypothesis.

    The theorem needs (x_e(q(h)), q(h+1)) in the interior of O-infinity for every h, where
    x_e(q) = (q, 0, 0, ...) is rest at q.

    Raises:
        InputError: naming the first point at fault by index, coordinates and entity.
    """
    for column, (name, axis) in enumerate(project.machine.axes):
        admissible = sets.x if name == "x" else sets.y
        along = timed.points[:, column]
        _check_workspace(project, timed, name, axis, along)
        _check_theorem_1(project, timed, name, admissible, along)


class HasFile(Protocol):
    """Any project."""

    @property
    def file(self) -> Path: ...


@contextmanager
def of_the_project(project: HasFile) -> Iterator[None]:
    """Give an error that names a key but no file the project's file."""
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        raise InputError(project.file, error.key, error.value, error.expected) from error


def _axis_plants(project: Project, name: str, axis: Axis) -> AxisPlants:
    key = f"machine.{name}.slow"
    try:
        slow = slow_plant(stage_settings(axis.slow))
        key = f"machine.{name}.fast"
        fast = fast_plant(stage_settings(axis.fast))
    except PlantError as error:
        value = None if error.value is None else str(error.value)
        raise InputError(project.file, f"{key}.{error.key}", value, error.expected) from error
    if not fast.bandwidth_3db > slow.bandwidth_3db:
        bandwidth = f"of a bandwidth of {fast.bandwidth_3db:.4g} rad/s"
        expected = f"a stage faster than the slow one's {slow.bandwidth_3db:.4g} rad/s"
        raise InputError(project.file, key, bandwidth, expected)
    return AxisPlants(slow, fast)


def _axis_set(project: Project, name: str, axis: Axis, plants: AxisPlants) -> AdmissibleSet:
    governor = project.controller.governor
    try:
        return maximal_admissible_set(
            plants.slow,
            project.sampling.slow_sample_time_s,
            axis_limits(axis),
            governor.steady_state_tightening,
            governor.inter_sample_rows,
        )
    except SetError as error:
        key = _SET_KEYS.get(error.key, "machine.{axis}.slow").format(axis=name)
        raise InputError(project.file, key, error.value, error.expected) from error


def _check_workspace(
    project: Project, timed: TimedPath, name: str, axis: Axis, along: FloatArray
) -> None:
    tightening = project.controller.governor.steady_state_tightening
    reach = (1.0 - tightening) * axis.slow.position_limit_m
    outside = np.flatnonzero(np.abs(along) >= (1.0 - INTERIOR_MARGIN) * reach)
    if outside.size == 0:
        return
    index = int(outside[0])
    expected = (
        f"|{name}| below {reach:.6g} m, machine.{name}.slow.position_limit_m less "
        "controller.governor.steady_state_tightening of it"
    )
    raise InputError(
        project.path.file, describe_point(timed, index), "outside the workspace", expected
    )


def _check_theorem_1(
    project: Project, timed: TimedPath, name: str, admissible: AdmissibleSet, along: FloatArray
) -> None:
    h_x, h_r, k = admissible.pairs()
    for start in range(0, len(along) - 1, _CHUNK):
        stop = min(start + _CHUNK, len(along) - 1)
        rest, command = along[start:stop], along[start + 1 : stop + 1]
        share = np.abs(np.outer(rest, h_x[:, 0]) + np.outer(command, h_r)) / k
        beyond = np.flatnonzero(share.max(axis=1) >= 1.0 - INTERIOR_MARGIN)
        if beyond.size:
            index = int(beyond[0])
            step_mm = 1e3 * abs(float(command[index] - rest[index]))
            row = admissible.sources[int(np.argmax(share[index]))]
            raise InputError(
                project.path.file,
                describe_point(timed, start + index),
                f"{step_mm:.4g} mm along {name} from the next one",
                "a step from rest that stays in the interior of the admissible set, as Theorem 1 "
                f"asks ({row}): a lower feed or wider limits",
            )


@dataclass(frozen=True)
class Parts:
    """A project's plants, sets and timed path, all judged."""

    plants: Plants
    sets: Sets
    timed: TimedPath


def check_project(project: Project) -> Parts:
    """Build and judge all parts; the whole of what can be wrong with an input.

    Raises:
        InputError: see the parts.
    """
    plants = check_plants(project)
    sets = check_sets(project, plants)
    timed = timed_path(project)
    check_path(project, timed, sets)
    return Parts(plants, sets, timed)
