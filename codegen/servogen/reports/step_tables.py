"""Tables of the other verbs, from their JSON: equivalence, build.

What a step's JSON says beyond the known keys is shown as it stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from servogen.reports.data import Found
from servogen.reports.tables import (
    BAD,
    GOOD,
    Cell,
    Missing,
    Table,
    any_cell,
    figure_cell,
    key_table,
    label,
    other_keys,
    passed_cell,
    size_table,
    text,
)

Json = Mapping[str, Any]
Part = Table | Missing


def sil_parts(data: Found) -> list[Part]:
    """Agreement of C and reference."""
    found = data.sil
    if found is None:
        return [Missing("The C has not been compared with its reference", _command(data, "sil"))]
    scenarios = _mappings(found.get("scenarios"))
    loops = _mappings(found.get("closed_loops"))
    parts: list[Part] = []
    if scenarios:
        parts += [_by_precision(scenarios), _scenarios(scenarios)]
    if loops:
        parts.append(_records("Closed loops with the C inside", loops))
    return parts + other_keys("Other figures", found, ("scenarios", "closed_loops"))


def _by_precision(scenarios: Sequence[Json]) -> Table:
    rows = []
    for precision in dict.fromkeys(str(s.get("precision", "")) for s in scenarios):
        own = [s for s in scenarios if str(s.get("precision", "")) == precision]
        failed = sum(s.get("passed") is not True for s in own)
        rows.append(
            (
                text(precision, "name"),
                figure_cell(len(own)),
                figure_cell(sum(int(s.get("calls") or 0) for s in own)),
                figure_cell(sum(int(s.get("decisions") or 0) for s in own)),
                figure_cell(max(_float(s.get("largest_difference")) for s in own)),
                Cell("all agree", GOOD) if not failed else Cell(f"{failed} differ", BAD),
            )
        )
    columns = ("precision", "scenarios", "calls", "decisions", "largest difference", "verdict")
    note = "Decisions are statuses and integer outputs; they must be equal."
    return Table("C against reference", columns, tuple(rows), note)


def _scenarios(scenarios: Sequence[Json]) -> Table:
    rows = tuple(
        (
            text(str(s.get("controller", ""))),
            text(str(s.get("name", ""))),
            text(str(s.get("precision", ""))),
            any_cell(s.get("calls")),
            any_cell(s.get("decisions")),
            any_cell(s.get("largest_difference")),
            any_cell(s.get("statuses")),
            passed_cell(s.get("passed") is True)
            if not s.get("difference")
            else Cell(str(s["difference"]), BAD),
        )
        for s in scenarios
    )
    columns = ("controller", "scenario", "precision", "calls", "decisions", "largest difference",
               "statuses", "verdict")  # fmt: skip
    return Table(f"All {len(rows)} scenarios", columns, rows, folded=True)


def build_parts(data: Found, shown: Sequence[str] = ()) -> list[Part]:
    """What was emitted; ``shown``: keys that the page has tables of its own for."""
    found = data.build
    if found is None:
        return [Missing("The C has not been emitted", _command(data, "build"))]
    parts: list[Part] = []
    files = found.get("files")
    scalars = {
        key: value
        for key, value in found.items()
        if key not in ("schema", "passed", "files", "table_bytes", *shown)
    }
    if scalars:
        parts.append(key_table("Package", {label(key): value for key, value in scalars.items()}))
    if isinstance(files, Mapping):
        parts.append(size_table("Emitted files", files))
    elif files is not None:
        parts.append(key_table("Emitted files", {"files": files}))
    return parts


def _records(title: str, records: Sequence[Json]) -> Table:
    keys: dict[str, None] = {}
    for record in records:
        keys |= dict.fromkeys(record)
    rows = tuple(
        tuple(
            passed_cell(r.get(key) is True) if key == "passed" else any_cell(r.get(key))
            for key in keys
        )
        for r in records
    )
    return Table(title, tuple(label(key) for key in keys), rows)


def _mappings(value: Any) -> list[Json]:
    if not isinstance(value, list | tuple):
        return []
    return [item for item in value if isinstance(item, Mapping)]


def _float(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")


def _command(data: Found, verb: str) -> str:
    return f"servogen {verb} {data.toml}"
