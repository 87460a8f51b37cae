"""The verbs in their order. Every step returns a result with ``passed``, ``lines()`` and
``to_json()``; the command line prints the lines and sets its status."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar

from servogen.jsontext import json_text
from servogen.outputs import write_file
from servogen.progress import Progress
from servogen.project import Project
from servogen.steps import build as building
from servogen.steps import check as checking
from servogen.steps import compare as comparing
from servogen.steps import count as counting
from servogen.steps import equivalence as proving
from servogen.steps import reporting
from servogen.steps import simulate as simulating
from servogen.steps.prepare import prepare


class Result(Protocol):
    """See ``cli.Result``."""

    @property
    def passed(self) -> bool: ...

    def lines(self) -> list[str]: ...

    def to_json(self) -> Mapping[str, object]: ...


Kept = TypeVar("Kept", bound=Result)


def build(project: Project, out: Path, progress: Progress) -> building.BuildResult:
    """Emit the C package into ``out``."""
    return building.build(prepare(project, progress), out)


def sil(project: Project, steps: int | None, progress: Progress) -> proving.SilResult:
    """Prove the C equal to the reference."""
    return proving.equivalence(prepare(project, progress), steps, progress)


def wcet(project: Project, target: str | None, progress: Progress) -> counting.WcetResult:
    """Count the C and hold it to the target's budget."""
    return counting.count(prepare(project, progress), target)


def simulate(project: Project, reference: bool, progress: Progress) -> simulating.SimulateResult:
    """Process the whole path."""
    return simulating.simulate(prepare(project, progress), reference, progress)


def study(project: Project, progress: Progress) -> comparing.StudyResult:
    """The paper's Table I."""
    return comparing.compare(prepare(project, progress), progress)


def check(project: Project, name: str, out: Path, progress: Progress) -> checking.CheckResult:
    """One piece of evidence, kept in ``out``."""
    return checking.check(prepare(project, progress), name, out, progress)


def report(project: Project, out: Path, progress: Progress) -> reporting.ReportResult:
    """The report of everything that can be computed without being asked: all but the study."""
    prepared = prepare(project, progress)
    found = reporting.Findings(
        prepared=prepared,
        simulated=simulating.simulate(prepared, False, progress),
        wcet=counting.count(prepared, None),
    )
    return reporting.report(found, out)


@dataclass(frozen=True)
class RunResult:
    """All steps, in order, with their JSON beside the C."""

    steps: dict[str, Result]

    @property
    def passed(self) -> bool:
        return all(step.passed for step in self.steps.values())

    def lines(self) -> list[str]:
        failed = [name for name, step in self.steps.items() if not step.passed]
        verdict = f"FAILED: {', '.join(failed)}" if failed else "all checks passed"
        return [*(line for s in self.steps.values() for line in s.lines()), f"run       {verdict}"]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": "servogen.run/1",
            "passed": self.passed,
            "steps": {name: step.to_json() for name, step in self.steps.items()},
        }


def run(project: Project, out: Path, progress: Progress) -> RunResult:
    """Build, sil, wcet, simulate, study, report; the results as JSON beside them."""
    prepared = prepare(project, progress)
    steps: dict[str, Result] = {}

    def keep(name: str, step: Kept) -> Kept:
        """Written at once: what comes later may fail."""
        steps[name] = step
        write_file(out / f"{name}.json", json_text(step.to_json()))
        return step

    keep("build", building.build(prepared, out / "c"))
    proven = keep("sil", proving.equivalence(prepared, None, progress))
    counted = keep("wcet", counting.count(prepared, None))
    simulated = keep("simulate", simulating.simulate(prepared, False, progress))
    studied = keep("study", comparing.compare(prepared, progress))
    found = reporting.Findings(prepared, simulated, counted, proven, studied)
    keep("report", reporting.report(found, out / "report.html"))
    return RunResult(steps)
