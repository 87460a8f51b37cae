"""Relations between the keys of a contour controller's file that its numbers alone can break."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from servogen.plants.machining_centre import SAMPLE_TIME_S
from servogen.project.contour_machine import (
    CentreDrive,
    ContourAxisTable,
    MatricesDrive,
    VelocityServo,
    VelocityTransfer,
)
from servogen.project.contour_schema import ButterflyContour, CircleContour, ContourPath
from servogen.project.schema import DRAWING_SUFFIXES

if TYPE_CHECKING:
    from servogen.project.contour_load import ContourProject

# Sample times as written in decimal differ by a few rounding errors, not by more.
_SAME = 1e-9
# Samples on a circle's or butterfly's characteristic length: fewer make no curve of them.
LEAST_SAMPLES = 16
# In so many samples a velocity loop comes closer by a factor of e.
SETTLED_SAMPLES = 1000


def check_contour(project: ContourProject) -> None:
    """Raise an InputError for the first contradiction between keys of the file."""
    seen: list[ContourAxisTable] = []
    for name, axis in project.axes:
        if not any(axis is other for other in seen):
            _check_drive(project, name, axis)
        seen.append(axis)
    _check_form(project)
    match project.contour:
        case ContourPath():
            _check_drawing(project, project.contour)
        case CircleContour():
            _check_circle(project, project.contour)
        case ButterflyContour():
            _check_reach(project, "contour.size_m", project.contour.size_m)
            _check_feed(project, project.contour.size_m, project.contour.feed_m_per_s)


def _check_drive(project: ContourProject, name: str, axis: ContourAxisTable) -> None:
    key, drive = f"machine.{name}", axis.drive
    if axis.encoder_m >= axis.position_limit_m:
        raise project.error(
            f"{key}.encoder_m",
            axis.encoder_m,
            f"less than position_limit_m = {axis.position_limit_m!r}",
        )
    match drive:
        case CentreDrive():
            period = project.sampling.sample_time_s
            if not math.isclose(period, SAMPLE_TIME_S, rel_tol=_SAME):
                raise project.error(
                    "sampling.sample_time_s",
                    period,
                    f"{SAMPLE_TIME_S!r}, at which machine.{name}.drive was identified",
                )
        case MatricesDrive():
            _check_matrices(project, f"{key}.drive", drive)
        case VelocityServo():
            _check_servo(project, f"{key}.drive", drive)
        case VelocityTransfer():
            _check_polynomials(project, f"{key}.drive", drive)


def _check_matrices(project: ContourProject, key: str, drive: MatricesDrive) -> None:
    size = len(drive.a)
    for index, row in enumerate(drive.a):
        if len(row) != size:
            raise project.error(
                f"{key}.a[{index}]", list(row), f"{size} numbers, since a has {size} rows"
            )
    for name, vector in (("b", drive.b), ("c", drive.c)):
        if len(vector) != size:
            raise project.error(
                f"{key}.{name}", list(vector), f"{size} numbers, since a has {size} rows"
            )


def _check_servo(project: ContourProject, key: str, drive: VelocityServo) -> None:
    """As fast as the sample time sees, and as slow as it takes a few thousand samples to see."""
    period, w, zeta = project.sampling.sample_time_s, drive.bandwidth_rad_per_s, drive.damping
    if w * period > math.pi:
        raise project.error(
            f"{key}.bandwidth_rad_per_s",
            w,
            f"at most {math.pi / period:.6g} rad/s, pi over sampling.sample_time_s",
        )
    slowest = zeta - math.sqrt(zeta**2 - 1.0) if zeta > 1.0 else zeta
    least = 1.0 / (SETTLED_SAMPLES * period)
    if w * slowest < least:
        low = w * period * SETTLED_SAMPLES < 1.0
        raise project.error(
            f"{key}.bandwidth_rad_per_s" if low else f"{key}.damping",
            w if low else zeta,
            f"a velocity loop that settles: its slowest mode decays at {w * slowest:.3g} 1/s and "
            f"has to at {least:.3g} 1/s or more, within {SETTLED_SAMPLES} samples",
        )


def _check_polynomials(project: ContourProject, key: str, drive: VelocityTransfer) -> None:
    if drive.denominator[0] == 0.0:
        raise project.error(f"{key}.denominator[0]", 0.0, "a leading coefficient that is not zero")
    if not any(drive.numerator):
        raise project.error(
            f"{key}.numerator", list(drive.numerator), "a coefficient that is not zero"
        )
    if len(drive.numerator) >= len(drive.denominator):
        raise project.error(
            f"{key}.numerator",
            list(drive.numerator),
            f"fewer coefficients than denominator's {len(drive.denominator)}",
        )


def _check_form(project: ContourProject) -> None:
    table = project.controller.contour
    if table.form != "tabulated":
        for key in ("entries", "direction_at"):
            if key in table.model_fields_set:
                raise project.error(
                    f"controller.contour.{key}",
                    getattr(table, key),
                    f'none with form = "{table.form}": it is of gains that are tabulated',
                )
        return
    if len(project.axes) != 2:
        raise project.error(
            "controller.contour.form", table.form, '"on_line" with three axes: a table has angles'
        )
    if table.contour_weight == 0.0:
        raise project.error(
            "controller.contour.form",
            table.form,
            '"on_line" with contour_weight = 0, whose gains have no angle',
        )
    if table.direction_at > table.preview:
        raise project.error(
            "controller.contour.direction_at",
            table.direction_at,
            f"at most preview = {table.preview}",
        )


def _check_circle(project: ContourProject, circle: CircleContour) -> None:
    _check_reach(project, "contour.radius_m", circle.radius_m)
    _check_feed(project, circle.radius_m, circle.feed_m_per_s)
    if circle.rise_m != 0.0 and len(project.axes) < 3:
        raise project.error("contour.rise_m", circle.rise_m, "0 without a third axis, machine.z")
    if len(project.axes) == 3:
        reach = project.axes[2][1].position_limit_m
        if abs(circle.rise_m) * circle.repetitions > reach:
            raise project.error(
                "contour.rise_m",
                circle.rise_m,
                f"at most machine.z.position_limit_m = {reach!r} in {circle.repetitions} turns",
            )


def _check_reach(project: ContourProject, key: str, size_m: float) -> None:
    for name, axis in project.axes[:2]:
        if size_m > axis.position_limit_m:
            raise project.error(
                key,
                size_m,
                f"at most machine.{name}.position_limit_m = {axis.position_limit_m!r}",
            )


def _check_feed(project: ContourProject, size_m: float, feed: float) -> None:
    fastest = 2.0 * math.pi * size_m / (LEAST_SAMPLES * project.sampling.sample_time_s)
    if feed > fastest:
        raise project.error(
            "contour.feed_m_per_s",
            feed,
            f"at most {fastest:.4g} m/s, {LEAST_SAMPLES} samples round the contour's size",
        )


def _check_drawing(project: ContourProject, path: ContourPath) -> None:
    if path.file.suffix.lower() not in DRAWING_SUFFIXES:
        raise project.error(
            "path.file", path.file.name, f"a file ending in {', '.join(DRAWING_SUFFIXES)}"
        )
    for key in ("tangential_acceleration_m_per_s2", "centripetal_acceleration_m_per_s2"):
        if getattr(path, key) > path.acceleration_limit_m_per_s2:
            raise project.error(
                f"path.{key}",
                getattr(path, key),
                f"at most acceleration_limit_m_per_s2 = {path.acceleration_limit_m_per_s2!r}",
            )
