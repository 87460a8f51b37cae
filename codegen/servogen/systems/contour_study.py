"""The contour controller compared: its weights, its end weight, its table, a finite preview."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from servogen.controllers.contour_axis import axis_model
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.contour_stability import FrozenSpectrum, frozen_spectrum
from servogen.controllers.contour_weights import Terminal
from servogen.controllers.design import Reference
from servogen.errors import InputError
from servogen.plants.machining_centre import machining_centre
from servogen.precision import FLOAT32, FLOAT64
from servogen.progress import Progress, Task
from servogen.systems.contour_loop import ContourRun, Trouble, run_contour
from servogen.systems.contour_machine import (
    ContourMachine,
    ContourSettings,
    contour_design,
    contour_settings,
    velocity_gain,
    with_weights,
)
from servogen.systems.contour_previewed import run_previewed
from servogen.systems.contour_proofs import DIRECTIONS
from servogen.systems.contour_rows import ContourRow, judge_contour
from servogen.systems.contour_task import ContourTask, at_feed_only

# Of the paper's table: end weight, alpha, beta, at this rho and its drives' velocity per command.
CASES = {
    "I": (Terminal.OUTPUT, 8.0, 0.0),
    "II": (Terminal.OUTPUT, 1.2, 20.0),
    "III": (Terminal.STATIONARY, 3.0, 0.0),
    "IV": (Terminal.STATIONARY, 0.25, 15.0),
}
PAPER_CONTROL, PAPER_ALPHA_OF_PREVIEWS, PAPER_ALPHA_OF_WEIGHTS = 2e-9, 4.0, 1.2
PREVIEWS = tuple(range(1, 16))
CONTOUR_WEIGHTS = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0)
# Samples before those that count: what a start leaves is below a nanometre then, but with hardly
# any preview.
LEAD, LONG_LEAD, HARDLY = 60, 1750, 2
# The same of filters that are at rest when the machine is not.
FILTER_LEAD = 300
# Of a table where the project has none.
ENTRIES, DIRECTION_AT = 64, 4
# What single precision may change of an RMS error: metres, or a share of it.
SINGLE_M, SINGLE_SHARE = 1e-8, 0.02

# How long an axis stands still at most, and what share of their velocity the drives have left.
STILL_S, MOST_STILL, TOO_LITTLE = 0.015, 50, 0.9
PROJECT, ENCODER = "this project", "this project, by encoders"
PLAIN, PLAIN_ALL = "plain tracking, beta = 0", "plain tracking, alpha + beta on every error"
PREVIEWED, HELD = "finite preview [10]", "finite preview [10], standing still beyond it"
_ENDS = {Terminal.OUTPUT: "C'QC", Terminal.STATIONARY: "H_s(Q_max)"}

Inside = Callable[[ContourLqDesign], AbstractContextManager[Reference]]


@dataclass(frozen=True)
class ContourSweep:
    """One setting varied: its values and a row for each."""

    title: str
    note: str
    key: str
    values: tuple[float, ...]
    rows: tuple[ContourRow, ...]


@dataclass(frozen=True)
class ContourStudy:
    """Rows compared, sweeps, and the frozen-time spectrum of both end weights.

    Attributes:
        scale: of the paper's weights alpha and beta on these drives.
        troubles: rows on a machine that cannot do as it is told, with contour weight and without.
    """

    rows: tuple[ContourRow, ...]
    troubles: tuple[ContourRow, ...]
    sweeps: tuple[ContourSweep, ...]
    spectra: tuple[FrozenSpectrum, ...]
    scale: float

    def row(self, name: str) -> ContourRow | None:
        """By its name, if it was run."""
        return next((row for row in self.rows if row.name == name), None)


@dataclass(frozen=True)
class Course:
    """What every run of a study shares."""

    machine: ContourMachine
    inside: Inside
    task: Task
    lead: int = LEAD

    @cached_property
    def contour(self) -> ContourTask:
        """The project's, at its feed."""
        return at_feed_only(self.machine.project, self.machine.task, self.lead)

    @cached_property
    def slow(self) -> Course:
        """The same with a long lead."""
        return replace(self, lead=LONG_LEAD)

    def run(
        self,
        name: str,
        design: ContourLqDesign,
        encoders: bool = False,
        trouble: Trouble | None = None,
    ) -> ContourRow:
        """A design along the contour, judged."""
        machine, contour = self.machine, self.contour
        with self.inside(design) as controller:
            found = run_contour(
                design, controller, machine.axes, contour.motion, contour.samples,
                machine.encoder_m if encoders else None, contour.moving, trouble=trouble,
            )  # fmt: skip
        return self.judged(name, found)

    def judged(self, name: str, run: ContourRun) -> ContourRow:
        """A run of it."""
        self.task.advance()
        return judge_contour(name, run, self.contour, self.machine.limits)


def compare_contours(machine: ContourMachine, inside: Inside, progress: Progress) -> ContourStudy:
    """The project and its variants, the paper's cases, the baseline; sweeps; spectra.

    Args:
        inside: gives what runs a design, its reference or its C.
    """
    scale = weight_scale(machine)
    total = (
        9
        + 4 * (machine.project.controller.contour.contour_weight > 0.0)
        + len(CASES)
        + len(PREVIEWS) * 2
        + len(CONTOUR_WEIGHTS) * 2
    )
    with progress.task("Comparing controllers", total=total) as task:
        course = Course(machine, inside, task)
        rows = [*_own(course), *_cases(course, scale), *_baselines(course, scale)]
        troubles = _troubles(course)
        sweeps = _sweeps(course, scale)
    settings = contour_settings(machine.project)
    spectra = tuple(
        frozen_spectrum(machine.axes, settings.weights, end, _longest(settings), DIRECTIONS)
        for end in Terminal
    )
    return ContourStudy(tuple(rows), troubles, sweeps, spectra, scale)


def weight_scale(machine: ContourMachine) -> float:
    """By which alpha and beta of the paper mean the same here: their ratio to rho counts, and a
    command that moves an axis so much faster costs so much less."""
    theirs = [
        velocity_gain(axis_model(axis, limit, table.position_limit_m))
        for axis, limit, (_, table) in zip(
            machining_centre(), machine.limits.tolist(), machine.project.axes, strict=False
        )
    ]
    ratio = float(np.mean(theirs)) / float(np.mean(machine.gains[: len(theirs)]))
    return contour_settings(machine.project).weights.control / PAPER_CONTROL * ratio**2


def _longest(settings: ContourSettings) -> int:
    return max(PREVIEWS[-1], settings.preview)


def _own(course: Course) -> list[ContourRow]:
    machine = course.machine
    settings, own = contour_settings(machine.project), machine.precision
    other = FLOAT64 if own is FLOAT32 else FLOAT32
    isotropic = replace(settings, entries=0)
    plain = with_weights(isotropic, settings.weights.tracking, 0.0)
    heavy = with_weights(isotropic, settings.weights.largest, 0.0)
    ends = [end for end in Terminal if end is not settings.terminal]
    design = contour_design(machine)
    rows = [
        course.run(f"{PROJECT}, {own.name}", design),
        course.run(f"{PROJECT}, {other.name}", contour_design(machine, other)),
        # the filters begin at rest, as the machine does not
        replace(course, lead=FILTER_LEAD).run(ENCODER, design, encoders=True),
        course.run(PLAIN, contour_design(machine, settings=plain)),
        course.run(PLAIN_ALL, contour_design(machine, settings=heavy)),
    ]
    for end in ends:
        changed = contour_design(machine, settings=replace(settings, terminal=end))
        rows.append(course.run(f"{PROJECT}, {_ENDS[end]} at the end", changed))
    if settings.entries:
        exact = contour_design(machine, settings=replace(settings, entries=0))
        rows.append(course.run(f"{PROJECT}, gains on line", exact))
    elif len(machine.axes) == 2 and settings.weights.contour > 0.0:
        at = min(DIRECTION_AT, settings.preview)
        table = replace(settings, entries=ENTRIES, direction_at=at)
        name = f"{PROJECT}, gains of {ENTRIES} directions"
        rows.append(course.run(name, contour_design(machine, settings=table)))
    return rows


def _troubles(course: Course) -> tuple[ContourRow, ...]:
    """Where contour weight shows: one axis cannot follow, and the other waits for it or not."""
    machine, contour = course.machine, course.contour
    settings = contour_settings(machine.project)
    if settings.weights.contour == 0.0:
        return ()
    period = machine.project.sampling.sample_time_s
    heavy = with_weights(replace(settings, entries=0), settings.weights.largest, 0.0)
    designs = {
        PROJECT: contour_design(machine),
        PLAIN_ALL: contour_design(machine, settings=heavy),
    }
    speeds = np.abs(np.diff(contour.motion.points, axis=0)) / period
    half = max((contour.first + contour.last) // 2, contour.first + 1)
    fastest = np.max(speeds[contour.first : half], axis=0)
    held = int(np.argmax(fastest > 0.5 * np.max(fastest)))  # the first that moves to speak of
    begin = contour.first + int(np.argmax(speeds[contour.first : half, held]))
    end = begin + min(max(round(STILL_S / period), 1), MOST_STILL)
    needed = TOO_LITTLE * np.max(speeds[contour.first : contour.last], axis=0) / machine.gains
    limits = np.where(needed > 0.0, np.minimum(needed, machine.limits), machine.limits)
    troubles = {
        f"{machine.names[held]} stands still for {1e3 * period * (end - begin):.3g} ms": Trouble(
            held, begin, end, machine.limits
        ),
        f"drives give {TOO_LITTLE:.0%} of the velocity needed": Trouble(0, 0, 0, limits),
    }
    return tuple(
        course.run(f"{told}: {name}", design, trouble=trouble)
        for told, trouble in troubles.items()
        for name, design in designs.items()
    )


def _cases(course: Course, scale: float) -> list[ContourRow]:
    rows = []
    for name, (end, alpha, beta) in CASES.items():
        settings = _paper(course.machine, end, scale * alpha, scale * beta)
        told = f"case {name}: {_ENDS[end]}, alpha = {scale * alpha:.3g}, beta = {scale * beta:.3g}"
        rows.append(course.run(told, contour_design(course.machine, FLOAT64, settings)))
    return rows


def _paper(machine: ContourMachine, end: Terminal, alpha: float, beta: float) -> ContourSettings:
    own = replace(contour_settings(machine.project), terminal=end, entries=0)
    return with_weights(own, alpha, beta)


def _baselines(course: Course, scale: float) -> list[ContourRow]:
    """With the weights of case III, which it is: neither knows of a contour error."""
    alpha, control = scale * CASES["III"][1], contour_settings(course.machine.project).weights
    preview = contour_settings(course.machine.project).preview
    rows = []
    for name, held in ((PREVIEWED, False), (HELD, True)):
        run = run_previewed(
            course.machine.axes, course.contour, alpha, control.control, preview, held,
            course.machine.limits,
        )  # fmt: skip
        rows.append(course.judged(name, run))
    return rows


def _sweeps(course: Course, scale: float) -> tuple[ContourSweep, ...]:
    own = replace(contour_settings(course.machine.project), entries=0)
    alpha = scale * PAPER_ALPHA_OF_PREVIEWS
    plain = _paper(course.machine, Terminal.OUTPUT, alpha, 0.0)
    weighted = scale * PAPER_ALPHA_OF_WEIGHTS
    return (
        _previews(
            course, "Preview, plain tracking",
            f"The paper's: C'QC at the end, alpha = {alpha:.3g}, beta = 0.", plain,
        ),
        _previews(
            course, "Preview, this project", "Weights and end weight of the project.", own
        ),
        _contours(
            course, "Contour weight",
            f"The paper's: C'QC at the end, alpha = {weighted:.3g}.",
            _paper(course.machine, Terminal.OUTPUT, weighted, 0.0), scale,
        ),
        _contours(
            course, "Contour weight, this project",
            "Everything else as in the project, on line.", own, scale,
        ),
    )  # fmt: skip


def _previews(course: Course, title: str, note: str, settings: ContourSettings) -> ContourSweep:
    values, rows = [], []
    for preview in PREVIEWS:
        asked = replace(settings, preview=preview)
        try:
            design = contour_design(course.machine, FLOAT64, asked)
        except InputError:  # too short for x_d beyond it
            course.task.advance()
            continue
        own = course.slow if preview <= HARDLY and course.contour.moving else course
        values.append(float(preview))
        rows.append(own.run(f"N_p = {preview}", design))
    return ContourSweep(title, note, "preview N_p [samples]", tuple(values), tuple(rows))


def _contours(
    course: Course, title: str, note: str, settings: ContourSettings, scale: float
) -> ContourSweep:
    values = tuple(scale * beta for beta in CONTOUR_WEIGHTS)
    rows = []
    for beta in values:
        asked = with_weights(settings, settings.weights.tracking, beta)
        design = contour_design(course.machine, FLOAT64, asked)
        rows.append(course.run(f"beta = {beta:.3g}", design))
    return ContourSweep(title, note, "contour weight beta [1/m²]", values, tuple(rows))


def study_faults(study: ContourStudy) -> list[str]:
    """One sentence for each promise that was not kept."""
    found = []
    single, double = (study.row(f"{PROJECT}, {name}") for name in ("float32", "float64"))
    if single and double:
        for what in ("tracking_rms_m", "contour_rms_m"):
            off = abs(getattr(single, what) - getattr(double, what))
            if off > max(SINGLE_M, SINGLE_SHARE * getattr(double, what)):
                name = what.split("_", maxsplit=1)[0]
                found.append(f"float32 changes the {name} error by {1e6 * off:.3g} um RMS")
    for spectrum in study.spectra:
        modulus, preview, _ = spectrum.worst()
        if spectrum.terminal is Terminal.STATIONARY and modulus >= 1.0:
            found.append(f"modulus {modulus:.6f} with {preview} points of preview and H_s(Q_max)")
    return found
