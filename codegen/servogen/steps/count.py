"""``servogen wcet``: counts of the emitted C against the target's budget."""

from __future__ import annotations

from dataclasses import dataclass

from servogen.steps.prepare import SLOW, Prepared, allow, project_target
from servogen.wcet.allowance import Allowance, iteration_allowance
from servogen.wcet.package import PackageCount

SCHEMA = "servogen.wcet/1"


@dataclass(frozen=True)
class WcetResult:
    """``slow``: the long part in its share of the slow period; ``fast``: the fast step in the same
    share of the fast period; ``memory_bytes``: the target's, for tables."""

    counts: PackageCount
    slow: Allowance
    fast: Allowance
    slow_entry: str
    fast_entry: str
    share: float
    memory_bytes: int

    @property
    def tables_fit(self) -> bool:
        return self.counts.total_table_bytes <= self.memory_bytes

    @property
    def passed(self) -> bool:
        return self.slow.fits and self.fast.fits and self.tables_fit

    def lines(self) -> list[str]:
        step = self.counts.entry_points[self.slow_entry]
        total, one = step.total().as_dict(), step.one_iteration().as_dict()
        return [
            f"wcet      {self.slow_entry}: {self.slow.sentence()}",
            f"          worst case {_named(total)}",
            f"          per iteration of both axes {_named(one)}",
            f"          {self.fast_entry}: {self.fast.sentence()}",
            f"          tables {self.counts.total_table_bytes} bytes of {self.memory_bytes}"
            f"{'' if self.tables_fit else ', TOO MANY'}, "
            f"stack of C objects {step.stack_bytes} bytes",
            "          operations are counted in the C; cycles are the target file's estimates",
        ]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "share": self.share,
            "memory_bytes": self.memory_bytes,
            "tables_fit": self.tables_fit,
            "budgets": {
                self.slow_entry: self.slow.to_json(),
                self.fast_entry: self.fast.to_json(),
            },
            **self.counts.to_json(),
        }


def _named(counts: dict[str, int]) -> str:
    shown = ("add", "mul", "div", "cmp", "load", "store")
    return ", ".join(f"{counts[name]} {name}" for name in shown)


def count(prepared: Prepared, target_name: str | None) -> WcetResult:
    """Count every entry point; budget the two that run periodically."""
    project = prepared.machine.project
    target = project_target(project, target_name)
    counts = prepared.counts_in(prepared.machine.precision)
    slow, fast = f"{project.name}_{SLOW}", f"{project.name}_fast_step"
    return WcetResult(
        counts=counts,
        slow=allow(prepared.machine, counts, target),
        fast=iteration_allowance(
            counts.entry_points[fast],
            target,
            counts.precision,
            prepared.machine.fast_period_s,
            project.target.share,
        ),
        slow_entry=slow,
        fast_entry=fast,
        share=project.target.share,
        memory_bytes=int(target.data_bytes.value + target.program_bytes.value),
    )
