"""``servogen check``: one piece of evidence about the emitted C, kept beside it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from servogen import __version__
from servogen.controllers.cascade_design import CascadeDesign
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.catalogue import CHECKS
from servogen.evidence.certificate import FILE, Certificate, Wanted, entry_of
from servogen.evidence.finding import Finding, keep
from servogen.jsontext import json_text
from servogen.outputs import write_file
from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.progress import Progress
from servogen.project import Project
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.player import Play
from servogen.sil.recorder import Recorder
from servogen.sil.scenarios import suite
from servogen.steps.findings import STEPS, step_finding
from servogen.steps.prepare import Prepared
from servogen.systems.closed_loop import run_closed_loop

SEED = 20260


@dataclass(frozen=True)
class CheckResult:
    """A finding as a step of the line."""

    finding: Finding

    @property
    def passed(self) -> bool:
        return self.finding.passed

    def lines(self) -> list[str]:
        f = self.finding
        first = f"{f.check:<9} {f.summary}{'' if f.passed else ', FAILED'}"
        return [first, *(f"          {line}" for line in (*f.faults, *f.details))]

    def to_json(self) -> dict[str, object]:
        return self.finding.to_json()


def check(prepared: Prepared, name: str, out: Path, progress: Progress) -> CheckResult:
    """Run the check and keep its finding in ``out``.

    Raises:
        ToolMissing: the check cannot run here; nothing is written.
    """
    bench = bench_of(prepared)
    if name in STEPS:
        finding = step_finding(prepared, name, bench, progress)
    else:
        finding = CHECKS[name].run(bench, progress)
    keep(finding, out, input_date(prepared.machine.project))
    return CheckResult(finding)


def titles() -> dict[str, str]:
    """Every check there is, name -> title, in the order of the certificate."""
    return STEPS | {check.name: check.title for check in CHECKS.values()}


def certify(prepared: Prepared, out: Path) -> Certificate:
    """Gather what is kept in ``out`` about the C of this project into ``certificate.json``."""
    project = prepared.machine.project
    digests = bench_of(prepared).digests
    wanted = [
        Wanted(name, title, f"check {name} {project.file.name} -o {out.name}")
        for name, title in titles().items()
    ]
    certificate = Certificate(
        project=project.name,
        version=__version__,
        design_hash=prepared.package.hash,
        precision=prepared.machine.precision.name,
        digests=digests,
        input_date=input_date(project),
        entries=tuple(entry_of(one, out, digests) for one in wanted),
    )
    write_file(out / FILE, json_text(certificate.to_json()))
    return certificate


def bench_of(prepared: Prepared) -> Bench:
    """The project's packages in both precisions, its own first."""
    own = prepared.machine.precision
    order = sorted((FLOAT64, FLOAT32), key=lambda p: p is not own)
    return Bench(
        prepared.machine.project.name, tuple(_subject(prepared, precision) for precision in order)
    )


def _subject(prepared: Prepared, precision: Precision) -> Subject:
    design = prepared.in_precision(precision)
    return Subject(
        package=prepared.package_in(precision),
        precision=precision,
        counts=prepared.counts_in(precision),
        suite=lambda count: _suite(design, count),
        closed_loop=_closed_loop(prepared, precision),
    )


def _suite(design: CascadeDesign, count: int) -> list[Play]:
    return [
        Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
        for case in suite(design, SEED, count)
    ]


def _closed_loop(prepared: Prepared, precision: Precision) -> Callable[[int | None], Play]:
    """The C drives the plant: the same bits as the reference in a hundredth of the time."""

    def record(periods: int | None) -> Play:
        package = prepared.package_in(precision)
        with built(package) as module:
            recorder = Recorder(CompiledController(module, package.declarations[-1]))
            run_closed_loop(prepared.machine, recorder, periods)
            return recorder.play("closed loop")

    return record


def input_date(project: Project) -> str:
    """Day of the newest file that the project is made of (UTC), or of ``SOURCE_DATE_EPOCH``."""
    chosen = os.environ.get("SOURCE_DATE_EPOCH", "")
    stages = [stage for _, axis in project.machine.axes for stage in (axis.slow, axis.fast)]
    models = [stage.file for stage in stages if stage.model == "python"]
    files = [project.file, project.path.file, *models]
    newest = int(chosen) if chosen.isdigit() else max(Path(f).stat().st_mtime for f in files)
    return datetime.fromtimestamp(newest, UTC).date().isoformat()
