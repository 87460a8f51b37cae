"""The verbs in their order. Every step returns a result with ``passed``, ``lines()`` and
``to_json()``; the command line prints the lines and sets its status."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from servogen.evidence.certificate import MEASURED, NOT_RUN, Certificate
from servogen.evidence.finding import FOLDER
from servogen.evidence.finding import keep as keep_finding
from servogen.jsontext import json_text
from servogen.outputs import write_file
from servogen.progress import Progress
from servogen.project.systems import AnyProject
from servogen.steps import build as building
from servogen.steps import check as checking
from servogen.steps import count as counting
from servogen.steps import equivalence as proving
from servogen.steps import findings as finding
from servogen.steps import reporting
from servogen.steps.prepare import prepare
from servogen.steps.system import Findings, Result, Simulation

Kept = TypeVar("Kept", bound=Result)


def build(project: AnyProject, out: Path, progress: Progress) -> building.BuildResult:
    """Emit the C package into ``out``."""
    return building.build(prepare(project, progress), out)


def sil(project: AnyProject, steps: int | None, progress: Progress) -> proving.SilResult:
    """Prove the C equal to the reference."""
    return proving.equivalence(prepare(project, progress), steps, progress)


def wcet(
    project: AnyProject, target: str | None, all_targets: bool, progress: Progress
) -> counting.WcetResult:
    """Count the C and hold it to the target's budget."""
    return counting.count(prepare(project, progress), target, all_targets)


def simulate(project: AnyProject, reference: bool, progress: Progress) -> Simulation:
    """The whole of the project's own task."""
    prepared = prepare(project, progress)
    package = None if reference else prepared.package
    result: Simulation = prepared.system.simulate(package, progress)
    return result


def study(project: AnyProject, progress: Progress) -> Result:
    """The paper's comparison."""
    result: Result = prepare(project, progress).system.study(progress)
    return result


def check(project: AnyProject, name: str, out: Path, progress: Progress) -> checking.CheckResult:
    """One piece of evidence, kept in ``out``."""
    return checking.check(prepare(project, progress), name, out, progress)


def certificate(project: AnyProject, out: Path, progress: Progress) -> Certificate:
    """What is kept in ``out`` about this build, as one certificate."""
    return checking.certify(prepare(project, progress), out)


def report(project: AnyProject, out: Path, progress: Progress) -> reporting.ReportResult:
    """The report of everything that can be computed without being asked (all but the study), and
    of the evidence kept beside ``out``."""
    prepared = prepare(project, progress)
    evidence = (out.parent / FOLDER).is_dir()
    system = prepared.system
    found: Findings[Any, Any] = Findings(
        simulated=system.simulate(prepared.package, progress),
        build=building.BuildResult(prepared.package, out, system.figures, system.notes).to_json(),
        wcet=counting.survey(prepared).to_json(),
        certificate=checking.certify(prepared, out.parent) if evidence else None,
    )
    return reporting.report(system, found, out)


@dataclass(frozen=True)
class RunResult:
    """All steps, in order, with their JSON beside the C."""

    steps: dict[str, Result]
    certificate: Certificate | None = None

    @property
    def passed(self) -> bool:
        return all(step.passed for step in self.steps.values())

    def lines(self) -> list[str]:
        failed = [name for name, step in self.steps.items() if not step.passed]
        verdict = f"FAILED: {', '.join(failed)}" if failed else "all checks passed"
        missing = [e.name for e in self.certificate.having(NOT_RUN)] if self.certificate else []
        if missing:
            verdict += f"; not run: {', '.join(missing)} (servogen check list)"
        measured = self.certificate.having(MEASURED) if self.certificate else []
        if measured:
            verdict += f"; measured, not proved: {', '.join(e.name for e in measured)}"
        return [*(line for s in self.steps.values() for line in s.lines()), f"run       {verdict}"]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": "servogen.run/1",
            "passed": self.passed,
            "steps": {name: step.to_json() for name, step in self.steps.items()},
        }


def run(project: AnyProject, out: Path, progress: Progress) -> RunResult:
    """Build, proofs, sil, wcet, simulate, study, certificate, report; the results as JSON beside
    them, and as evidence about the C that was built."""
    prepared = prepare(project, progress)
    system = prepared.system
    bench = checking.bench_of(prepared)
    origin = checking.origin_of(project)
    steps: dict[str, Result] = {}

    def keep(name: str, step: Kept) -> Kept:
        """Written at once: what comes later may fail."""
        steps[name] = step
        write_file(out / f"{name}.json", json_text(step.to_json()))
        return step

    made = keep("build", building.build(prepared, out / "c"))
    for proof in system.proofs:
        what = finding.proof_finding(proof, bench, progress)
        steps[proof.name] = checking.CheckResult(what)
        keep_finding(what, out, origin)
    proven = keep("sil", proving.equivalence(prepared, None, progress))
    keep_finding(finding.sil_finding(proven, bench), out, origin)
    counted = keep("wcet", counting.survey(prepared))
    keep_finding(finding.wcet_finding(counted, bench), out, origin)
    simulated = keep("simulate", system.simulate(prepared.package, progress))
    keep_finding(finding.simulate_finding(simulated, bench), out, origin)
    studied = keep("study", system.study(progress))
    steps["evidence"] = certified = checking.certify(prepared, out)
    shown = Findings(
        simulated, made.to_json(), counted.to_json(), proven.to_json(), studied, certified
    )
    keep("report", reporting.report(system, shown, out / "report.html"))
    return RunResult(steps, certified)
