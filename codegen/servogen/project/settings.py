"""What the rooms below take, made from the tables of a project."""

from __future__ import annotations

from servogen.paths.profile import MotionLimits
from servogen.paths.settings import PathSettings
from servogen.plants.settings import (
    PythonSettings,
    ServoSettings,
    StageSettings,
    StateSpaceSettings,
    TransferFunctionSettings,
)
from servogen.project.governor_load import GovernorProject
from servogen.project.governor_machine import EqualPolesModel, GovernedAxis, GovernedStage
from servogen.project.load import Project
from servogen.project.machine import (
    Axis,
    FastStage,
    PythonModel,
    ServoModel,
    SlowStage,
    StateSpaceModel,
    TransferFunctionModel,
)
from servogen.sets.constraints import AxisLimits
from servogen.sets.extended import centred_limits

PathProject = Project | GovernorProject


def stage_settings(stage: SlowStage | FastStage | GovernedStage) -> StageSettings:
    """A stage table's model, for ``plants.build``."""
    match stage:
        case ServoModel():
            return ServoSettings(stage.bandwidth_rad_per_s, stage.damping)
        case TransferFunctionModel():
            return TransferFunctionSettings(stage.numerator, stage.denominator)
        case StateSpaceModel():
            return StateSpaceSettings(stage.a, stage.b, stage.c)
        case PythonModel():
            return PythonSettings(stage.file, stage.function, dict(stage.parameters))
        case EqualPolesModel():
            p = stage.pole_rad_per_s
            return TransferFunctionSettings((p**3,), (1.0, 3.0 * p, 3.0 * p**2, p**3))


def axis_limits(axis: Axis) -> AxisLimits:
    """Limits of one axis, for ``sets``."""
    return AxisLimits(
        position_m=axis.slow.position_limit_m,
        velocity_m_per_s=axis.slow.velocity_limit_m_per_s,
        acceleration_m_per_s2=axis.slow.acceleration_limit_m_per_s2,
        fast_range_m=axis.fast.range_m,
    )


def centred_axis_limits(axis: GovernedAxis) -> tuple[AxisLimits, float]:
    """Limits of one axis about the middle of its positions, for ``sets``, and that middle, m."""
    low, high = axis.slow.position_limit_m
    limits = AxisLimits(
        position_m=0.5 * (high - low),
        velocity_m_per_s=axis.slow.velocity_limit_m_per_s,
        acceleration_m_per_s2=axis.slow.acceleration_limit_m_per_s2,
        fast_range_m=axis.fast.range_m,
    )
    return centred_limits(low, high, limits)


def path_settings(project: PathProject) -> PathSettings:
    """The table ``[path]``, for ``paths.load``."""
    path = project.path
    return PathSettings(
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


def motion_limits(project: PathProject) -> MotionLimits:
    """Limits of the ideal machine: of two axes that differ, the lower ones serve both."""
    stages = [axis.fast for _, axis in project.machine.axes]
    path = project.path
    return MotionLimits(
        velocity_m_per_s=min(stage.velocity_limit_m_per_s for stage in stages),
        acceleration_m_per_s2=min(stage.acceleration_limit_m_per_s2 for stage in stages),
        tangential_acceleration_m_per_s2=path.tangential_acceleration_m_per_s2,
        centripetal_acceleration_m_per_s2=path.centripetal_acceleration_m_per_s2,
        corner_time_s=path.corner_time_s,
    )
