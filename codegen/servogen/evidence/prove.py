"""Absence of run-time errors by Frama-C Eva, for every controller and every input."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from servogen.evidence.bench import Bench
from servogen.evidence.children import in_order
from servogen.evidence.finding import Finding
from servogen.evidence.prove_bounds import judge_bounds
from servogen.evidence.prove_parts import Job
from servogen.evidence.prove_read import Proof
from servogen.evidence.prove_run import INPUTS, MACHINE, OPTIONS, prove
from servogen.evidence.tools import find_tool, version_of
from servogen.progress import Progress

REMEDY = "apt-get install frama-c-base"


def run(bench: Bench, progress: Progress) -> Finding:
    """See ``evidence.catalogue``.

    Raises:
        ToolMissing: no Frama-C or no gcc.
    """
    find_tool("frama-c", REMEDY)
    find_tool("gcc", "apt-get install gcc")
    jobs = jobs_of(bench)
    with (
        tempfile.TemporaryDirectory(prefix="servogen-prove-") as scratch,
        progress.task("Proving", total=len(jobs)) as task,
    ):
        for subject in bench.subjects:
            subject.write(Path(scratch, subject.precision.name))

        def one(job: Job) -> Proof:
            return prove(job, Path(scratch, job.precision))

        proofs = []
        for proof in in_order(one, jobs, workers=os.cpu_count() or 1):
            proofs.append(proof)
            task.advance()
        bounds = {
            subject.precision.name: judge_bounds(subject, Path(scratch, f"bounds{number}"))
            for number, subject in enumerate(bench.subjects)
        }
    return judge(bench, jobs, proofs, bounds)


def jobs_of(bench: Bench) -> list[Job]:
    """Every controller of every package with every kind of inputs."""
    return [
        Job(subject.package, declaration, inputs)
        for subject in bench.subjects
        for declaration in subject.package.declarations
        for inputs in INPUTS
    ]


def judge(
    bench: Bench,
    jobs: list[Job],
    proofs: list[Proof],
    bounds: Mapping[str, tuple[dict[str, object], list[str]]],
) -> Finding:
    """One finding from all runs; ``bounds``: what ``judge_bounds`` found, by precision."""
    figures: dict[str, dict[str, dict[str, object]]] = {}
    faults: list[str] = []
    for job, proof in zip(jobs, proofs, strict=True):
        prefix = job.declaration.prefix
        own = figures.setdefault(job.precision, {}).setdefault(prefix, {})
        own[job.inputs] = proof.to_json()
        faults += [f"{job.precision}: {prefix}, {job.inputs} inputs: {f}" for f in proof.faults]
    for name, (_, wrong) in bounds.items():
        faults += [f"{name}: {fault}" for fault in wrong]
    if not jobs:
        faults.append("there was nothing to prove")
    alarms = sum(sum(proof.alarms.values()) for proof in proofs)
    proven = sum(proof.proven for proof in proofs)
    return Finding(
        check="prove",
        passed=not faults,
        summary=f"{alarms} alarms in {len(jobs)} runs of {len(jobs) // len(INPUTS)} controllers, "
        f"{proven} properties shown",
        tools={"frama-c": version_of(["frama-c", "-version"])},
        subjects=bench.digests,
        figures={
            "machine": MACHINE,
            "options": list(OPTIONS),
            "bounds": {name: found for name, (found, _) in bounds.items()},
            "controllers": figures,
        },
        faults=tuple(faults),
    )
