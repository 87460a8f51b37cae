"""Frama-C Eva on one controller: the command, and the package's files it is given.

The proof is modular. Each controller is proven with all its own C, and with the contracts of the
controllers it calls in place of theirs: what a contract promises is claimed, and proven, of the
part in its own run, for inputs of the same kind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from servogen.controllers.design import Declaration, Status
from servogen.emit.driver import contract_file, driver_file
from servogen.evidence.prove_parts import Job, meddling, other_texts
from servogen.evidence.prove_read import Proof, read_proof
from servogen.evidence.tools import run_tool

# What the driver draws (SG_EVA_INPUTS) and what Eva then calls an alarm. With NaN and infinities
# among the inputs they may come up in comparisons; the driver asserts that none comes out.
INPUTS = {"finite": ("1", "non-finite"), "any": ("2", "none")}
MACHINE = "gcc_x86_64"
# The annotated splits go through calls; a warning that a split variable is not in scope yet, at the
# entry of a function, is about precision only. So is the rounding of a literal to the nearest.
OPTIONS = (
    "-no-unicode",
    "-eva",
    "-eva-no-print",
    "-eva-interprocedural-splits",
    "-warn-signed-downcast",
    "-warn-unsigned-overflow",
    "-kernel-warn-key=parser:decimal-float=inactive",
    "-metrics",
    "-metrics-eva-cover",
)


def command(job: Job, whole: str, report: str) -> list[str]:
    """Every loop is unrolled that Eva can bound by the largest of the package's dimensions: all but
    the solver's, which has more than one way out and is taken to its fixpoint."""
    largest = max(_sizes(job.declaration)) + 1
    which, special = INPUTS[job.inputs]
    return [
        "frama-c",
        *OPTIONS,
        f"-machdep={MACHINE}",
        f"-cpp-extra-args=-I. -DSG_EVA_INPUTS={which} -DSG_GIVEN=",
        f"-warn-special-float={special}",
        f"-eva-auto-loop-unroll={largest}",
        f"-eva-split-limit={max(largest, len(Status))}",
        whole,
        "-then",
        "-report",
        "-report-csv",
        report,
    ]


def whole_text(job: Job) -> str:
    """The contracts, the controller and its driver as one unit: the kernels are in it once, and
    what Eva keeps apart by a variable of a kernel is kept apart once. The contracts' headers come
    first and keep the parts' own out: their guards are the same."""
    files = [
        *(contract_file(prefix) for prefix in job.declaration.uses),
        f"{job.declaration.prefix}.c",
        driver_file(job.declaration.prefix),
    ]
    return "".join(f'#include "{file}"\n' for file in files)


def _sizes(declaration: Declaration) -> list[int]:
    """Lengths of all loops but the solver's."""
    ports = [port.size for op in declaration.operations for port in op.inputs + op.outputs]
    return [*(dim.value for dim in declaration.dimensions), *ports]


def prove(job: Job, folder: Path) -> Proof:
    """Run Eva in ``folder``, which holds the package, and read what it says."""
    name = f"{job.declaration.prefix}_{job.inputs}"
    whole, path = folder / f"{name}.c", folder / f"{name}.csv"
    whole.write_text(whole_text(job), encoding="utf-8")
    done = run_tool(command(job, whole.name, path.name), folder)
    table = path.read_text(encoding="utf-8") if path.is_file() else ""
    proof = read_proof(done.returncode, done.stdout + done.stderr, table, job.declaration)
    broken = [*other_texts(job.package), *meddling(job, folder)]
    return replace(proof, faults=(*broken, *proof.faults))
