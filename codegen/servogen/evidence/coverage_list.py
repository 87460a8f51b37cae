"""The reviewed list of branches that need not be reached, each with its reason."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.errors import InputError
from servogen.evidence.coverage_decisions import Decision

LIST = Path(__file__).with_name("unreached.toml")
_KEYS = {"where", "function", "condition", "way", "reason"}
_MINIMUM_REASON = 40  # characters: a word is no argument


@dataclass(frozen=True, order=True)
class Branch:
    """One way out of a decision."""

    decision: Decision
    way: bool

    def __str__(self) -> str:
        d = self.decision
        again = f" (number {d.occurrence})" if d.occurrence > 1 else ""
        return f"{d.function}: {d.condition}{again} is never {'true' if self.way else 'false'}"


@dataclass(frozen=True, order=True)
class Placed:
    """A branch in one of the package's files."""

    file: str
    branch: Branch

    def __str__(self) -> str:
        return f"{self.file}: {self.branch}"


@dataclass(frozen=True)
class Entry:
    """A branch of the list and why it is on it.

    ``only_with``: kinds of controllers; the entry holds in packages that have one. Empty: in all.
    """

    branch: Branch
    reason: str
    only_with: tuple[str, ...] = ()


def reviewed(path: Path = LIST) -> tuple[Entry, ...]:
    """All entries of the list.

    Raises:
        InputError: an entry lacks a key, has one too many, has no argument or is there twice.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise InputError(path, "file", None, f"a readable TOML file ({error})") from error
    entries = [e for i, table in enumerate(data.get("branch", [])) for e in _read(path, i, table)]
    seen: dict[Branch, set[str]] = {}
    for entry in entries:
        before, kinds = seen.get(entry.branch), set(entry.only_with)
        if before is not None and (not before or not kinds or before & kinds):
            expected = "every branch once, or once for each kind of controller"
            raise InputError(path, str(entry.branch), None, expected)
        seen[entry.branch] = kinds | (before or set())
    return tuple(entries)


def _read(path: Path, index: int, table: dict[str, object]) -> list[Entry]:
    key = f"branch {index + 1}"
    if not _KEYS <= table.keys() <= _KEYS | {"occurrence", "only_with"}:
        raise InputError(path, key, sorted(table), f"the keys {sorted(_KEYS)}")
    way, reason, occurrence = table["way"], str(table["reason"]), table.get("occurrence", 1)
    if way not in ("true", "false", "both"):
        raise InputError(path, f"{key}.way", way, "true, false or both")
    if not isinstance(occurrence, int) or occurrence < 1:
        raise InputError(path, f"{key}.occurrence", occurrence, "a number from 1 on")
    if len(reason) < _MINIMUM_REASON:
        raise InputError(path, f"{key}.reason", reason, "an argument")
    ways = {"true": (True,), "false": (False,), "both": (False, True)}[str(way)]
    condition, only_with = str(table["condition"]), tuple(_several(table.get("only_with", [])))
    return [
        Entry(Branch(Decision(where, function, condition, occurrence), w), reason, only_with)
        for where in _several(table["where"])
        for function in _several(table["function"])
        for w in ways
    ]


def _several(value: object) -> list[str]:
    return [str(item) for item in value] if isinstance(value, list) else [str(value)]


@dataclass(frozen=True)
class Compared:
    """The branches of a package beside the list.

    Attributes:
        justified: not reached, and listed.
        unlisted: not reached, and not listed: faults.
        unneeded: listed, yet reached wherever this package has it.
    """

    justified: tuple[tuple[Placed, Entry], ...]
    unlisted: tuple[Placed, ...]
    unneeded: tuple[Entry, ...]


def compare(reached: set[Placed], unreached: set[Placed], entries: Sequence[Entry]) -> Compared:
    """Hold what was reached and what was not against the list."""
    listed = {entry.branch: entry for entry in entries}
    missing = {place.branch for place in unreached}
    there = {place.branch for place in reached}
    places = sorted(unreached)
    return Compared(
        tuple((place, listed[place.branch]) for place in places if place.branch in listed),
        tuple(place for place in places if place.branch not in listed),
        tuple(e for e in entries if e.branch in there and e.branch not in missing),
    )
