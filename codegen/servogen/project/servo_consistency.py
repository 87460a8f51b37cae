"""Relations between the keys of a servo drive's file, before any plant is built."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from servogen.project.limits import as_written
from servogen.project.servo_reference import MOST_SAMPLES, SineReference
from servogen.project.servo_schema import (
    LARGEST_ENTRY,
    LARGEST_TURN,
    LARGEST_WEIGHT,
    LEAST_ENTRY,
    DesignModel,
    MatricesDrive,
    ServoMpc,
    as_numbers,
)
from servogen.project.translate import value_text

if TYPE_CHECKING:
    from servogen.project.servo_load import ServoProject

# A ratio of periods written in decimal is off an integer by a few rounding errors, not by more.
_RATIO_TOLERANCE = 1e-9
_MAX_RATIO = 64
# Of a notch filter, or one over it.
MOST_GAIN = 1e6


def check_servo(project: ServoProject) -> None:
    """Raise an InputError for the first contradiction between keys of the file."""
    if isinstance(project.drive, MatricesDrive):
        _check_matrices(project, "drive", project.drive)
    _check_sampling(project)
    _check_mpc(project, project.controller.mpc)
    _check_pid(project)
    _check_angles(project)
    _check_length(project)


def _check_length(project: ServoProject) -> None:
    wanted, period = project.reference, project.sampling.current_sample_time_s
    samples = wanted.lasts_s / period
    if samples > MOST_SAMPLES:
        key = wanted.longest_by
        raise project.error(
            f"reference.{key}",
            getattr(wanted, key),
            f"a reference of at most {MOST_SAMPLES} samples of sampling.current_sample_time_s = "
            f"{period!r}, {MOST_SAMPLES * period:g} s, not {wanted.lasts_s:.6g} s",
        )


def _check_matrices(project: ServoProject, key: str, found: MatricesDrive | DesignModel) -> None:
    size = len(found.a)
    for index, row in enumerate(found.a):
        if len(row) != size:
            raise project.error(
                f"{key}.a[{index}]", list(row), f"{size} numbers, since a has {size} rows"
            )
        _check_entries(project, f"{key}.a[{index}]", row)
    for name, vector in (("b", found.b), ("c", found.c)):
        if len(vector) != size:
            raise project.error(
                f"{key}.{name}", list(vector), f"{size} numbers, since a has {size} rows"
            )
        _check_entries(project, f"{key}.{name}", vector)
        if max(map(abs, vector)) < LEAST_ENTRY:
            does = "the current moves" if name == "b" else "the encoder shows"
            raise project.error(
                f"{key}.{name}", list(vector), f"a state that {does} (by {LEAST_ENTRY:g} or more)"
            )


def _check_entries(project: ServoProject, key: str, row: Sequence[float]) -> None:
    for index, value in enumerate(row):
        if abs(value) > LARGEST_ENTRY:
            expected = f"a number of magnitude at most {LARGEST_ENTRY:g}"
            raise project.error(f"{key}[{index}]", value, expected)


def _check_sampling(project: ServoProject) -> None:
    sampling = project.sampling
    ratio = sampling.sample_time_s / sampling.current_sample_time_s
    whole = math.isclose(ratio, round(ratio), rel_tol=_RATIO_TOLERANCE)
    if not whole or not 1 <= round(ratio) <= _MAX_RATIO:
        raise project.error(
            "sampling.sample_time_s",
            sampling.sample_time_s,
            f"a whole multiple, from 1 to {_MAX_RATIO} times, of current_sample_time_s = "
            f"{sampling.current_sample_time_s!r}",
        )
    if isinstance(project.drive, MatricesDrive) and round(ratio) != 1:
        raise project.error(
            "sampling.current_sample_time_s",
            sampling.current_sample_time_s,
            f"sample_time_s = {sampling.sample_time_s!r} with drive.model = \"matrices\", which "
            "say nothing of the time between samples",
        )  # fmt: skip


def _check_mpc(project: ServoProject, mpc: ServoMpc) -> None:
    key = "controller.mpc"
    for name in ("trajectory_horizon", "control_horizon"):
        if getattr(mpc, name) > mpc.prediction_horizon:
            expected = f"at most prediction_horizon = {mpc.prediction_horizon}"
            raise project.error(f"{key}.{name}", getattr(mpc, name), expected)
    if mpc.reference_extension == "first_order" and mpc.trajectory_horizon < 2:
        raise project.error(
            f"{key}.trajectory_horizon",
            mpc.trajectory_horizon,
            'at least 2 with reference_extension = "first_order"',
        )
    _check_weights(project, f"{key}.weight_error", mpc.weight_error, mpc.prediction_horizon, True)
    _check_weights(project, f"{key}.weight_change", mpc.weight_change, mpc.control_horizon, False)
    if not any(mpc.weight_error):
        raise project.error(f"{key}.weight_error", as_numbers(mpc.weight_error), "one above 0")
    if mpc.position_bound_deg is not None and project.axis.turn_deg:
        raise project.error(
            f"{key}.position_bound_deg",
            as_written(mpc.position_bound_deg),
            f"none on an axis that comes round after axis.turn_deg = {project.axis.turn_deg}",
        )
    _check_samples(project, mpc)
    if mpc.model is not None:
        _check_matrices(project, f"{key}.model", mpc.model)


def _check_samples(project: ServoProject, mpc: ServoMpc) -> None:
    key, found = "controller.mpc.position_bound_samples", mpc.position_bound_samples
    if found is None:
        return
    if mpc.position_bound_deg is None:
        raise project.error(key, list(found), "none without position_bound_deg")
    rising = all(a < b for a, b in pairwise(found))
    if not rising or found[0] < 1 or found[-1] > mpc.prediction_horizon:
        expected = f"ascending samples from 1 to prediction_horizon = {mpc.prediction_horizon}"
        raise project.error(key, list(found), expected)


def _check_weights(
    project: ServoProject, key: str, found: Sequence[float], steps: int, zero: bool
) -> None:
    if len(found) not in (1, steps):
        expected = f"one number or {steps}, as many as the horizon has steps"
        raise project.error(key, list(found), expected)
    least = 1.0 / LARGEST_WEIGHT
    expected = f"a number from {least:g} to {LARGEST_WEIGHT:g}" + (", or 0" if zero else "")
    for index, value in enumerate(found):
        if not (least <= value <= LARGEST_WEIGHT or (zero and value == 0.0)):
            where = key if len(found) == 1 else f"{key}[{index}]"
            raise project.error(where, value, expected)


def _check_pid(project: ServoProject) -> None:
    pid = project.controller.pid
    if pid is None or pid.notch is None:
        return
    lead, numbers = pid.notch.denominator[0], pid.notch.numerator
    sizes = f"from {1.0 / MOST_GAIN:g} to {MOST_GAIN:g}"
    if not 1.0 / MOST_GAIN <= abs(lead) <= MOST_GAIN:
        expected = f"a leading coefficient that is not zero, of magnitude {sizes}"
        raise project.error("controller.pid.notch.denominator[0]", lead, expected)
    if not 1.0 / MOST_GAIN <= max(map(abs, numbers)) / abs(lead) <= MOST_GAIN:
        expected = f"numbers the largest of which is {sizes} times denominator[0] = {lead!r}"
        raise project.error("controller.pid.notch.numerator", list(numbers), expected)


def _check_angles(project: ServoProject) -> None:
    axis, wanted = project.axis, project.reference
    turn, reach = axis.turn_deg, axis.position_range_deg
    if turn and reach < turn:
        raise project.error(
            "axis.position_range_deg", reach, f"at least one turn, axis.turn_deg = {turn}"
        )
    if turn and 2.0 * reach / turn + 1.0 > LARGEST_TURN:
        most = (LARGEST_TURN - 1) * turn / 2
        raise project.error(
            "axis.position_range_deg", reach, f"at most {most:g}, so many turns of {turn}"
        )
    if isinstance(wanted, SineReference):
        key, far = "amplitude_deg", wanted.amplitude_deg
        fastest = 2.0 * math.pi * wanted.frequency_hz * wanted.amplitude_deg
    else:
        key, far, fastest = "stroke_deg", wanted.stroke_deg, wanted.speed_deg_per_s
    start = wanted.start_deg
    if abs(start) > reach:
        expected = f"within axis.position_range_deg = {reach!r} of zero"
        raise project.error("reference.start_deg", start, expected)
    if not turn and abs(start) + far > reach:
        beyond = f", {abs(start):g} of which reference.start_deg takes" if start else ""
        expected = f"at most axis.position_range_deg = {reach!r}{beyond}"
        raise project.error(f"reference.{key}", far, expected)
    bounds = project.controller.mpc.position_bound_deg
    if bounds is not None and not bounds[0] <= start <= bounds[1]:
        told = value_text(as_written(bounds))
        expected = f"a place within controller.mpc.position_bound_deg = {told}"
        raise project.error("reference.start_deg", start, expected)
    step = fastest * project.sampling.sample_time_s
    if turn and step >= 0.5 * turn:
        raise project.error(
            f"reference.{key}",
            far,
            f"a reference that moves less than half of axis.turn_deg = {turn} in one sample",
        )
