"""What a check found, and how it is kept beside the C it is about."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from servogen.errors import InputError
from servogen.jsontext import json_text
from servogen.outputs import write_file

SCHEMA = "servogen.evidence/1"
FOLDER = "evidence"
# What of a finding is a table, and what a list.
_SHAPE: dict[type, tuple[str, ...]] = {
    dict: ("tools", "subjects", "figures"),
    list: ("faults", "details", "not_run"),
}


@dataclass(frozen=True)
class Finding:
    """The result of one check that ran. A check that did not run has none.

    Attributes:
        check: its name in ``evidence.catalogue``.
        passed: nothing was found wrong.
        summary: one line for people, with the figures that matter.
        tools: name -> version of every outside tool that took part.
        subjects: precision -> digest of the C that was looked at (``bench.Subject.digest``).
        figures: what was measured, plain JSON values.
        faults: one sentence for each thing that is wrong; not empty if ``passed`` is False.
        details: further lines for people.
        applies: False where the design has nothing that the check could be about.
        measured: what was asked for was not proved, only measured; the certificate counts it apart.
        not_run: parts of the check that were left out here, each ``its name: why``; the names stand
            in the one line, wherever it is shown.
    """

    check: str
    passed: bool
    summary: str
    tools: Mapping[str, str]
    subjects: Mapping[str, str]
    figures: Mapping[str, Any] = field(default_factory=dict)
    faults: tuple[str, ...] = ()
    details: tuple[str, ...] = ()
    applies: bool = True
    measured: bool = False
    not_run: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """The summary, with what was not run."""
        names = "; ".join(dict.fromkeys(text.partition(":")[0] for text in self.not_run))
        return f"{self.summary}; not run: {names}" if names else self.summary

    @property
    def all_details(self) -> tuple[str, ...]:
        return (*self.details, *(f"not run: {text}" for text in self.not_run))

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "check": self.check,
            "passed": self.passed,
            "applies": self.applies,
            **({"measured": True} if self.measured else {}),
            "summary": self.line,
            "tools": dict(self.tools),
            "subjects": dict(self.subjects),
            "figures": dict(self.figures),
            "faults": list(self.faults),
            "details": list(self.all_details),
            "not_run": list(self.not_run),
        }


def evidence_file(out: Path, check: str) -> Path:
    """Where a check's finding is kept in a project's output folder."""
    return out / FOLDER / f"{check}.json"


@dataclass(frozen=True)
class Origin:
    """What a finding came from besides the C: a limit, a target or a drawing may change and the C
    stay the same.

    Attributes:
        digest: sha-256 of the project's files, of its target and of the checks' own lists.
        modified: day on which the newest of the project's files was modified, as its file system
            says: a copy or a clone has the day of copying. The digest is what names the input.
    """

    digest: str
    modified: str


def keep(finding: Finding, out: Path, origin: Origin) -> None:
    """Write the finding, with the input it is about."""
    data = {**finding.to_json(), "input_sha256": origin.digest, "input_modified": origin.modified}
    write_file(evidence_file(out, finding.check), json_text(data))


def kept(out: Path, check: str) -> dict[str, Any] | None:
    """The finding as it was written; None if the check never ran for this folder.

    Raises:
        InputError: the file is not one of these.
    """
    path = evidence_file(out, check)
    if not path.is_file():
        return None
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(path, "file", None, f"JSON of the form {SCHEMA} ({error})") from error
    if not isinstance(data, dict) or data.get("schema") != SCHEMA or data.get("check") != check:
        raise InputError(path, "schema", None, f"{SCHEMA} of the check {check}")
    for kind, keys in _SHAPE.items():
        for key in keys:
            if not isinstance(data.get(key), kind | None):
                raise InputError(path, key, None, f"a finding of the form {SCHEMA}")
    return data
