"""Relations between keys that can be judged from the numbers alone, before any plant is built."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from servogen.errors import InputError
from servogen.project.machine import (
    Axis,
    FastLimits,
    FastServo,
    SlowServo,
    StateSpaceModel,
    TransferFunctionModel,
)
from servogen.project.schema import DRAWING_SUFFIXES, PathTable, Sampling

if TYPE_CHECKING:
    from servogen.project.load import Project

# T_s / T_f as written in decimal is off an integer by a few rounding errors, not by more.
_RATIO_TOLERANCE = 1e-9
_MAX_RATIO = 10_000
_FLOAT32_LEAST_MARGIN = 1e-5


class Judged(Protocol):
    """A project that says where a fault of its file is."""

    def error(self, key: str, value: object, expected: str) -> InputError: ...


def check_consistency(project: Project) -> None:
    """Raise an InputError for the first contradiction between keys of the file."""
    for name, axis in project.machine.axes:
        if name == "y" and axis is project.machine.x:
            continue
        _check_axis(project, f"machine.{name}", axis)
    check_sampling(project, project.sampling)
    check_margin(project, project.output.precision, project.controller.solver.constraint_margin)
    check_path(project, project.path, [(name, axis.fast) for name, axis in project.machine.axes])
    limit = project.target.contour_error_limit_m
    if project.path.tolerance_m > limit:
        raise project.error(
            "path.tolerance_m",
            project.path.tolerance_m,
            f"at most target.contour_error_limit_m = {limit!r}",
        )


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
        check_model(project, f"{key}.{part}", stage)


def check_model(project: Judged, key: str, stage: object) -> None:
    """Coefficients and matrices of a stage, if it has any."""
    if isinstance(stage, TransferFunctionModel):
        _check_polynomials(project, key, stage)
    if isinstance(stage, StateSpaceModel):
        _check_matrices(project, key, stage)


def _check_polynomials(project: Judged, key: str, stage: TransferFunctionModel) -> None:
    if stage.denominator[0] == 0.0:
        raise project.error(f"{key}.denominator[0]", 0.0, "a leading coefficient that is not zero")
    if not any(stage.numerator):
        raise project.error(
            f"{key}.numerator", list(stage.numerator), "a coefficient that is not zero"
        )


def _check_matrices(project: Judged, key: str, stage: StateSpaceModel) -> None:
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


def check_sampling(project: Judged, sampling: Sampling) -> None:
    """T_s is a whole number of T_f."""
    slow, fast = sampling.slow_sample_time_s, sampling.fast_sample_time_s
    ratio = slow / fast
    whole = math.isclose(ratio, round(ratio), rel_tol=_RATIO_TOLERANCE)
    if not whole or not 2 <= round(ratio) <= _MAX_RATIO:
        raise project.error(
            "sampling.slow_sample_time_s",
            slow,
            f"a whole multiple, from 2 to {_MAX_RATIO} times, of fast_sample_time_s = {fast!r}",
        )


def check_margin(project: Judged, precision: str, margin: float) -> None:
    """A margin that the arithmetic can honour."""
    if precision == "float32" and margin < _FLOAT32_LEAST_MARGIN:
        raise project.error(
            "controller.solver.constraint_margin",
            margin,
            f'at least {_FLOAT32_LEAST_MARGIN!r} with output.precision = "float32"',
        )


def check_path(project: Judged, path: PathTable, fast: Sequence[tuple[str, FastLimits]]) -> None:
    """A kind of drawing that can be read, and no more acceleration than the fast stages have."""
    if path.file.suffix.lower() not in DRAWING_SUFFIXES:
        raise project.error(
            "path.file", path.file.name, f"a file ending in {', '.join(DRAWING_SUFFIXES)}"
        )
    for key in ("tangential_acceleration_m_per_s2", "centripetal_acceleration_m_per_s2"):
        for name, stage in fast:
            if getattr(path, key) > stage.acceleration_limit_m_per_s2:
                raise project.error(
                    f"path.{key}",
                    getattr(path, key),
                    f"at most machine.{name}.fast.acceleration_limit_m_per_s2 = "
                    f"{stage.acceleration_limit_m_per_s2!r}",
                )
