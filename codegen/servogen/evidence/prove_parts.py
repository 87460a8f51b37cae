"""What a proof by parts asks of the C beyond what Eva sees: nobody else touches a part's state, and
what is analysed is what is compiled."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from servogen.controllers.design import Declaration
from servogen.emit.driver import contract_header
from servogen.emit.package import CPackage
from servogen.evidence.tools import run_tool

# Whatever could tell the analyser's C from the compiler's.
_ANALYSER = re.compile(r"__FRAMAC__|__FC_|SG_EVA|SG_GIVEN|SG_BEGUN")
# The one switch that the C has: it is analysed without. Files that may know it.
_SWITCH, _SWITCHED = "SG_OWN_DIVISION", ("sg_quotient.h", "sg_division.h")
# Ways round the types, in what is left of a file without its comments.
_ROUND = re.compile(
    r"\(\s*(?:const\s+)?(?:struct\s+)?\w+\s*\*[\s*]*(?:const\s*)?\)|\bvoid\s*\*|\bunion\b"
)
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_LINES = 3


@dataclass(frozen=True)
class Job:
    """One run: a controller on the contracts of the parts it calls, for one kind of inputs."""

    package: CPackage
    declaration: Declaration
    inputs: str

    @property
    def precision(self) -> str:
        return self.declaration.precision.name


def other_texts(package: CPackage) -> list[str]:
    """Files of the firmware that mention the analyser, or the switch where it is not known."""
    faults = []
    for file, text in package.code.items():
        if found := _ANALYSER.search(text):
            faults.append(f"{file} knows of the proof: {found[0]}")
        if _SWITCH in text and file not in _SWITCHED:
            faults.append(f"{file} depends on {_SWITCH}, with which it is not analysed")
    return faults


def meddling(job: Job, folder: Path) -> list[str]:
    """Where a controller touches the state of a part otherwise than by reading a member that its
    contract gives: the proof of the part knows the part's own calls only.

    The controller is compiled on the contracts' headers, in which the state has those members only,
    and they are constant. What types could not stop (a pointer cast, a pointer to void, a union) is
    not allowed in it.
    """
    d = job.declaration
    if not d.uses:
        return []
    own = f"{d.prefix}.c"
    text = _COMMENT.sub("", job.package.files[own])
    faults = [f"{own}: a way round the types: {found[0]}" for found in _ROUND.finditer(text)]
    includes = [*(contract_header(prefix) for prefix in d.uses), own]
    unit = folder / f"{d.prefix}_{job.inputs}_on_contracts.c"
    unit.write_text("".join(f'#include "{file}"\n' for file in includes), encoding="utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wcast-qual", "-Werror", "-DSG_GIVEN=const", "-I."]
    done = run_tool(["gcc", *flags, "-fsyntax-only", unit.name], folder)
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if "error:" in line]
        faults += [
            f"touches the state of a part: {line}" for line in said[:_LINES] or ["gcc fails"]
        ]
    return faults
