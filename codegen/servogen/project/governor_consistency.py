"""Relations between the keys of a command governor's file that its numbers alone can break."""

from __future__ import annotations

from typing import TYPE_CHECKING

from servogen.project.consistency import check_margin, check_model, check_path, check_sampling
from servogen.project.governor_machine import GovernedAxis
from servogen.project.governor_schema import MOST_WINDOW
from servogen.project.limits import as_written

if TYPE_CHECKING:
    from servogen.project.governor_load import GovernorProject


def check_governor(project: GovernorProject) -> None:
    """Raise an InputError for the first contradiction between keys of the file."""
    for name, axis in project.machine.axes:
        if name == "y" and axis is project.machine.x:
            continue
        _check_axis(project, f"machine.{name}", axis)
    check_sampling(project, project.sampling)
    _check_periods(project)
    _check_stroke(project)
    check_margin(project, project.output.precision, project.controller.solver.constraint_margin)
    check_path(project, project.path, [(name, axis.fast) for name, axis in project.machine.axes])


def _check_axis(project: GovernorProject, key: str, axis: GovernedAxis) -> None:
    low, high = axis.slow.position_limit_m
    if axis.fast.range_m >= 0.5 * (high - low):
        raise project.error(
            f"{key}.fast.range_m",
            axis.fast.range_m,
            "less than half of what slow.position_limit_m = "
            f"{as_written((low, high))!r} leaves the slow stage, {0.5 * (high - low):g} m",
        )
    if axis.fast.acceleration_limit_m_per_s2 < axis.slow.acceleration_limit_m_per_s2:
        raise project.error(
            f"{key}.fast.acceleration_limit_m_per_s2",
            axis.fast.acceleration_limit_m_per_s2,
            "at least the slow stage's acceleration_limit_m_per_s2 = "
            f"{axis.slow.acceleration_limit_m_per_s2!r}",
        )
    check_model(project, f"{key}.slow", axis.slow)


def _check_periods(project: GovernorProject) -> None:
    ratio, governor = project.sampling.ratio, project.controller.governor
    if governor.sub_samples > ratio:
        raise project.error(
            "controller.governor.sub_samples",
            governor.sub_samples,
            f"at most the {ratio} fast samples of a slow period",
        )
    if governor.points_ahead != "all":
        if governor.points_ahead <= ratio:
            raise project.error(
                "controller.governor.points_ahead",
                governor.points_ahead,
                f"more than the {ratio} points that a slow period can take",
            )
        return
    window = (governor.horizon + 1) * ratio + 1
    if window > MOST_WINDOW:
        raise project.error(
            "controller.governor.horizon",
            governor.horizon,
            f"a window, (horizon + 1) M + 1, of at most {MOST_WINDOW} points, or points_ahead; "
            f"with M = {ratio} it has {window}",
        )


def _check_stroke(project: GovernorProject) -> None:
    margin, motion = project.controller.governor.stroke_margin_m, project.controller.motion
    if motion.streamed_window and motion.reference == "pattern":
        raise project.error(
            "controller.motion.streamed_window",
            motion.streamed_window,
            '0 with reference = "pattern", which needs no motion',
        )
    reserve = project.controller.motion.stroke_reserve_m
    for name, axis in project.machine.axes:
        stroke = axis.fast.range_m
        if margin >= stroke:
            raise project.error(
                "controller.governor.stroke_margin_m",
                margin,
                f"less than machine.{name}.fast.range_m = {stroke!r}",
            )
        if reserve >= stroke - margin:
            less = f" less controller.governor.stroke_margin_m = {margin!r}" if margin else ""
            raise project.error(
                "controller.motion.stroke_reserve_m",
                reserve,
                f"less than machine.{name}.fast.range_m = {stroke!r}{less}",
            )
