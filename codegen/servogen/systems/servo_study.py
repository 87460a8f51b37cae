"""The paper's tracking figures made from its own data: errors against the trajectory horizon, the
largest errors beside those it prints, and the runs that its charts show."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from servogen.controllers.pid import Pid
from servogen.controllers.prediction import Extension
from servogen.controllers.servo_mpc import ServoMpc, SolvedMove
from servogen.plants.sampled import Sampled
from servogen.precision import FLOAT64, FloatArray
from servogen.progress import Progress
from servogen.systems.servo_drive import (
    ServoDrive,
    mpc_design,
    pid_design,
    tracking_problem,
)
from servogen.systems.servo_loop import DriveRun, MpcLoop, PidLoop, Track, run_drive, track_ideal
from servogen.systems.servo_motion import sine

HORIZONS = tuple(range(1, 9))
AMPLITUDE_DEG = 2.0
EXTENSIONS: tuple[Extension, Extension] = ("zero_order", "first_order")


@dataclass(frozen=True)
class Case:
    """A sine from rest; the last of its cycles is judged."""

    frequency_hz: float
    limit_ma: float
    cycles: int

    def samples(self, period_s: float) -> int:
        """In the whole run."""
        return round(self.cycles / (self.frequency_hz * period_s))

    def last(self, period_s: float) -> int:
        """In the last cycle."""
        return round(1.0 / (self.frequency_hz * period_s))


# The paper's two frequencies. Its limit of 1 A at 1 Hz; at 10 Hz the motor's own 12 A, since the
# motion itself needs nearly 3 A (``current_needed``). After these cycles from rest a further one
# changes no error by a thousandth.
SLOW = Case(1.0, 1000.0, 2)
FAST = Case(10.0, 12000.0, 5)
AS_PRINTED = Case(10.0, 1000.0, 5)
# Two errors are of one size if neither is more than so many times the other.
ALIKE = 1.5
# Largest errors that the paper prints for 2 degrees at 10 Hz within 1 A, degrees.
PRINTED_MPC, PRINTED_PID = 0.0643, 0.5021


def within(cases: Iterable[Case]) -> str:
    """What a caption says of the currents of cases: they are not the project's."""
    told = [f"{case.limit_ma / 1000.0:g} A at {case.frequency_hz:g} Hz" for case in cases]
    return f"within {' and '.join(told)}, whatever the project's own current limit"


@dataclass(frozen=True)
class TrackingTable:
    """Summed magnitudes of the error over the last cycle, as shares of those of set-point tracking
    (H_t = 1); (8,) for H_t = H_u = 1..8, NaN where the first-order hold has no meaning; ``pid``:
    None where the project has no PID; ``reference_deg``: what the shares are of."""

    case: Case
    zero_order: FloatArray
    first_order: FloatArray
    pid: float | None
    reference_deg: float


@dataclass(frozen=True)
class LargestError:
    """Largest errors of one case, degrees: of the whole run and of its last cycle."""

    case: Case
    mpc: tuple[float, float]
    pid: tuple[float, float] | None
    needed_ma: float

    @property
    def reachable(self) -> bool:
        """Whether the current limit leaves the motion possible at all."""
        return self.needed_ma <= self.case.limit_ma


def current_needed(drive: Sampled, frequency_hz: float, amplitude_deg: float) -> float:
    """Peak current, mA, of a steady sine of the output: amplitude over the plant's gain there."""
    z = np.exp(2j * np.pi * frequency_hz * drive.sample_time_s)
    state = np.linalg.solve(z * np.eye(drive.order) - drive.a, drive.b[:, 0])
    return float(amplitude_deg / np.abs(drive.c[0] @ state))


def ideal_track(servo: ServoDrive, case: Case, horizon: int, extension: Extension) -> Track:
    """One run of the table, as Figures 5, 9 and 10 show them."""
    problem = tracking_problem(servo, horizon, extension, case.limit_ma)
    motion = sine(AMPLITUDE_DEG, case.frequency_hz)
    return track_ideal(problem, servo.drive, motion, case.samples(servo.drive.sample_time_s))


def pid_track(servo: ServoDrive, case: Case) -> DriveRun | None:
    """The same motion under the PID (Figure 6), which sees what the encoder shows."""
    design = pid_design(servo, case.limit_ma, FLOAT64)
    if design is None:
        return None
    motion = sine(AMPLITUDE_DEG, case.frequency_hz)
    samples = case.samples(servo.drive.sample_time_s)
    return run_drive(servo, PidLoop(Pid(design)), motion, samples)


def tracking_table(servo: ServoDrive, case: Case, progress: Progress) -> TrackingTable:
    """One case of Figures 7 and 8.

    Raises:
        InputError: a prediction horizon below the longest of the table, or weights of changes that
            differ from step to step.
    """
    last = case.last(servo.drive.sample_time_s)
    rows = {name: np.full(len(HORIZONS), np.nan) for name in EXTENSIONS}
    with progress.task("Tracking at every horizon", total=2 * len(HORIZONS)) as task:
        for extension in EXTENSIONS:
            for i, horizon in enumerate(HORIZONS):
                if extension == "zero_order" or horizon > 1:
                    track = ideal_track(servo, case, horizon, extension)
                    rows[extension][i] = np.sum(np.abs(track.error[-last:]))
                task.advance()
    run = pid_track(servo, case)
    whole = float(rows["zero_order"][0])
    return TrackingTable(
        case=case,
        zero_order=rows["zero_order"] / whole,
        first_order=rows["first_order"] / whole,
        pid=None if run is None else float(np.sum(np.abs(run.error[-last:]))) / whole,
        reference_deg=whole,
    )


def statements(tables: Iterable[TrackingTable]) -> list[tuple[str, bool]]:
    """What the paper says of its Figures 7 and 8, and whether it is so here."""
    found = []
    for table in tables:
        where = f"at {table.case.frequency_hz:g} Hz"
        first, zero = table.first_order[1:], table.zero_order
        longer = bool(np.all(np.diff(zero) < 0.0) and np.all(np.diff(first) < 0.0))
        found += [
            (f"{where} every longer trajectory horizon tracks better", longer),
            (f"{where} the first-order hold tracks better", bool(np.all(first < zero[1:]))),
        ]
        if table.pid is not None:
            best = bool(np.all(first < table.pid))
            found.append((f"{where} the first-order hold tracks better than the PID", best))
    return found


def largest_error(servo: ServoDrive, case: Case) -> LargestError:
    """Figures 5 and 6 in two numbers each."""
    last = case.last(servo.drive.sample_time_s)

    def pair(error: FloatArray) -> tuple[float, float]:
        size = np.abs(error)
        return float(np.max(size)), float(np.max(size[-last:]))

    run = pid_track(servo, case)
    return LargestError(
        case=case,
        mpc=pair(ideal_track(servo, case, HORIZONS[-1], "first_order").error),
        pid=None if run is None else pair(run.error),
        needed_ma=current_needed(servo.drive, case.frequency_hz, AMPLITUDE_DEG),
    )


def printed_comparison(servo: ServoDrive) -> tuple[tuple[LargestError, ...], str]:
    """The largest errors that the paper prints for ``AS_PRINTED``, ours at its limit, at the
    motor's and at the lower frequency, and why they differ."""
    found = tuple(largest_error(servo, case) for case in (AS_PRINTED, FAST, SLOW))
    printed, _, slow = found
    if printed.reachable:
        return found, "The motion is possible within the printed limit."
    pid = "" if slow.pid is None else f" and {slow.pid[0]:.3g} with the PID"
    why = (
        f"{AMPLITUDE_DEG:g} degrees at {AS_PRINTED.frequency_hz:g} Hz need a peak of "
        f"{printed.needed_ma:.0f} mA on this machine, and the paper's limit is "
        f"{AS_PRINTED.limit_ma:.0f} mA: within it no controller follows."
    )
    if not 1.0 / ALIKE < slow.mpc[0] / PRINTED_MPC < ALIKE:
        return found, why  # another machine than the paper's
    return found, (
        f"{why} The errors printed, {PRINTED_MPC:g} and {PRINTED_PID:g} degrees, are of the size "
        f"found at {SLOW.frequency_hz:g} Hz: {slow.mpc[0]:.3g} with the MPC{pid}."
    )


def solving_mpc(servo: ServoDrive) -> ServoMpc:
    """The project's MPC in float64, its first move by solving the program."""
    design = mpc_design(servo, precision=FLOAT64)
    return ServoMpc(design, SolvedMove(design.problem, design.precision))


def mpc_loop(servo: ServoDrive) -> MpcLoop:
    """The same for ``run_drive``."""
    controller = solving_mpc(servo)
    return MpcLoop(controller, controller.design.problem.horizons.trajectory)


def pid_loop(servo: ServoDrive) -> PidLoop:
    """The project's PID in float64, for ``run_drive``.

    Raises:
        InputError: the project has none.
    """
    design = pid_design(servo, precision=FLOAT64)
    if design is None:
        raise servo.project.fault("controller.pid", "missing", "a table")
    return PidLoop(Pid(design))
