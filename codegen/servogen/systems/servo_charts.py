"""The paper's comparison as a whole: its tables and charts on this drive, in one object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.errors import InputError
from servogen.progress import Progress
from servogen.systems.servo_drive import ServoDrive, tracking_problem
from servogen.systems.servo_figures import Disturbance, Waterfall, disturbance_run, waterfall
from servogen.systems.servo_loop import DriveRun, Track
from servogen.systems.servo_study import (
    EXTENSIONS,
    FAST,
    HORIZONS,
    SLOW,
    LargestError,
    TrackingTable,
    ideal_track,
    pid_track,
    printed_comparison,
    tracking_table,
)
from servogen.systems.servo_task import pull_task

# Samples of a cycle below which a sine is none, and of a run beyond which nobody waits for it.
FEWEST, MOST = 8, 100_000


@dataclass(frozen=True)
class Study:
    """Everything that the paper compares.

    Attributes:
        tables: Figures 7 and 8.
        errors, reason: the largest errors beside those printed, and why they differ.
        tracks: Figures 5 and 6 at 10 Hz: the MPC (H_t = H_u = 8) and the PID, if there is one.
        waterfalls: Figures 9 and 10, by extension.
        disturbance: Figure 16; None for a drive on which no torque acts.
        absent: why there is none of it but the disturbance; empty where there is.
    """

    tables: tuple[TrackingTable, ...] = ()
    errors: tuple[LargestError, ...] = ()
    reason: str = ""
    tracks: tuple[Track, DriveRun | None] | None = None
    waterfalls: tuple[tuple[str, Waterfall], ...] = ()
    disturbance: Disturbance | None = None
    absent: str = ""

    @property
    def faults(self) -> list[str]:
        """One sentence for each table with an error that is none."""
        return [
            f"at {table.case.frequency_hz:g} Hz a controller does not hold the axis"
            for table in self.tables
            if not np.all(np.isfinite([*table.zero_order, *table.first_order[1:]]))
        ]


def whole_study(servo: ServoDrive, progress: Progress) -> Study:
    """Run the comparison; where the project's horizons, weights or sample time do not allow it, say
    so."""
    pulled = None if pull_task(servo) is None else disturbance_run(servo)
    absent = _sampling_fault(servo)
    if absent:
        return Study(disturbance=pulled, absent=absent)
    try:
        tracking_problem(servo, HORIZONS[-1])  # what refuses the longest refuses at once
        tables = tuple(tracking_table(servo, case, progress) for case in (SLOW, FAST))
        with progress.task("Largest errors and plans"):
            errors, reason = printed_comparison(servo)
            track = ideal_track(servo, FAST, HORIZONS[-1], "first_order")
            falls = tuple((extension, waterfall(servo, extension)) for extension in EXTENSIONS)
            beside = pid_track(servo, FAST)
    except InputError as error:
        return Study(disturbance=pulled, absent=f"{error.key}: expected {error.expected}")
    return Study(tables, errors, reason, (track, beside), falls, pulled)


def _sampling_fault(servo: ServoDrive) -> str:
    period = servo.drive.sample_time_s
    if FAST.last(period) < FEWEST:
        return (
            f"a cycle at {FAST.frequency_hz:g} Hz has fewer than {FEWEST} samples of {period:g} s"
        )
    if SLOW.samples(period) * servo.ratio > MOST:
        return f"a run at {SLOW.frequency_hz:g} Hz has more than {MOST} samples"
    return ""
