"""``servogen check``: one piece of evidence about the emitted C, kept beside it."""

from __future__ import annotations

import hashlib
import os
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from servogen import __version__, evidence
from servogen.controllers.cascade_design import CascadeDesign
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.catalogue import CHECKS
from servogen.evidence.certificate import FILE, Certificate, Wanted, entry_of, strangers_in
from servogen.evidence.finding import Finding, Origin, keep
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
from servogen.steps.findings import OF_ONE_PRECISION, STEPS, step_finding
from servogen.steps.prepare import Prepared
from servogen.systems.closed_loop import run_closed_loop
from servogen.wcet.targets import target_file

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
        first = f"{f.check:<9} {f.line}{'' if f.passed else ', FAILED'}"
        return [first, *(f"          {line}" for line in (*f.faults, *f.all_details))]

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
    keep(finding, out, origin_of(prepared.machine.project))
    return CheckResult(finding)


def titles() -> dict[str, str]:
    """Every check there is, name -> title, in the order of the certificate."""
    return STEPS | {check.name: check.title for check in CHECKS.values()}


def certify(prepared: Prepared, out: Path) -> Certificate:
    """Gather what is kept in ``out`` about the C of this project into ``certificate.json``."""
    project = prepared.machine.project
    digests, origin = bench_of(prepared).digests, origin_of(project)
    own = prepared.machine.precision.name
    wanted = [
        Wanted(
            name,
            title,
            f"check {name} {project.file.name} -o {out.name}",
            (own,) if name in OF_ONE_PRECISION else tuple(digests),
        )
        for name, title in titles().items()
    ]
    certificate = Certificate(
        project=project.name,
        version=__version__,
        design_hash=prepared.package.hash,
        precision=own,
        digests=digests,
        origin=origin,
        entries=tuple(entry_of(one, out, digests, origin) for one in wanted),
        strangers=strangers_in(prepared.package.files, out),
        arguments=shlex.join([str(project.file), "-o", str(out)]),
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


def origin_of(project: Project) -> Origin:
    """Digest of the project's files, its target and the checks' lists, names and folders aside; the
    day on which the newest of the project's files was modified (UTC), or ``SOURCE_DATE_EPOCH``."""
    stages = [stage for _, axis in project.machine.axes for stage in (axis.slow, axis.fast)]
    models = [Path(stage.file) for stage in stages if stage.model == "python"]
    files = [project.file, Path(project.path.file), *models]
    target = target_file(project.target.name, project.file.parent)
    lists = sorted(Path(evidence.__file__).parent.glob("*.toml"))
    digest = hashlib.sha256()
    for file in (*files, target, *lists):
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    chosen = os.environ.get("SOURCE_DATE_EPOCH", "")
    newest = int(chosen) if chosen.isdigit() else max(f.stat().st_mtime for f in files)
    return Origin(digest.hexdigest(), datetime.fromtimestamp(newest, UTC).date().isoformat())
