"""``servogen study`` of a command governor: it and its rivals on both references."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_declaration import declare_governor_parts
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.emit.package import emit_package
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.steps.governor_run import row_json
from servogen.steps.two_stage_study import run_compiled
from servogen.systems.command_governor import GovernorMachine
from servogen.systems.command_governor_loop import Governor
from servogen.systems.command_governor_rows import GovernorRow
from servogen.systems.command_governor_study import GovernorStudy, compare_governors
from servogen.systems.command_governor_sweeps import REFERENCES, Sweep, Trial

SCHEMA = "servogen.study_governor/1"
# Of a path with fewer points Python is done before the compiler is; the bits are the same.
SHORT = 20_000
WIDTH = 54
REFERENCE_NAMES = " | ".join(REFERENCES.values())


@dataclass(frozen=True)
class GovernorStudyResult:
    """The comparison; it fails where the extended governor breaks a promise."""

    found: GovernorStudy

    @property
    def faults(self) -> list[str]:
        """One sentence for each promise that was not kept."""
        swept = [row for s in self.found.sweeps for t in s.trials for row in t.rows]
        # a setting that is the project itself was judged already
        rows = dict.fromkeys([*self.found.rows, *swept])
        return [f"{row.name}: {fault}" for row in rows for fault in row.faults]

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        lines = [
            f"study     ideal {self.found.ideal_s:.2f} s; at the greatest velocity "
            f"{self.found.velocity_bound_s:.2f} s",
            f"          {'':{WIDTH}}  time s of ideal  largest, RMS a  covered  work  iter-   "
            "velocity      stroke",
            f"          {'':{WIDTH}}                          m/s^2      m   J/kg  ations  kept, "
            "between  between",
        ]
        lines += [f"          {row.name:{WIDTH}}  {_told(row)}" for row in self.found.rows]
        for sweep in self.found.sweeps:
            lines += _swept(sweep)
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "ideal_s": self.found.ideal_s,
            "velocity_bound_s": self.found.velocity_bound_s,
            "rows": [{**row_json(row), "passed": row.passed} for row in self.found.rows],
            "sweeps": [
                {
                    "title": sweep.title,
                    "trials": [
                        {
                            "setting": t.label,
                            "is_project": t.is_project,
                            "rows": [row_json(row) for row in t.rows],
                        }
                        for t in sweep.trials
                    ],
                }
                for sweep in self.found.sweeps
            ],
        }


def _told(row: GovernorRow) -> str:
    if not row.complete:
        return f"not finished: {row.stopped}"
    largest = max(row.motion.largest_acceleration)
    rms = float(np.sqrt(np.mean(np.square(row.motion.rms_acceleration))))
    kept, between = row.instants.velocity, row.between.velocity
    return (
        f"{row.time_s:6.2f}  {row.time_s / row.ideal_s:6.2f}  {largest:6.2f}  {rms:6.3f}  "
        f"{sum(row.motion.distance_m):6.2f}  {sum(row.motion.work_j_per_kg):6.3f}  "
        f"{row.iterations[0]:5.1f}  {100.0 * (1.0 + kept):6.2f} %  "
        f"{100.0 * (1.0 + between):6.2f} %  {100.0 * (1.0 + row.between.stroke):6.2f} %"
    )


def _swept(sweep: Sweep) -> list[str]:
    """Of each setting, on minimal motion and on the pattern: time, and what is between samples."""
    head = f"          {sweep.title}: time s, largest a, velocity and stroke between, on "
    return [f"{head}{REFERENCE_NAMES}", *(f"            {_trial(t)}" for t in sweep.trials)]


def _trial(trial: Trial) -> str:
    told = []
    for row in trial.rows:
        if not row.complete:
            told.append(f"not finished: {row.stopped}")
            continue
        told.append(
            f"{row.time_s:6.2f}  {max(row.motion.largest_acceleration):5.2f}  "
            f"{100.0 * row.between.velocity:+6.2f} %  "
            f"{trial.over_stroke(row):>10}"
        )
    return f"{trial.told:{WIDTH}} {' | '.join(told)}"


def study(machine: GovernorMachine, progress: Progress) -> GovernorStudyResult:
    """Run the comparison, on a long path with the C of every governor."""
    inside = by_reference if len(machine.points) < SHORT else by_c
    return GovernorStudyResult(compare_governors(machine, inside, run_compiled, progress))


@contextmanager
def by_reference(design: CommandGovernorDesign) -> Iterator[Governor]:
    """The Python reference."""
    yield CommandGovernor(design)


@contextmanager
def by_c(design: CommandGovernorDesign) -> Iterator[Governor]:
    """The same, emitted and compiled."""
    package = emit_package(design.prefix, declare_governor_parts(design))
    with built(package) as module:
        yield CompiledController(module, package.declarations[-1])
