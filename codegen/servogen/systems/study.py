"""The comparison of Table I: the same machine and path under eight controllers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from servogen.controllers.cascade_design import declare_parts
from servogen.progress import Progress
from servogen.qp.condense import TrackingWeights
from servogen.systems.closed_loop import Run
from servogen.systems.lfs import run_lfs
from servogen.systems.metrics import (
    Bound,
    Performance,
    bounds,
    contour_error,
    follows_path,
    performance,
    status_counts,
)
from servogen.systems.two_stage import Machine, Tuning, design_cascade

# Weights of position, velocity, acceleration, command; the paper does not publish its own.
CALIBRATIONS = {
    "B": TrackingWeights(0.003, 0.1, 1.0, 0.001),
    "H": TrackingWeights(0.3, 0.3, 1.0, 0.01),
    "L": TrackingWeights(0.001, 2.0, 1.0, 0.01),
}
# Table I of paper 1: time s, max |a| m/s^2, mean |a|, mean |v| cm/s, mean fast mm, work.
PAPER: dict[str, tuple[float, tuple[float, float], tuple[float, float], tuple[float, float],
                       tuple[float, float], tuple[float, float]]] = {
    "LFS": (55.98, (6.18, 5.113), (0.66, 0.54), (7.71, 7.49), (11.22, 10.74), (3.02, 2.55)),
    "SPRG": (50.75, (15.69, 15.69), (1.99, 1.66), (12.53, 11.02), (3.51, 3.07), (16.57, 14.26)),
    "MPC-20-B": (50.38, (6.18, 10.73), (0.08, 0.11), (3.23, 4.13), (15.35, 16.50), (0.34, 0.82)),
    "MPC-20-H": (48.25, (7.10, 12.73), (0.84, 0.70), (8.59, 8.35), (5.15, 4.24), (4.35, 4.00)),
    "MPC-20-L": (54.81, (5.87, 10.11), (0.07, 0.08), (2.83, 3.66), (17.28, 19.98), (0.26, 0.43)),
    "MPC-03-B": (51.35, (14.66, 15.13), (0.49, 0.59), (3.02, 3.90), (20.92, 24.89), (5.32, 5.77)),
    "MPC-03-H": (48.58, (13.08, 12.94), (1.21, 1.18), (7.86, 7.70), (9.88, 9.55), (9.80, 9.55)),
    "MPC-03-L": (55.71, (12.59, 12.57), (0.45, 0.54), (2.68, 3.50), (22.21, 25.53), (4.93, 5.26)),
}  # fmt: skip
PAPER_IDEAL_S = 46.42


@dataclass(frozen=True)
class StudyRow:
    """One controller of the table, judged."""

    name: str
    performance: Performance
    bounds: tuple[Bound, ...]
    contour_error_m: float
    statuses: dict[str, int]
    periods: int
    complete: bool
    followed: bool
    enforced: bool

    @property
    def backups(self) -> int:
        """Axis steps on which the cap was reached without a feasible iterate."""
        return self.statuses.get("BACKUP", 0) + self.statuses.get("INFEASIBLE", 0)

    @property
    def passed(self) -> bool:
        return (
            self.complete
            and self.followed
            and (not self.enforced or all(b.passed for b in self.bounds))
        )


def judge(name: str, run: Run, enforced: bool = True) -> StudyRow:
    """A run as a row of the table; ``enforced`` False for the baseline, which promises nothing."""
    return StudyRow(
        name=name,
        performance=performance(run),
        bounds=bounds(run),
        contour_error_m=float(contour_error(run).max()),
        statuses=status_counts(run),
        periods=run.periods,
        complete=run.complete,
        followed=follows_path(run),
        enforced=enforced,
    )


def study_tunings(own: Tuning) -> dict[str, Tuning]:
    """The governed rows of Table I with the project's own solver settings and cap."""
    tunings = {"SPRG": replace(own, horizon=0)}
    for horizon in (20, 3):
        for letter, weights in CALIBRATIONS.items():
            name = f"MPC-{horizon:02d}-{letter}"
            tunings[name] = replace(own, horizon=horizon, weights=weights)
    return tunings


def run_study(
    machine: Machine,
    own: Tuning,
    progress: Progress,
    run_governed: Callable[[Machine, Tuning], Run],
) -> tuple[list[StudyRow], dict[str, Run]]:
    """All rows, in the order of their completion times in the paper.

    Args:
        own: the project's tuning, for its solver settings.
        run_governed: runs one design around the plant; whether with the C inside is its affair.
    """
    tunings = study_tunings(own)
    rows: list[StudyRow] = []
    runs: dict[str, Run] = {}
    order = sorted(PAPER, key=lambda name: PAPER[name][0])
    with progress.task("Comparing controllers", total=len(order)) as task:
        for name in order:
            if name == "LFS":
                design = design_cascade(machine, tunings["SPRG"], "study")
                runs[name] = run_lfs(machine, design.fast, declare_parts(design)[-1])
            else:
                runs[name] = run_governed(machine, tunings[name])
            rows.append(judge(name, runs[name], enforced=name != "LFS"))
            task.advance()
    return rows, runs
