"""``servogen simulate`` of a command governor: the closed loop over the whole path, judged."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.emit.package import CPackage
from servogen.errors import CheckFailed
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor import GovernorMachine
from servogen.systems.command_governor_loop import Ahead, GovernedRun, Governor
from servogen.systems.command_governor_rows import NAMES, GovernorRow, judge_governed
from servogen.systems.command_governor_stream import StreamedReference
from servogen.systems.command_governor_study import run_machine

SCHEMA = "servogen.simulate_governor/1"
# The cap is there to be reached now and then; more often than this it is too small.
BACKUP_SHARE = 0.01
# Of a limit: what two simulations of the same path differ by.
ROUNDED = 1e-9


@dataclass(frozen=True)
class GovernorSimulation:
    """The run and its row."""

    run: GovernedRun
    row: GovernorRow
    inside: str

    @property
    def faults(self) -> list[str]:
        """One sentence for each check that failed."""
        found, share = self.row.faults, self.backup_share
        if share > BACKUP_SHARE:
            found.append(
                f"backups on {share:.1%} of the axis steps, at most {BACKUP_SHARE:.0%}: "
                "fewer with a larger weight_reference, target.share or iteration_cap, or a "
                "smaller horizon"
            )
        return found

    @property
    def backup_share(self) -> float:
        return self.row.backups / max(2 * self.row.periods, 1)

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        row, moved = self.row, self.row.motion
        lines = [
            f"simulate  {row.time_s:.2f} s with the {self.inside} inside, "
            f"{row.time_s / row.ideal_s:.3f} of the ideal {row.ideal_s:.2f} s; "
            f"{row.iterations[0]:.1f} iterations an axis and period, {row.iterations[1]} at most; "
            f"backups {row.backups} of {2 * row.periods} axis steps",
            f"          slow stage: largest acceleration {_pair(moved.largest_acceleration)}, mean "
            f"{_pair(moved.mean_acceleration)} m/s^2, {_pair(moved.distance_m)} m covered, "
            f"{_pair(moved.work_j_per_kg)} J/kg",
        ]
        for name in NAMES:
            kept, between = getattr(row.instants, name), getattr(row.between, name)
            lines.append(
                f"          {name}, at worst: {_share(kept)} where it is kept, "
                f"{_share(between)} at a fast sample (reported, not enforced)"
            )
        if row.iterations[1] == 0:
            lines.append(
                "          no constraint was ever active: every plan was the reference itself, and "
                "the governor had nothing to do on this drawing"
            )
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "inside": self.inside,
            "backup_share": self.backup_share,
            "points": int(self.run.taken.sum()),
            "points_of_a_period": {
                "mean": float(np.mean(self.run.taken)),
                "most": int(self.run.taken.max(initial=0)),
                "none_taken": int(np.count_nonzero(self.run.taken == 0)),
            },
            **row_json(self.row),
        }


def row_json(row: GovernorRow) -> dict[str, object]:
    """A judged run for programs; what a standstill leaves open is None."""
    return {
        "name": row.name,
        "complete": row.complete,
        "stopped": row.stopped,
        "promised": row.promised,
        "time_s": _number(row.time_s),
        "ideal_s": row.ideal_s,
        "periods": row.periods,
        "largest_velocity_m_per_s": [_number(v) for v in row.motion.largest_velocity],
        "largest_acceleration_m_per_s2": [_number(v) for v in row.motion.largest_acceleration],
        "mean_acceleration_m_per_s2": [_number(v) for v in row.motion.mean_acceleration],
        "rms_acceleration_m_per_s2": [_number(v) for v in row.motion.rms_acceleration],
        "distance_m": [_number(v) for v in row.motion.distance_m],
        "work_j_per_kg": [_number(v) for v in row.motion.work_j_per_kg],
        "mean_iterations": _number(row.iterations[0]),
        "most_iterations": row.iterations[1],
        "backups": row.backups,
        "infeasible": row.infeasible,
        "excess_at_instants": {k: _number(v) for k, v in asdict(row.instants).items()},
        "excess_between": {k: _number(v) for k, v in asdict(row.between).items()},
    }


def simulate(
    machine: GovernorMachine,
    design: CommandGovernorDesign,
    package: CPackage | None,
    progress: Progress,
) -> GovernorSimulation:
    """Machine the whole path.

    Args:
        package: the C inside, with a streamed motion that of the motion as well; None: the
            reference of ``design``, sent to the motion that was made beforehand, the same numbers.

    Raises:
        CheckFailed: the loop stalled.
    """
    total = int(np.ceil(len(machine.points) / machine.ratio))
    with (
        _inside(machine, design, package) as (governor, ahead),
        progress.task("Closed loop", total=total) as task,
    ):
        try:
            run = run_machine(machine, design, governor, None, task.advance, ahead)
        except Stalled as stalled:
            raise CheckFailed(f"the closed loop stalled: {stalled}") from stalled
    row = judge_governed(machine.project.name, machine, run)
    return GovernorSimulation(run, row, "Python reference" if package is None else "compiled C")


@contextmanager
def _inside(
    machine: GovernorMachine, design: CommandGovernorDesign, package: CPackage | None
) -> Iterator[tuple[Governor, Ahead | None]]:
    """The governor, and what streams the motion where that is C as well."""
    if package is None:
        yield CommandGovernor(design), None
        return
    with built(package) as module:
        motions = [
            CompiledController(module, one)
            for one in package.declarations
            if one.kind == "motion_window"
        ]
        ahead = None
        if motions:
            x, y = motions
            ahead = StreamedReference((x, y), machine.points)
        yield CompiledController(module, package.declarations[-1]), ahead


def _pair(values: tuple[float, float]) -> str:
    return f"{values[0]:.3g}, {values[1]:.3g}"


def _share(excess: float) -> str:
    """``99.9 %`` of its limit, or what it is beyond it."""
    if excess > ROUNDED:
        return f"{100.0 * excess:.3g} % beyond its limit"
    return f"{100.0 * (1.0 + excess):.4g} %"


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
