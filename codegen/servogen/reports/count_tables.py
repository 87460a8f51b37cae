"""Tables of the counts: budgets, memory, targets, worst cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from servogen.reports.data import Found
from servogen.reports.numbers import number, percent
from servogen.reports.run_count_table import run_table
from servogen.reports.tables import (
    BAD,
    GOOD,
    MUTED,
    Cell,
    Missing,
    Table,
    any_cell,
    label,
    named,
    other_keys,
    share_cell,
    size_table,
    text,
)

Json = Mapping[str, Any]
Part = Table | Missing
_CLASSES = ("add", "mul", "div", "cmp", "load", "store")
_KNOWN = (
    *("budgets", "share", "entry_points", "table_bytes", "memory", "targets", "faults"),
    *("target", "total_table_bytes"),
)


def wcet_parts(data: Found) -> list[Part]:
    """Budgets, memory, targets, counts, and static count and run side by side."""
    found = data.wcet
    if found is None:
        missing = Missing("The operations have not been counted", f"servogen wcet {data.toml}")
        return [missing, run_table(data)]
    parts: list[Part] = []
    budgets = named(found.get("budgets"))
    if budgets:
        parts.append(_budgets(budgets, found.get("share")))
    memory = found.get("memory")
    if isinstance(memory, Mapping):
        parts.append(_memory(memory))
    targets = named(found.get("targets"))
    if targets:
        parts.append(_targets(targets))
    entries = named(found.get("entry_points"))
    if entries:
        # those that run periodically for every reader, the others for who asks
        periodic = {name: count for name, count in entries.items() if count.get("period_s")}
        parts += [_counts(periodic or entries, False), _counts(entries, True)]
    parts.append(run_table(data))
    tables = found.get("table_bytes")
    if isinstance(tables, Mapping) and tables:
        parts.append(size_table("Constant tables", tables))
    return parts + other_keys("Other figures", found, _KNOWN)


_OF_CAPS = ("fixed [cycles]", "per iteration [cycles]", "cap", "largest cap that fits")


def _budgets(budgets: Mapping[str, Json], share: Any) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for window, b in budgets.items():
        fits = b.get("fits") is True
        rows.append(
            (
                text(window, "name"),
                text(_called(b.get("calls"))),
                any_cell(b.get("target")),
                any_cell(_whole(b.get("budget_cycles"))),
                any_cell(_whole(b.get("fixed_cycles"))),
                any_cell(_whole(b.get("cycles_per_iteration"))),
                any_cell(b.get("cap")),
                any_cell(_whole(b.get("total_cycles"))),
                share_cell(b.get("utilisation")),
                any_cell(b.get("largest_cap")),
                Cell("fits", GOOD) if fits else Cell(f"over: {b.get('culprit')}", BAD),
            )
        )
    columns: tuple[str, ...] = ("within", "calls", "target", "budget [cycles]", "fixed [cycles]",
               "per iteration [cycles]", "cap", "worst case [cycles]", "of budget",
               "largest cap that fits", "verdict")  # fmt: skip
    note = (
        "All that has to be done within a window of time; cycles of the worst case, with the cap "
        "as emitted; all capped loops have equal caps. Operations are counted in the C, cycles "
        "are the target file's estimates."
    )
    if not any(b.get("cap") for b in budgets.values()):
        # nothing iterates: the fixed part is all there is
        kept = [i for i, name in enumerate(columns) if name not in _OF_CAPS]
        columns = tuple(columns[i] for i in kept)
        rows = [tuple(row[i] for i in kept) for row in rows]
        note = (
            "All that has to be done within a window of time; cycles of the worst case. Operations "
            "are counted in the C, cycles are the target file's estimates."
        )
    if isinstance(share, int | float):
        note = f"Budget: {percent(share)} of the window. {note}"
    return Table("Budget", columns, tuple(rows), note)


def _called(calls: Any) -> str:
    """``plan + 150 fast_step``."""
    found = calls if isinstance(calls, Mapping) else {}
    return " + ".join(f"{n} {name}" if n != 1 else str(name) for name, n in found.items())


def _memory(memory: Json) -> Table:
    rows = []
    for kind, what in (("state", "state"), ("arguments", "arguments"), ("stack", "stack of")):
        for name, size in dict(memory.get(kind) or {}).items():
            rows.append((text(f"{what} {name}"), any_cell(size), any_cell(None), text("")))
    for kind, what in (("data", "data in all"), ("table", "constant tables")):
        used, limit = memory.get(f"{kind}_bytes"), memory.get(f"{kind}_limit_bytes")
        rows.append((text(what, "name"), any_cell(used), any_cell(limit), _fits(used, limit)))
    note = (
        "Stack: C objects along the deepest chain of calls, without what a compiler adds; one "
        "entry for each deadline, since a shorter one may interrupt a longer. Code is not counted."
    )
    return Table("Memory", ("", "bytes", "target has [bytes]", "verdict"), tuple(rows), note)


def _fits(used: Any, limit: Any) -> Cell:
    if not isinstance(used, int) or not isinstance(limit, int):
        return any_cell(None)
    return Cell("fits", GOOD) if used <= limit else Cell("too small", BAD)


def _targets(targets: Mapping[str, Json]) -> Table:
    """Every bundled target; one that cannot do the precision says so."""
    rows: list[tuple[Cell, ...]] = []
    for name, fit in targets.items():
        memory = fit.get("memory") or {}
        parts = [
            _ratio(memory.get("data_bytes"), memory.get("data_limit_bytes")),
            _ratio(memory.get("table_bytes"), memory.get("table_limit_bytes")),
        ]
        budgets = named(fit.get("budgets"))
        if not budgets:
            why = "; ".join(str(fault) for fault in fit.get("faults") or ())
            rows.append((text(name, "name"), *[any_cell(None)] * 4, *parts, Cell(why, MUTED)))
        for window, b in budgets.items():
            fits = b.get("fits") is True
            rows.append(
                (
                    text(name, "name"),
                    text(window),
                    any_cell(_whole(b.get("total_cycles"))),
                    share_cell(b.get("utilisation")),
                    any_cell(b.get("largest_cap")),
                    *parts,
                    Cell("fits", GOOD) if fits else Cell(f"over: {b.get('culprit')}", BAD),
                )
            )
    columns = ("target", "within", "cycles", "of budget", "largest cap that fits", "data", "tables",
               "verdict")  # fmt: skip
    note = "The C as emitted, for comparison; only the project's own target decides."
    return Table("All targets", columns, tuple(rows), note, folded=True)


def _ratio(used: Any, limit: Any) -> Cell:
    known = isinstance(used, int) and isinstance(limit, int) and limit > 0
    return share_cell(used / limit if known else None)


def _counts(entries: Mapping[str, Json], everything: bool) -> Table:
    """Per entry point: the fixed part, one turn of each named bound, the total."""
    classes = _all_classes(entries) if everything else _CLASSES
    rows = []
    for entry, count in entries.items():
        turns = [
            (f"one {what}, {bound} = {number(dict(count.get('caps') or {}).get(bound, 0))}", part)
            for key, what in (("per_iteration", "iteration"), ("per_tree_level", "level"))
            for bound, part in named(count.get(key)).items()
        ]
        if turns:
            rows.append(_count_row(entry, "fixed part", count.get("fixed"), classes))
            rows += [_count_row(entry, told, part, classes) for told, part in turns]
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


def _whole(value: Any) -> Any:
    return round(value) if isinstance(value, float) and abs(value) >= 100.0 else value
