"""``servogen report``: everything found, as one page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from servogen.outputs import write_file
from servogen.steps.system import Findings, Simulated, Studied, System

SCHEMA = "servogen.report/1"


@dataclass(frozen=True)
class ReportResult:
    """Where the page is; ``missing``: what it shows as not run."""

    out: Path
    size: int
    missing: tuple[str, ...] = ()
    passed: bool = True

    def lines(self) -> list[str]:
        lines = [f"report    {self.out} ({self.size / 1e6:.1f} MB)"]
        if self.missing:
            told = ", ".join(self.missing)
            lines.append(f"          without what was not run: {told}; servogen run does all of it")
        return lines

    def to_json(self) -> dict[str, object]:
        return {"schema": SCHEMA, "passed": self.passed, "bytes": self.size}


def report(
    system: System[Simulated, Studied], found: Findings[Simulated, Studied], out: Path
) -> ReportResult:
    """Write the page."""
    page = system.page(found)
    write_file(out, page)
    verbs = {"sil": found.sil, "wcet": found.wcet, "study": found.study}
    missing = tuple(verb for verb, done in verbs.items() if done is None)
    return ReportResult(out, len(page.encode()), missing)
