"""The list of deviations from MISRA C:2012: read, matched with what a tool found, made a page.

``python -m servogen.evidence.misra_deviations docs/misra-deviations.md`` writes the page anew.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from servogen.errors import CheckFailed
from servogen.evidence.misra_run import Violation
from servogen.outputs import write_file

LIST = Path(__file__).with_suffix(".toml")
CATEGORIES = ("advisory", "required")
KINDS = ("deviation", "tool")
# No deviation is allowed from these, as of Amendment 3.
_MANDATORY = {9: (1, 7), 12: (5,), 13: (6,), 17: (3, 4, 6, 9), 18: (10,), 19: (1,)}
_MANDATORY |= {21: (13, 17, 18, 19, 20, 22), 22: (2, 4, 5, 6, 20)}
MANDATORY = frozenset(f"{chapter}.{n}" for chapter, rules in _MANDATORY.items() for n in rules)
BEGIN = "<!-- made by python -m servogen.evidence.misra_deviations, not edited by hand -->\n"
END = "<!-- end of the list -->\n"


@dataclass(frozen=True)
class Entry:
    """One line of the list; the keys are explained in the TOML file."""

    rule: str
    category: str
    kind: str
    files: tuple[str, ...]
    lines: str
    reason: str
    said_by: tuple[str, ...] = ()
    sometimes: bool = False

    @property
    def label(self) -> str:
        return f"rule {self.rule} in {', '.join(self.files)}"

    def covers(self, violation: Violation, template: str) -> bool:
        """Whether it is about this violation, in a file made from ``template``."""
        return (
            violation.rule == self.rule
            and self.concerns([template])
            and re.search(self.lines, violation.text) is not None
        )

    def concerns(self, templates: Sequence[str]) -> bool:
        return any(fnmatchcase(t, pattern) for t in templates for pattern in self.files)

    def expected_of(self, version: str) -> bool:
        """Whether a cppcheck of this version has to find something that the entry covers."""
        return not self.sometimes and (self.kind == "deviation" or version in self.said_by)


def load(text: str | None = None) -> tuple[Entry, ...]:
    """The list; ``text`` instead of the file's for tests.

    Raises:
        CheckFailed: an entry is incomplete, or is about a mandatory rule.
    """
    content = tomllib.loads(LIST.read_text(encoding="utf-8") if text is None else text)
    return tuple(_entry(raw) for raw in content["entry"])


def _entry(raw: Mapping[str, object]) -> Entry:
    try:
        entry = Entry(**{k: tuple(v) if isinstance(v, list) else v for k, v in raw.items()})  # type: ignore[arg-type]
    except TypeError as error:
        raise CheckFailed(f"{LIST.name}: {error}") from error
    if entry.rule in MANDATORY or entry.category not in CATEGORIES:
        raise CheckFailed(f"{LIST.name}: rule {entry.rule} cannot be deviated from")
    if entry.kind not in KINDS or not entry.reason.strip() or not entry.lines:
        raise CheckFailed(f"{LIST.name}: rule {entry.rule} lacks its kind, reason or lines")
    if (entry.kind == "tool") != bool(entry.said_by):
        raise CheckFailed(f"{LIST.name}: rule {entry.rule} wants said_by if and only if tool")
    return entry


def template_of(file: str, text: str) -> str:
    """The template that an emitted file says it is from; a runtime file's own name."""
    found = re.search(r"Made by servogen \S+ from (\S+)\.jinja", text)
    return found[1] if found else file


def page() -> str:
    """Markdown: a section for either kind."""
    own = [e for e in load() if e.kind == "deviation"]
    tool = [e for e in load() if e.kind == "tool"]
    return "\n".join(
        [
            "## Deviations\n",
            *(_section(e) for e in own),
            "## Misread by the tool\n",
            "The C keeps these rules. The versions named are known to say otherwise; it is",
            "accepted from any version: a line of C that is right stays right.\n",
            *(_section(e) for e in tool),
        ]
    )


def _section(entry: Entry) -> str:
    versions = f" Said by cppcheck {', '.join(entry.said_by)}." if entry.said_by else ""
    where = ", ".join(f"`{name}`" for name in entry.files)
    return (
        f"### Rule {entry.rule} ({entry.category})\n\n"
        f"In {where}, lines that match `{entry.lines}`.{versions}\n\n{entry.reason.strip()}\n"
    )


def updated(text: str) -> str:
    """A page with its list brought up to date.

    Raises:
        ValueError: the page lacks one of the marks that the list stands between.
    """
    head, rest = text.split(BEGIN)
    _, tail = rest.split(END)
    return f"{head}{BEGIN}\n{page()}\n{END}{tail}"


if __name__ == "__main__":
    place = Path(sys.argv[1])
    write_file(place, updated(place.read_text(encoding="utf-8")))
