"""Frama-C Eva on one controller: the command, and the package's files it is given."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from servogen.controllers.design import Declaration
from servogen.emit.driver import driver_file, with_parts
from servogen.emit.package import CPackage
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


@dataclass(frozen=True)
class Job:
    """One run: a controller with the parts it calls, for one kind of inputs."""

    package: CPackage
    declaration: Declaration
    inputs: str
    machine: str = MACHINE

    @property
    def precision(self) -> str:
        return self.declaration.precision.name


def command(job: Job, whole: str, report: str) -> list[str]:
    """Every loop is unrolled that Eva can bound by the largest of the package's dimensions: all but
    the solver's, which has more than one way out and is taken to its fixpoint."""
    parts = with_parts(job.declaration, job.package.declarations)
    largest = max(dim.value for d in parts for dim in d.dimensions) + 1
    which, special = INPUTS[job.inputs]
    return [
        "frama-c",
        *OPTIONS,
        f"-machdep={job.machine}",
        f"-cpp-extra-args=-I. -DSG_EVA_INPUTS={which}",
        f"-warn-special-float={special}",
        f"-eva-auto-loop-unroll={largest}",
        f"-eva-split-limit={largest}",
        whole,
        "-then",
        "-report",
        "-report-csv",
        report,
    ]


def whole_text(job: Job) -> str:
    """The driver, the controller and its parts as one unit: the kernels are in it once, and what
    Eva keeps apart by a variable of a kernel is kept apart once, not for each part anew."""
    parts = with_parts(job.declaration, job.package.declarations)
    files = [*(f"{d.prefix}.c" for d in parts), driver_file(job.declaration.prefix)]
    return "".join(f'#include "{file}"\n' for file in files)


def prove(job: Job, folder: Path) -> Proof:
    """Run Eva in ``folder``, which holds the package, and read what it says."""
    name = f"{job.declaration.prefix}_{job.inputs}_{job.machine}"
    whole, path = folder / f"{name}.c", folder / f"{name}.csv"
    whole.write_text(whole_text(job), encoding="utf-8")
    done = run_tool(command(job, whole.name, path.name), folder)
    table = path.read_text(encoding="utf-8") if path.is_file() else ""
    return read_proof(done.returncode, done.stdout + done.stderr, table, job.declaration)
