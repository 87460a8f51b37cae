"""``servogen study`` of a command governor: it and its rivals on both references."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.progress import Progress
from servogen.steps.governor_run import row_json
from servogen.steps.two_stage_study import run_compiled
from servogen.systems.command_governor import GovernorMachine, governor_design
from servogen.systems.command_governor_loop import GovernedRun
from servogen.systems.command_governor_rows import GovernorRow
from servogen.systems.command_governor_study import GovernorStudy, compare_governors, run_machine

SCHEMA = "servogen.study_governor/1"


@dataclass(frozen=True)
class GovernorStudyResult:
    """The comparison; it fails where the extended governor breaks a promise."""

    found: GovernorStudy

    @property
    def faults(self) -> list[str]:
        """One sentence for each promise that was not kept."""
        return [f"{row.name}: {fault}" for row in self.found.rows for fault in row.faults]

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        lines = [
            "study     time s, of ideal, largest and mean a m/s^2, covered m, work J/kg, "
            "iterations, velocity at kept instants and between"
        ]
        for row in self.found.rows:
            lines.append(f"          {row.name}: {_told(row)}")
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "rows": [{**row_json(row), "passed": row.passed} for row in self.found.rows],
        }


def _told(row: GovernorRow) -> str:
    if not row.complete:
        return f"not finished: {row.stopped}"
    largest, mean = (
        max(row.motion.largest_acceleration),
        float(np.mean(row.motion.mean_acceleration)),
    )
    return (
        f"{row.time_s:8.2f}  {row.time_s / row.ideal_s:6.3f}  {largest:8.3f}  {mean:8.3f}  "
        f"{sum(row.motion.distance_m):8.3f}  {sum(row.motion.work_j_per_kg):8.3f}  "
        f"{row.iterations[0]:6.1f}  "
        f"{100.0 * (1.0 + row.instants.velocity):.2f} %, "
        f"{100.0 * (1.0 + row.between.velocity):.2f} %"
    )


def study(machine: GovernorMachine, progress: Progress) -> GovernorStudyResult:
    """Run the comparison with the references of this paper's governors and the C of paper 1's."""
    return GovernorStudyResult(compare_governors(machine, run_reference, run_compiled, progress))


def run_reference(machine: GovernorMachine) -> GovernedRun:
    """The machine under the Python reference of its governor.

    Raises:
        Stalled: it stands still.
    """
    design = governor_design(machine)
    return run_machine(machine, design, CommandGovernor(design))
