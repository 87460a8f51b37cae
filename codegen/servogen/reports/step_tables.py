"""Tables of the other verbs, from their JSON: equivalence, counts, build.

What a step's JSON says beyond the known keys is shown as it stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from servogen.reports.data import ReportData
from servogen.reports.numbers import number, percent
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
    text,
)

Json = Mapping[str, Any]
Part = Table | Missing
_CLASSES = ("add", "mul", "div", "cmp", "load", "store")


def sil_parts(data: ReportData) -> list[Part]:
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


def wcet_parts(data: ReportData) -> list[Part]:
    """Worst-case counts and the budget."""
    found = data.wcet
    if found is None:
        return [Missing("The operations have not been counted", _command(data, "wcet"))]
    parts: list[Part] = []
    budgets = _named(found.get("budgets"))
    if budgets:
        parts.append(_budgets(budgets, found.get("share")))
    entries = _named(found.get("entry_points"))
    if entries:
        # those that run periodically for every reader, the others for who asks
        periodic = {name: count for name, count in entries.items() if name in budgets}
        parts += [_counts(periodic or entries, False), _counts(entries, True)]
    tables = found.get("table_bytes")
    if isinstance(tables, Mapping) and tables:
        parts.append(_bytes("Constant tables", tables))
    known = ("budgets", "share", "entry_points", "table_bytes")
    return parts + other_keys("Other figures", found, known)


def _budgets(budgets: Mapping[str, Json], share: Any) -> Table:
    rows = []
    for entry, b in budgets.items():
        fits = b.get("fits") is True
        rows.append(
            (
                text(entry, "name"),
                any_cell(b.get("target")),
                any_cell(_whole(b.get("budget_cycles"))),
                any_cell(_whole(b.get("fixed_cycles"))),
                any_cell(_whole(b.get("cycles_per_iteration"))),
                any_cell(b.get("cap")),
                any_cell(_whole(b.get("total_cycles"))),
                Cell(percent(_float(b.get("utilisation"))), numeric=True),
                any_cell(b.get("largest_cap")),
                Cell("fits", GOOD) if fits else Cell(f"over: {b.get('culprit')}", BAD),
            )
        )
    columns = ("entry point", "target", "budget [cycles]", "fixed [cycles]",
               "per iteration [cycles]", "cap", "worst case [cycles]", "of budget",
               "largest cap that fits", "verdict")  # fmt: skip
    note = "Cycles of the worst case, with the cap as emitted; all capped loops have equal caps."
    if isinstance(share, int | float):
        note = f"Budget: {percent(share)} of the period. {note}"
    return Table("Budget", columns, tuple(rows), note)


def _counts(entries: Mapping[str, Json], everything: bool) -> Table:
    """Per entry point: the fixed part, one iteration of each capped loop, the total."""
    classes = _all_classes(entries) if everything else _CLASSES
    rows = []
    for entry, count in entries.items():
        rows.append(_count_row(entry, "fixed part", count.get("fixed"), classes))
        caps = count.get("caps") or {}
        for cap, part in _named(count.get("per_iteration")).items():
            times = f"one iteration, {cap} = {number(caps[cap])}" if cap in caps else cap
            rows.append(_count_row(entry, times, part, classes))
        if count.get("per_iteration"):
            rows.append(_count_row(entry, "worst case", count.get("total"), classes))
    title = "All entry points, all classes of operations" if everything else "Worst-case operations"
    note = "" if everything else "Of the scalar type; integer work is counted too, see below."
    columns = ("entry point", "part", *(label(name) for name in classes))
    return Table(title, columns, tuple(rows), note, folded=everything)


def _all_classes(entries: Mapping[str, Json]) -> tuple[str, ...]:
    names: dict[str, None] = {}
    for count in entries.values():
        names |= dict.fromkeys(count.get("fixed") or {})
    return tuple(names)


def _count_row(entry: str, part: str, counts: Any, classes: Sequence[str]) -> tuple[Cell, ...]:
    found = counts if isinstance(counts, Mapping) else {}
    return (text(entry, "name"), text(part), *(any_cell(found.get(name)) for name in classes))


def build_parts(data: ReportData) -> list[Part]:
    """What was emitted."""
    found = data.build
    if found is None:
        return [Missing("The C has not been emitted", _command(data, "build"))]
    parts: list[Part] = []
    files = found.get("files")
    scalars = {
        key: value
        for key, value in found.items()
        if key not in ("schema", "passed", "files", "table_bytes")
    }
    if scalars:
        parts.append(key_table("Package", {label(key): value for key, value in scalars.items()}))
    if isinstance(files, Mapping):
        parts.append(_bytes("Emitted files", files))
    elif files is not None:
        parts.append(key_table("Emitted files", {"files": files}))
    return parts


def _bytes(title: str, sizes: Mapping[str, Any]) -> Table:
    total = sum(v for v in sizes.values() if isinstance(v, int))
    rows = tuple((text(str(name)), any_cell(size)) for name, size in sizes.items())
    heading = f"{title}: {number(len(rows))}, {number(total)} bytes in all"
    return Table(heading, ("name", "bytes"), rows, folded=len(rows) > 8)


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


def _named(value: Any) -> dict[str, Json]:
    if not isinstance(value, Mapping):
        return {}
    return {str(k): v for k, v in value.items() if isinstance(v, Mapping)}


def _whole(value: Any) -> Any:
    return round(value) if isinstance(value, float) and abs(value) >= 100.0 else value


def _float(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")


def _command(data: ReportData, verb: str) -> str:
    return f"servogen {verb} {data.toml}"
