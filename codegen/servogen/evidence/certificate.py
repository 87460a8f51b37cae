"""One certificate per build: what was shown about it, with what, and what was not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from servogen.errors import InputError
from servogen.evidence.finding import FOLDER, Origin, kept

SCHEMA = "servogen.certificate/1"
FILE = "certificate.json"
C_FOLDER = "c"  # of the C, beside it
PASSED, FAILED, NOT_RUN, NOT_APPLICABLE = "passed", "failed", "not run", "does not apply"
# What was asked for was not proved, only measured: it has not failed and counts for no proof.
MEASURED = "measured"


@dataclass(frozen=True)
class Wanted:
    """A check that the certificate asks for, and the command that runs it.

    ``precisions``: those whose C it has to be about.
    """

    name: str
    title: str
    command: str
    precisions: tuple[str, ...]


@dataclass(frozen=True)
class Entry:
    """One check on the certificate.

    Attributes:
        state: ``PASSED``, ``FAILED``, ``NOT_RUN``, ``NOT_APPLICABLE`` or ``MEASURED``.
        summary: what was found, or why there is nothing.
        input_modified: ``Origin.modified`` when it ran; empty if it did not.
    """

    name: str
    title: str
    state: str
    summary: str
    command: str
    tools: Mapping[str, str] = field(default_factory=dict)
    input_modified: str = ""
    faults: tuple[str, ...] = ()
    details: tuple[str, ...] = ()
    figures: Mapping[str, Any] = field(default_factory=dict)
    precisions: tuple[str, ...] = ()

    def to_json(self) -> dict[str, object]:
        return {
            "name": self.name,
            "title": self.title,
            "result": self.state,
            "summary": self.summary,
            "command": self.command,
            "tools": dict(self.tools),
            "input_modified": self.input_modified or None,
            "precisions": list(self.precisions),
            "faults": list(self.faults),
            "details": list(self.details),
            "figures": dict(self.figures),
        }


@dataclass(frozen=True)
class Certificate:
    """All entries about the C with these digests (precision -> sha-256 of its files).

    ``precision``: the one that is shipped; ``origin``: the input as it is now; ``strangers``: files
    in the folder beside it that are not those of this build, see ``strangers_in``; ``arguments``:
    those of the commands where this was called, the entries' have no folders.
    """

    project: str
    version: str
    design_hash: str
    precision: str
    digests: Mapping[str, str]
    origin: Origin
    entries: tuple[Entry, ...]
    strangers: tuple[str, ...] = ()
    arguments: str = ""

    def having(self, state: str) -> list[Entry]:
        return [entry for entry in self.entries if entry.state == state]

    @property
    def result(self) -> str:
        """``failed`` if any check did, ``passed`` if all that apply did, else ``incomplete``."""
        if self.having(FAILED) or self.strangers:
            return FAILED
        if self.having(NOT_RUN) or not self.having(PASSED):
            return "incomplete"
        return PASSED

    @property
    def passed(self) -> bool:
        """No check failed; one that was not run has not failed, and ``result`` says so."""
        return self.result != FAILED

    def lines(self) -> list[str]:
        counted = ", ".join(
            f"{len(self.having(state))} {state}"
            for state in (PASSED, MEASURED, FAILED, NOT_RUN, NOT_APPLICABLE)
            if self.having(state)
        )
        lines = [f"evidence  {self.result}: {counted}"]
        for entry in self.entries:
            command = f"check {entry.name} {self.arguments}" if self.arguments else entry.command
            told = f"servogen {command}" if entry.state == NOT_RUN else entry.summary
            why = f"{entry.summary}; " if entry.state == NOT_RUN and entry.summary else ""
            lines.append(f"          {entry.name:<11} {entry.state:<9} {why}{told}")
        if self.strangers:
            names = ", ".join(self.strangers)
            lines.append(f"          {C_FOLDER}/ is not what this certificate is about: {names}")
        return lines

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "result": self.result,
            "project": self.project,
            "servogen": self.version,
            "design_hash": self.design_hash,
            "precision": self.precision,
            "c_sha256": dict(self.digests),
            "input_sha256": self.origin.digest,
            "input_modified": self.origin.modified,
            "other_files": list(self.strangers),
            "checks": [entry.to_json() for entry in self.entries],
        }


def strangers_in(files: Mapping[str, str], out: Path) -> tuple[str, ...]:
    """Names of files in ``out``'s folder of C that differ from ``files``, the build's, or that only
    one of the two has; none if there is no such folder."""
    folder = out / C_FOLDER
    if not folder.is_dir():
        return ()
    there = {p.relative_to(folder).as_posix(): p for p in folder.rglob("*") if p.is_file()}
    same = {
        name for name in files.keys() & there.keys()
        if there[name].read_bytes() == files[name].encode()
    }  # fmt: skip
    return tuple(sorted((files.keys() | there.keys()) - same))


def entry_of(wanted: Wanted, out: Path, digests: Mapping[str, str], origin: Origin) -> Entry:
    """The entry that the finding kept in ``out`` supports, for the C with these digests.

    A finding about other C, about one precision less than wanted, or from another input, is no
    evidence, nor is a file that is none: the check was not run.
    """
    try:
        found = kept(out, wanted.name)
    except InputError as error:
        told = f"{FOLDER}/{wanted.name}.json cannot be read, expected {error.expected}"
        return Entry(wanted.name, wanted.title, NOT_RUN, told, wanted.command)
    why = "" if found is None else _no_evidence(found, wanted, digests, origin)
    if found is None or why:
        return Entry(wanted.name, wanted.title, NOT_RUN, why, wanted.command)
    return Entry(
        name=wanted.name,
        title=wanted.title,
        state=_state(found),
        summary=str(found.get("summary", "")),
        command=wanted.command,
        tools={str(k): str(v) for k, v in dict(found.get("tools") or {}).items()},
        input_modified=str(found.get("input_modified", "")),
        faults=tuple(str(fault) for fault in found.get("faults") or ()),
        details=tuple(str(line) for line in found.get("details") or ()),
        precisions=wanted.precisions,
        figures=dict(found.get("figures") or {}),
    )


def _no_evidence(
    found: Mapping[str, Any], wanted: Wanted, digests: Mapping[str, str], origin: Origin
) -> str:
    """Why a finding says nothing about this build; empty if it does."""
    subjects = found.get("subjects")
    about = subjects if isinstance(subjects, Mapping) else {}
    if any(about.get(p) != digests[p] for p in wanted.precisions) or not wanted.precisions:
        return "the finding that was kept is about another build"
    if found.get("input_sha256") != origin.digest:
        return "the project, its drawing, its target or the checks' lists have changed since"
    return ""


def _state(found: Mapping[str, Any]) -> str:
    """What does not clearly say that it passed has failed."""
    if found.get("passed") is not True or found.get("faults"):
        return FAILED
    if found.get("measured", False) is not False:
        return MEASURED
    return PASSED if found.get("applies", True) is True else NOT_APPLICABLE
