"""What a command governor's project is refused for once its parts are built, each with its keys."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_program import SETTLING
from servogen.controllers.errors import DesignError
from servogen.errors import InputError
from servogen.paths.places import describe_point
from servogen.plants.statespace import StateSpace
from servogen.project.governor_load import GovernorProject
from servogen.project.schema import MAX_ITERATIONS
from servogen.sets.errors import SetError
from servogen.systems.command_governor_loop import drawing_fault

if TYPE_CHECKING:
    from servogen.controllers.command_governor_design import (
        AxisGovernorDesign,
        CommandGovernorDesign,
    )
    from servogen.systems.command_governor import GovernorMachine

_KEYS = {
    "tightening": "controller.governor.steady_state_tightening",
    "sub_samples": "controller.governor.sub_samples",
    "stroke_margin_m": "controller.governor.stroke_margin_m",
    "horizon": "controller.governor.horizon",
    "position_m": "machine.{axis}.slow.position_limit_m",
    "velocity_m_per_s": "machine.{axis}.slow.velocity_limit_m_per_s",
    "acceleration_m_per_s2": "machine.{axis}.slow.acceleration_limit_m_per_s2",
    "fast_range_m": "machine.{axis}.fast.range_m",
}
# An axis that is longer than this is more likely one in millimetres, m.
LONG_M = 10.0
# Three equal poles leave less than a millionth of a step after so many of their time constants.
AT_REST = 20.0


def part_fault(
    project: GovernorProject, axis: str, slow: StateSpace, error: SetError | DesignError
) -> InputError:
    """A set or a program that cannot be made, told by the key that is to blame."""
    if error.key == "constraints":  # a linear program without an answer
        limit, value, moved = _tighter_limit(project, axis)
        told = f"a limit with which a plan moves the stage, not {moved}"
        return project.error(limit, value, told)
    if error.key in ("tightening", "horizon") and _is_slow(project, slow):
        return project.error(*_pole(project, axis, slow), _faster(project))
    if error.key not in _KEYS:
        return project.error(*_pole(project, axis, slow), f"a stage with {error.expected}")
    return InputError(project.file, _KEYS[error.key].format(axis=axis), error.value, error.expected)


def check_pace(project: GovernorProject, design: CommandGovernorDesign) -> None:
    """A stage that stands short of its reference gets a plan that is told from standing.

    Where the next point is out of reach of a stage at rest, its reference is the reserve away or
    more: that is what is asked of the program here, in the middle of the axis. With limits so small
    that the best plan moves less than what counts as standing, a tool that only waits would be told
    from one that waits for ever by nothing.

    Raises:
        InputError: the limit that is too small for that.
    """
    for axis, own in zip("xy", design.axes, strict=True):
        moved, least = _first_move_m(project, own), own.standing_m
        if moved > least:
            continue
        key, value, _ = _tighter_limit(project, axis)
        weight = project.controller.governor.weight_reference
        expected = (
            f"a limit with which a plan moves a resting stage by more than {least:.3g} m towards a "
            f"reference that is controller.motion.stroke_reserve_m away, not {moved:.1g} m; a "
            f"larger controller.governor.weight_reference than {weight!r} helps too"
        )
        raise project.error(key, value, expected)


def _first_move_m(project: GovernorProject, own: AxisGovernorDesign) -> float:
    """How far the first plan goes, m, with as many iterations as it takes."""
    governor = AxisGovernor(replace(own, solver=replace(own.solver, cap=MAX_ITERATIONS)))
    centre = np.asarray(own.program.centre_m, dtype=own.precision.dtype)
    governor.reset(float(centre))
    state = np.zeros(own.plant.order, dtype=own.precision.dtype)
    state[0] = centre
    away = project.controller.motion.stroke_reserve_m - _lacking_m(own)
    far = np.full(own.intervals, own.farthest * own.program.scale_m, dtype=own.precision.dtype)
    reference = np.full(own.program.variables, centre + away, dtype=own.precision.dtype)
    governor.step(state, reference, -far, far)
    return float(np.max(np.abs(governor.plan - centre)))


def check_settling(project: GovernorProject, design: CommandGovernorDesign) -> None:
    """The motion's reserve is more than a stage that has stopped may lack, by more than what counts
    as standing: one that is short of the next point then has a plan that is told from standing.

    Raises:
        InputError: it is not.
    """
    reserve = project.controller.motion.stroke_reserve_m
    needed = max(_lacking_m(own) + own.standing_m for own in design.axes)
    if reserve <= needed:
        tightening = project.controller.governor.steady_state_tightening
        raise project.error(
            "controller.motion.stroke_reserve_m",
            reserve,
            f"more than {needed:.3g} m, what a stage may still have before it when a plan ends "
            f"with controller.governor.steady_state_tightening = {tightening!r}, and what counts "
            "as standing",
        )


def _lacking_m(own: AxisGovernorDesign) -> float:
    """What a stage at the end of its plan may lack of a place that the plan reaches, m."""
    return own.program.settle_m + own.tol.margin * own.program.scale_m


def check_path(machine: GovernorMachine, design: CommandGovernorDesign) -> None:
    """The governor finishes the drawing.

    Raises:
        InputError: the first point at which it might not, of the drawing's file.
    """
    project = machine.project
    reserve = project.controller.motion.stroke_reserve_m
    fault = drawing_fault(design, machine.points, machine.reference, reserve)
    if fault is None:
        return
    place = describe_point(machine.timed, fault.point)
    if Path(project.path.file).suffix.lower() == ".svg":
        place += " (y upwards, an SVG's own is -y)"
    told = "out of reach, so that the tool might wait for ever"
    expected = f"{fault.expected}, by {' and '.join(fault.keys)}{_long(machine)}"
    raise InputError(project.path.file, place, told, expected)


def long_axes(project: GovernorProject) -> list[str]:
    """A sentence for each axis that is so long that it may be in millimetres."""
    found = []
    for name, axis in project.machine.axes:
        low, high = axis.slow.position_limit_m
        if high - low > LONG_M and not (name == "y" and axis == project.machine.x):
            key = f"machine.{name}.slow.position_limit_m"
            found.append(f"{key} spans {high - low:g} m: lengths are in metres")
    return found


def _long(machine: GovernorMachine) -> str:
    """A hint where something is metres long."""
    size = float(np.max(np.ptp(machine.points, axis=0)))
    drawing = [f"the drawing spans {size:.4g} m: lengths are in metres"] if size > LONG_M else []
    hints = [*long_axes(machine.project), *drawing]
    return f" ({'; '.join(hints)})" if hints else ""


def _pole(project: GovernorProject, axis: str, slow: StateSpace) -> tuple[str, object]:
    """Key and value of what makes a stage as quick as it is."""
    own = project.machine.x.slow if axis == "x" else project.machine.y.slow
    if own.model == "equal_poles":
        return f"machine.{axis}.slow.pole_rad_per_s", own.pole_rad_per_s
    return f"machine.{axis}.slow", f"with a pole at {np.max(slow.poles.real):.4g} rad/s"


def _seen_s(project: GovernorProject) -> float:
    """How long after its last command a stage is looked at, s."""
    instant = project.sampling.slow_sample_time_s / project.controller.governor.sub_samples
    return SETTLING * instant


def _is_slow(project: GovernorProject, slow: StateSpace) -> bool:
    return -float(np.max(slow.poles.real)) * _seen_s(project) < AT_REST


def _faster(project: GovernorProject) -> str:
    return (
        f"a stage that is at rest {_seen_s(project):.3g} s after its last command: a faster one, "
        f"a longer sampling.slow_sample_time_s than {project.sampling.slow_sample_time_s!r}, or "
        "fewer controller.governor.sub_samples"
    )


def _tighter_limit(project: GovernorProject, axis: str) -> tuple[str, float, str]:
    """Of velocity and acceleration the one that holds a plan back: key, value, and how far it would
    go by that alone."""
    own = project.machine.x.slow if axis == "x" else project.machine.y.slow
    governor, period = project.controller.governor, project.sampling.slow_sample_time_s
    time = (governor.horizon + 1) * period
    moves = (
        ("velocity_limit_m_per_s", own.velocity_limit_m_per_s * time),
        ("acceleration_limit_m_per_s2", 0.25 * own.acceleration_limit_m_per_s2 * time**2),
    )
    key, moved = min(moves, key=lambda move: move[1])
    return f"machine.{axis}.slow.{key}", getattr(own, key), f"by some {moved:.1g} m in its horizon"
