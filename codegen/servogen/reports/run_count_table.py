"""Static counts beside what runs did, from the check ``counts``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from servogen.evidence.certificate import FAILED, PASSED
from servogen.reports.data import Found
from servogen.reports.tables import (
    BAD,
    GOOD,
    Cell,
    Missing,
    Table,
    any_cell,
    named,
    share_cell,
    text,
)

CLASSES = ("add", "mul", "div", "cmp", "load", "store")


def run_table(data: Found) -> Table | Missing:
    """Static count and largest run side by side, from the check that played them."""
    entries = data.certificate.entries if data.certificate else ()
    ran = next((e for e in entries if e.name == "counts" and e.state in (PASSED, FAILED)), None)
    if ran is None:
        what = "The static counts have not been compared with runs"
        return Missing(what, f"servogen check counts {data.toml}")
    rows = [
        _run_row(precision, name, entry)
        for precision, found in named(ran.figures).items()
        for name, entry in named(found.get("entry_points")).items()
    ]
    columns = ("precision", "entry point", "calls", *(f"{c}, run / static" for c in CLASSES),
               "of the turns done", "verdict")  # fmt: skip
    note = (
        "The largest number in one call beside the static count. Of the turns done: the closest "
        "call, held to the count for the turns that its own loops did, all classes added up."
    )
    return Table("Static count and largest run", columns, tuple(rows), note, folded=len(rows) > 40)


def _run_row(precision: str, name: str, entry: Mapping[str, Any]) -> tuple[Cell, ...]:
    static, largest = entry.get("static") or {}, entry.get("largest_run") or {}
    above = [c for c in static if largest.get(c, 0) > static[c]]
    if above or entry.get("held") is not True:
        verdict = Cell(f"above: {', '.join(above)}" if above else "not held", BAD)
    else:
        verdict = Cell("always equal" if entry.get("equal") is True else "covered", GOOD)
    return (
        text(precision),
        text(name, "name"),
        any_cell(entry.get("calls")),
        *(
            Cell(f"{any_cell(largest.get(c)).text} / {any_cell(static.get(c)).text}", numeric=True)
            for c in CLASSES
        ),
        share_cell(entry.get("ratio_of_turns_done")),
        verdict,
    )
