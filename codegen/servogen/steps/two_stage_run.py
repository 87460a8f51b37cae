"""``servogen simulate`` of a two-stage machine: the closed loop over the whole path, judged."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

import numpy as np

from servogen.controllers.cascade import Cascade as ReferenceCascade
from servogen.controllers.cascade_design import CascadeDesign
from servogen.emit.package import CPackage
from servogen.errors import CheckFailed
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.closed_loop import Cascade, Run, Stalled, run_closed_loop
from servogen.systems.metrics import tool_acceleration
from servogen.systems.study import StudyRow, judge
from servogen.systems.two_stage import Machine

SCHEMA = "servogen.simulate/1"
# The cap is there to be reached now and then; more often than this it is too small.
BACKUP_SHARE = 0.01


@dataclass(frozen=True)
class SimulateResult:
    """The run, its row of judgements, and the checks on top of the constraints."""

    run: Run
    row: StudyRow
    inside: str
    contour_limit_m: float

    @property
    def backup_share(self) -> float:
        return self.row.backups / max(2 * self.row.periods, 1)

    @property
    def faults(self) -> list[str]:
        """One sentence for each check that failed."""
        row = self.row
        found = [] if row.complete else ["the path was not finished"]
        found += [] if row.followed else ["the reference left the path or skipped points"]
        found += [b.fault for b in row.bounds if not b.passed]
        if row.contour_error_m > self.contour_limit_m:
            found.append(
                f"contour error {1e6 * row.contour_error_m:.2f} um of "
                f"{1e6 * self.contour_limit_m:.6g} um (target.contour_error_limit_m)"
            )
        if self.backup_share > BACKUP_SHARE:
            found.append(
                f"backups on {self.backup_share:.1%} of the axis steps, at most {BACKUP_SHARE:.0%}"
            )
        return found

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        p = self.row.performance
        lines = [
            f"simulate  {p.time_s:.2f} s with the {self.inside} inside, {p.ratio:.4f} of the ideal "
            f"{self.run.machine.timed.duration_s:.2f} s; contour error "
            f"{1e6 * self.row.contour_error_m:.2f} um of {1e6 * self.contour_limit_m:.0f} um; "
            f"backups {self.row.backups} of {2 * self.row.periods} axis steps"
        ]
        for b in self.row.bounds:
            mark = "" if b.violation == 0.0 else f", over by {b.violation:.3g}"
            kind = "" if b.enforced else " (reported, not enforced)"
            lines.append(
                f"          {b.name} at {b.where}: {b.worst:.6g} of {b.limit:.6g} {b.unit}"
                f"{mark}{kind}"
            )
        tool, over = self._tool_acceleration()
        limit = self.tool_limit_m_per_s2
        lines.append(
            f"          reference of the fast stage: {tool:.4g} of {limit:.4g} m/s^2, "
            f"over on {over} of {len(self.run.reference)} fast samples (reported, not enforced)"
        )
        lines += [f"          FAILED: {fault}" for fault in self.faults]
        return lines

    @property
    def tool_limit_m_per_s2(self) -> float:
        """The ideal machine's limit, the lower one of both axes."""
        axes = self.run.machine.project.machine.axes
        return min(axis.fast.acceleration_limit_m_per_s2 for _, axis in axes)

    def _tool_acceleration(self) -> tuple[float, int]:
        """Largest second difference of the reference, m/s^2, and samples where it is too large."""
        values = np.max(np.abs(tool_acceleration(self.run)), axis=1)
        return float(np.max(values)), int(np.sum(values > self.tool_limit_m_per_s2 * (1 + 1e-6)))

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "inside": self.inside,
            "contour_limit_m": self.contour_limit_m,
            "backup_share": self.backup_share,
            "iterations": iteration_figures(self.run),
            "tool_acceleration_m_per_s2": self._tool_acceleration()[0],
            "tool_acceleration_over_limit_samples": self._tool_acceleration()[1],
            "tool_acceleration_limit_m_per_s2": self.tool_limit_m_per_s2,
            **row_json(self.row),
        }


def iteration_figures(run: Run) -> dict[str, float]:
    """Iterates per axis step: how many steps needed any, and how many then."""
    needed = run.iterations[run.iterations > 0]
    return {
        "steps": int(run.iterations.size),
        "steps_with_active_constraints": int(needed.size),
        "mean_of_those": float(np.mean(needed)) if needed.size else 0.0,
        "p99_of_those": float(np.percentile(needed, 99)) if needed.size else 0.0,
        "most": int(run.iterations.max(initial=0)),
    }


def row_json(row: StudyRow) -> dict[str, object]:
    """A judged run for programs."""
    return {
        "name": row.name,
        "complete": row.complete,
        "followed": row.followed,
        "periods": row.periods,
        "performance": {k: list(v) if isinstance(v, tuple) else v
                        for k, v in asdict(row.performance).items()},
        "contour_error_m": row.contour_error_m,
        "statuses": row.statuses,
        "backups": row.backups,
        "constraints": [
            {**asdict(b), "violation": b.violation, "passed": b.passed} for b in row.bounds
        ],
    }  # fmt: skip


@contextmanager
def _controller(design: CascadeDesign, package: CPackage | None) -> Iterator[Cascade]:
    if package is None:
        yield ReferenceCascade(design)
        return
    with built(package) as module:
        yield CompiledController(module, package.declarations[-1])


def simulate(
    machine: Machine, design: CascadeDesign, package: CPackage | None, progress: Progress
) -> SimulateResult:
    """Process the whole path.

    Args:
        package: the C inside; None: the reference of ``design``.

    Raises:
        CheckFailed: the loop stalled.
    """
    periods = int(np.ceil(len(machine.timed.points) / machine.ratio))
    with (
        _controller(design, package) as cascade,
        progress.task("Closed loop", total=periods) as task,
    ):
        try:
            run = run_closed_loop(machine, cascade, advance=task.advance)
        except Stalled as stalled:
            raise CheckFailed(f"the closed loop stalled: {stalled}") from stalled
    return SimulateResult(
        run=run,
        row=judge(machine.project.name, run),
        inside="Python reference" if package is None else "compiled C",
        contour_limit_m=machine.project.target.contour_error_limit_m,
    )
