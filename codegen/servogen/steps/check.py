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
from servogen.errors import InputError
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.catalogue import CHECKS
from servogen.evidence.certificate import FILE, Certificate, Wanted, entry_of, strangers_in
from servogen.evidence.finding import Finding, Origin, keep
from servogen.jsontext import json_text
from servogen.outputs import write_file
from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.progress import Progress
from servogen.project.systems import AnyProject
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.player import Play
from servogen.sil.recorder import Recorder
from servogen.steps.findings import OF_ONE_PRECISION, STEPS, step_finding, step_titles
from servogen.steps.prepare import Prepared
from servogen.steps.system import Simulated, Studied, System
from servogen.wcet.targets import target_file

SEED = 20260
_OUTSIDE = {check.name: check.title for check in CHECKS.values()}


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


def check(
    prepared: Prepared[Simulated, Studied], name: str, out: Path, progress: Progress
) -> CheckResult:
    """Run the check and keep its finding in ``out``.

    Raises:
        ToolMissing: the check cannot run here; nothing is written.
        InputError: a proof of another system.
    """
    known = titles_of(prepared.system)
    if name not in known:
        raise InputError(None, "CHECK", name, f"one of {', '.join(known)} for this system")
    bench = bench_of(prepared)
    if name in CHECKS:
        finding = CHECKS[name].run(bench, progress)
    else:
        finding = step_finding(prepared, name, bench, progress)
    keep(finding, out, origin_of(prepared.project))
    return CheckResult(finding)


def titles() -> dict[str, str]:
    """Every check there is, of whatever system, name -> title."""
    return step_titles() | _OUTSIDE


def titles_of(system: System[Simulated, Studied]) -> dict[str, str]:
    """The checks of one system, name -> title, in the order of the certificate."""
    return {proof.name: proof.title for proof in system.proofs} | STEPS | _OUTSIDE


def certify(prepared: Prepared[Simulated, Studied], out: Path) -> Certificate:
    """Gather what is kept in ``out`` about the C of this project into ``certificate.json``."""
    project = prepared.project
    digests, origin = bench_of(prepared).digests, origin_of(project)
    own = prepared.precision.name
    wanted = [
        Wanted(
            name,
            title,
            f"check {name} {project.file.name} -o {out.name}",
            (own,) if name in OF_ONE_PRECISION else tuple(digests),
        )
        for name, title in titles_of(prepared.system).items()
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


def bench_of(prepared: Prepared[Simulated, Studied]) -> Bench:
    """The project's packages in both precisions, its own first."""
    order = sorted((FLOAT64, FLOAT32), key=lambda p: p is not prepared.precision)
    return Bench(prepared.project.name, tuple(_subject(prepared, precision) for precision in order))


def _subject(prepared: Prepared[Simulated, Studied], precision: Precision) -> Subject:
    return Subject(
        package=prepared.package_in(precision),
        precision=precision,
        counts=prepared.counts_in(precision),
        suite=lambda count: _suite(prepared.system, precision, count),
        closed_loops=_closed_loops(prepared, precision),
    )


def _suite(system: System[Simulated, Studied], precision: Precision, count: int) -> list[Play]:
    return [
        Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
        for case in system.scenarios(precision, SEED, count)
    ]


def _closed_loops(
    prepared: Prepared[Simulated, Studied], precision: Precision
) -> Callable[[int | None], list[Play]]:
    """The C drives the plant: the same bits as the reference in a hundredth of the time."""

    def record(periods: int | None) -> list[Play]:
        package, plays = prepared.package_in(precision), []
        declarations = {d.prefix: d for d in package.declarations}
        with built(package) as module:
            for loop in prepared.system.loops(precision):
                recorder = Recorder(CompiledController(module, declarations[loop.prefix]))
                loop.run(recorder, periods, lambda: None)
                plays.append(recorder.play(loop.name))
        return plays

    return record


def origin_of(project: AnyProject) -> Origin:
    """Digest of the project's files, its target and the checks' lists, names and folders aside; the
    day on which the newest of the project's files was modified (UTC), or ``SOURCE_DATE_EPOCH``."""
    target = target_file(project.target.name, project.file.parent)
    lists = sorted(Path(evidence.__file__).parent.glob("*.toml"))
    digest = hashlib.sha256()
    for file in (*project.sources, target, *lists):
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    chosen = os.environ.get("SOURCE_DATE_EPOCH", "")
    newest = int(chosen) if chosen.isdigit() else max(f.stat().st_mtime for f in project.sources)
    return Origin(digest.hexdigest(), datetime.fromtimestamp(newest, UTC).date().isoformat())
