"""``servogen study`` of a two-stage machine: the paper's Table I on this machine."""

from __future__ import annotations

from dataclasses import dataclass

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.package import emit_package
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.steps.two_stage_run import BACKUP_SHARE, row_json
from servogen.systems.closed_loop import Run, run_closed_loop
from servogen.systems.study import PAPER, PAPER_IDEAL_S, StudyRow, run_study
from servogen.systems.two_stage import Machine, Tuning, design_cascade

SCHEMA = "servogen.study/1"
PREFIX = "study"


@dataclass(frozen=True)
class StudyResult:
    """Rows in the order of the paper's completion times."""

    rows: list[StudyRow]
    runs: dict[str, Run]
    cap: int

    @property
    def passed(self) -> bool:
        return all(
            row.passed and row.backups <= BACKUP_SHARE * 2 * row.periods for row in self.rows
        )

    def lines(self) -> list[str]:
        lines = [
            "study     T/ideal (paper)   max a        max a at T_f  mean a       mean v cm/s  "
            f"work J/kg      backups at a cap of {self.cap}"
        ]
        for row in self.rows:
            p = row.performance
            between = next(b for b in row.bounds if b.name == "acceleration" and not b.enforced)
            lines.append(
                f"  {row.name:9s} {p.ratio:.4f} ({PAPER[row.name][0] / PAPER_IDEAL_S:.3f})  "
                f"{_two(p.max_acceleration, 1)}  {between.worst:8.1f}"
                f"{'*' if between.violation else ' '}    {_two(p.mean_acceleration, 2)}  "
                f"{_two((100 * p.mean_velocity[0], 100 * p.mean_velocity[1]), 1)}  "
                f"{_two(p.work, 1)}  {row.backups:4d} of {2 * row.periods}"
                f"{'' if row.passed else '  FAILED'}"
            )
        if any(b.violation for row in self.rows for b in row.bounds if not b.enforced):
            lines.append(
                "          * over its limit between slow samples, where nothing holds it: "
                "inter_sample_rows does"
            )
        return lines

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "iteration_cap": self.cap,
            "rows": [
                {**row_json(row), "passed": row.passed, "enforced": row.enforced,
                 "paper": _paper(row.name)}
                for row in self.rows
            ],
        }  # fmt: skip


def _two(pair: tuple[float, float], digits: int) -> str:
    return f"{pair[0]:5.{digits}f}, {pair[1]:5.{digits}f}"


def _paper(name: str) -> dict[str, object]:
    time_s, max_a, mean_a, mean_v, fast, work = PAPER[name]
    return {
        "time_s": time_s,
        "ratio": time_s / PAPER_IDEAL_S,
        "max_acceleration": list(max_a),
        "mean_acceleration": list(mean_a),
        "mean_velocity_cm_per_s": list(mean_v),
        "mean_fast_mm": list(fast),
        "work": list(work),
    }


def compare(machine: Machine, tuning: Tuning, progress: Progress) -> StudyResult:
    """Run all rows with their compiled C."""
    rows, runs = run_study(machine, tuning, progress, run_compiled)
    return StudyResult(rows, runs, tuning.solver.cap)


def run_compiled(machine: Machine, tuning: Tuning) -> Run:
    """Design, emit, compile and run one controller around the plant."""
    design = design_cascade(machine, tuning, PREFIX)
    package = emit_package(design.prefix, declare_parts(design))
    with built(package) as module:
        return run_closed_loop(machine, CompiledController(module, package.declarations[-1]))
