"""Relations between keys that can be judged from the numbers alone, before any plant is built."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from servogen.project.machine import (
    Axis,
    FastServo,
    FastStateSpace,
    FastTransferFunction,
    SlowServo,
    SlowStateSpace,
    SlowTransferFunction,
)
from servogen.project.schema import DRAWING_SUFFIXES

if TYPE_CHECKING:
    from servogen.project.load import Project

# T_s / T_f as written in decimal is off an integer by a few rounding errors, not by more.
_RATIO_TOLERANCE = 1e-9
_MAX_RATIO = 10_000
_FLOAT32_LEAST_MARGIN = 1e-5


def check_consistency(project: Project) -> None:
    """Raise an InputError for the first contradiction between keys of the file."""
    for name, axis in project.machine.axes:
        if name == "y" and axis is project.machine.x:
            continue
        _check_axis(project, f"machine.{name}", axis)
    _check_sampling(project)
    _check_solver(project)
    _check_path(project)


def _check_axis(project: Project, key: str, axis: Axis) -> None:
    slow, fast = axis.slow, axis.fast
    if fast.range_m >= slow.position_limit_m:
        raise project.error(
            f"{key}.fast.range_m",
            fast.range_m,
            f"less than slow.position_limit_m = {slow.position_limit_m!r}",
        )
    if fast.acceleration_limit_m_per_s2 < slow.acceleration_limit_m_per_s2:
        raise project.error(
            f"{key}.fast.acceleration_limit_m_per_s2",
            fast.acceleration_limit_m_per_s2,
            "at least the slow stage's acceleration_limit_m_per_s2 = "
            f"{slow.acceleration_limit_m_per_s2!r}",
        )
    if (
        isinstance(slow, SlowServo)
        and isinstance(fast, FastServo)
        and fast.bandwidth_rad_per_s <= slow.bandwidth_rad_per_s
    ):
        raise project.error(
            f"{key}.fast.bandwidth_rad_per_s",
            fast.bandwidth_rad_per_s,
            f"more than slow.bandwidth_rad_per_s = {slow.bandwidth_rad_per_s!r}",
        )
    for part, stage in (("slow", slow), ("fast", fast)):
        if isinstance(stage, SlowTransferFunction | FastTransferFunction):
            _check_polynomials(project, f"{key}.{part}", stage)
        if isinstance(stage, SlowStateSpace | FastStateSpace):
            _check_matrices(project, f"{key}.{part}", stage)


def _check_polynomials(
    project: Project, key: str, stage: SlowTransferFunction | FastTransferFunction
) -> None:
    if stage.denominator[0] == 0.0:
        raise project.error(f"{key}.denominator[0]", 0.0, "a leading coefficient that is not zero")
    if not any(stage.numerator):
        raise project.error(
            f"{key}.numerator", list(stage.numerator), "a coefficient that is not zero"
        )


def _check_matrices(project: Project, key: str, stage: SlowStateSpace | FastStateSpace) -> None:
    size = len(stage.a)
    for index, row in enumerate(stage.a):
        if len(row) != size:
            raise project.error(
                f"{key}.a[{index}]", list(row), f"{size} numbers, since a has {size} rows"
            )
    for name, vector in (("b", stage.b), ("c", stage.c)):
        if len(vector) != size:
            raise project.error(
                f"{key}.{name}", list(vector), f"{size} numbers, since a has {size} rows"
            )


def _check_sampling(project: Project) -> None:
    slow = project.sampling.slow_sample_time_s
    fast = project.sampling.fast_sample_time_s
    ratio = slow / fast
    whole = math.isclose(ratio, round(ratio), rel_tol=_RATIO_TOLERANCE)
    if not whole or not 2 <= round(ratio) <= _MAX_RATIO:
        raise project.error(
            "sampling.slow_sample_time_s",
            slow,
            f"a whole multiple, from 2 to {_MAX_RATIO} times, of fast_sample_time_s = {fast!r}",
        )


def _check_solver(project: Project) -> None:
    margin = project.controller.solver.constraint_margin
    if project.output.precision == "float32" and margin < _FLOAT32_LEAST_MARGIN:
        raise project.error(
            "controller.solver.constraint_margin",
            margin,
            f'at least {_FLOAT32_LEAST_MARGIN!r} with output.precision = "float32"',
        )


def _check_path(project: Project) -> None:
    path = project.path
    if path.file.suffix.lower() not in DRAWING_SUFFIXES:
        raise project.error(
            "path.file", path.file.name, f"a file ending in {', '.join(DRAWING_SUFFIXES)}"
        )
    fast = [(name, axis.fast) for name, axis in project.machine.axes]
    for key in ("tangential_acceleration_m_per_s2", "centripetal_acceleration_m_per_s2"):
        for name, stage in fast:
            if getattr(path, key) > stage.acceleration_limit_m_per_s2:
                raise project.error(
                    f"path.{key}",
                    getattr(path, key),
                    f"at most machine.{name}.fast.acceleration_limit_m_per_s2 = "
                    f"{stage.acceleration_limit_m_per_s2!r}",
                )
    limit = project.target.contour_error_limit_m
    if path.tolerance_m > limit:
        raise project.error(
            "path.tolerance_m",
            path.tolerance_m,
            f"at most target.contour_error_limit_m = {limit!r}",
        )
