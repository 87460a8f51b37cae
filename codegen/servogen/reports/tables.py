"""Tables as data; the page's template lays them out and escapes every text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from servogen.reports.numbers import NOTHING, number, percent

GOOD, BAD, MUTED, PLAIN = "good", "bad", "muted", ""


@dataclass(frozen=True)
class Cell:
    """``kind``: how it is coloured. ``numeric`` texts stand to the right."""

    text: str
    kind: str = PLAIN
    numeric: bool = False


@dataclass(frozen=True)
class Table:
    """``folded``: shown when asked for."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    folded: bool = False

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"{self.title}: {len(row)} cells, {len(self.columns)} columns")


@dataclass(frozen=True)
class Missing:
    """Stands where a table would: what was not run and how to run it."""

    what: str
    command: str


@dataclass(frozen=True)
class Section:
    """A part of the page: what ``parts`` hold is shown in order, figures by their names."""

    name: str
    title: str
    parts: tuple[object, ...] = field(default=())


def text(value: str, kind: str = PLAIN) -> Cell:
    return Cell(value, kind)


def figure_cell(value: float, digits: int = 4, kind: str = PLAIN) -> Cell:
    return Cell(number(value, digits), kind, numeric=True)


def share_cell(value: Any) -> Cell:
    """A part of one as a percentage."""
    known = isinstance(value, int | float)
    return Cell(percent(float(value)), numeric=True) if known else any_cell(None)


def named(value: Any) -> dict[str, Mapping[str, Any]]:
    """The members of a mapping that are mappings themselves."""
    if not isinstance(value, Mapping):
        return {}
    return {str(k): v for k, v in value.items() if isinstance(v, Mapping)}


def passed_cell(passed: bool, good: str = "passed", bad: str = "failed") -> Cell:
    return Cell(good, GOOD) if passed else Cell(bad, BAD)


def any_cell(value: Any) -> Cell:
    """Whatever a step's JSON holds."""
    if value is None:
        return Cell(NOTHING, MUTED)
    if isinstance(value, bool):
        return Cell("yes" if value else "no")
    if isinstance(value, int | float):
        return figure_cell(value)
    if isinstance(value, Mapping):
        return Cell(", ".join(f"{key} {any_cell(inner).text}" for key, inner in value.items()))
    if isinstance(value, list | tuple):
        return Cell(", ".join(any_cell(inner).text for inner in value))
    return Cell(str(value))


def key_table(title: str, values: Mapping[str, Any], note: str = "") -> Table:
    """Two columns: what and how much."""
    rows = tuple((Cell(key), Cell(any_cell(value).text)) for key, value in values.items())
    return Table(title, ("", "value"), rows, note)


def size_table(title: str, sizes: Mapping[str, Any]) -> Table:
    """Names and bytes, their sum in the title; folded where there are many."""
    total = sum(v for v in sizes.values() if isinstance(v, int))
    rows = tuple((text(str(name)), any_cell(size)) for name, size in sizes.items())
    heading = f"{title}: {number(len(rows))}, {number(total)} bytes in all"
    return Table(heading, ("name", "bytes"), rows, folded=len(rows) > 8)


def other_keys(title: str, found: Mapping[str, Any], shown: Sequence[str]) -> list[Table]:
    """What a step says beyond what the report has a table for: nothing is left out unseen."""
    rest = {
        label(key): value for key, value in found.items() if key not in {*shown, "schema", "passed"}
    }
    return [key_table(title, rest)] if rest else []


_UNITS = (
    ("_m_per_s2", " [m/s²]"),
    ("_m_per_s", " [m/s]"),
    ("_s", " [s]"),
    ("_m", " [m]"),
    ("_hz", " [Hz]"),
    ("_bytes", " [bytes]"),
    ("_cycles", " [cycles]"),
)


def label(key: str) -> str:
    """A JSON key for people: ``total_cycles`` is "total [cycles]"."""
    for ending, unit in _UNITS:
        if key.endswith(ending) and len(key) > len(ending):
            return key.removesuffix(ending).replace("_", " ") + unit
    return key.replace("_", " ")
