"""``servogen report``: everything found, as one page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from servogen.evidence.certificate import Certificate
from servogen.outputs import write_file
from servogen.reports import ReportData, make_report
from servogen.steps.build import BuildResult
from servogen.steps.compare import StudyResult
from servogen.steps.count import WcetResult
from servogen.steps.equivalence import SilResult
from servogen.steps.prepare import Prepared
from servogen.steps.simulate import SimulateResult
from servogen.systems.metrics import contour_error

SCHEMA = "servogen.report/1"


@dataclass(frozen=True)
class Findings:
    """What the report is made of; what was not run is None and is shown as not run."""

    prepared: Prepared
    simulated: SimulateResult
    wcet: WcetResult | None = None
    sil: SilResult | None = None
    study: StudyResult | None = None
    certificate: Certificate | None = None


@dataclass(frozen=True)
class ReportResult:
    """Where the page is."""

    out: Path
    size: int
    passed: bool = True

    def lines(self) -> list[str]:
        return [f"report    {self.out} ({self.size / 1e6:.1f} MB)"]

    def to_json(self) -> dict[str, object]:
        return {"schema": SCHEMA, "passed": self.passed, "bytes": self.size}


def report(found: Findings, out: Path) -> ReportResult:
    """Write the page."""
    prepared = found.prepared
    built = BuildResult(prepared.package, out, prepared.tuning.solver.cap)
    data = ReportData(
        machine=prepared.machine,
        run=found.simulated.run,
        row=found.simulated.row,
        contour_error=contour_error(found.simulated.run),
        study=found.study.rows if found.study else None,
        sil=found.sil.to_json() if found.sil else None,
        wcet=found.wcet.to_json() if found.wcet else None,
        build=built.to_json(),
        design=prepared.design,
        certificate=found.certificate,
    )
    page = make_report(data)
    write_file(out, page)
    return ReportResult(out, len(page.encode()))
