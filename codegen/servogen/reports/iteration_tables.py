"""Iterations of the MPC, measured and certified, from the check ``iterations``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from servogen.evidence.certificate import FAILED, MEASURED, PASSED
from servogen.reports.data import Found
from servogen.reports.numbers import number, percent
from servogen.reports.tables import (
    BAD,
    GOOD,
    MUTED,
    Cell,
    Missing,
    Table,
    any_cell,
    named,
    text,
)

Json = Mapping[str, Any]
NAME = "iterations"
# Upper ends of the histogram's classes; beyond them it doubles.
_FIRST_CLASSES = (0, 1, 2, 4, 8)


def iteration_parts(data: Found) -> list[Table | Missing]:
    """Measured and certified, the histogram, and the work at the certified number; nothing where no
    controller iterates."""
    entries = data.certificate.entries if data.certificate else ()
    own = next((e for e in entries if e.name == NAME), None)
    if own is None:
        return []
    if own.state not in (PASSED, FAILED, MEASURED):
        told = f"servogen check {NAME} {data.toml}"
        return [] if own.state == "does not apply" else [
            Missing("The iterations have not been looked at", told)
        ]  # fmt: skip
    found = own.figures
    measured, cap = named(found.get("measured")), found.get("cap")
    programs = named(found.get("programs"))
    parts: list[Table | Missing] = [
        _measured(measured, cap),
        _certified(programs, cap),
        _histogram(measured),
    ]
    bound = _bound(programs)
    budgets = named((data.wcet or {}).get("budgets"))
    if bound is not None and isinstance(cap, int) and bound < cap and budgets:
        parts.append(_work(budgets, bound, cap))
    return parts


def _measured(measured: Mapping[str, Json], cap: Any) -> Table:
    keys = ("steps", "none_needed", "median", "p99", "most", "most_solved", "backup", "infeasible")
    rows = tuple(
        (text(name, "name"), *(any_cell(own.get(key)) for key in keys))
        for name, own in measured.items()
    )
    columns = (
        "", "steps", "none needed", "median", "99 %", "most", "most, solved", "backup",
        "infeasible",
    )  # fmt: skip
    note = (
        f"The cap is {any_cell(cap).text}. Random states are anywhere, their bounds often ones "
        "that no plan keeps. The search goes uphill from the hardest of them, each step from a "
        "cold start. Measured is not proved."
    )
    return Table("Iterations measured, with the C inside", columns, rows, note)


def _certified(programs: Mapping[str, Json], cap: Any) -> Table:
    rows = []
    for name, own in programs.items():
        for key, when in (("cold", "from a cold start"), ("warm", "after any other call")):
            found = own.get(key)
            if not isinstance(found, Mapping):
                why = str(own.get("why_not") or "the cold start alone is more than the budget")
                nothing = any_cell(None)
                rows.append((text(name, "name"), text(when), Cell(f"not certified: {why}", MUTED),
                             nothing, nothing, nothing))  # fmt: skip
                continue
            rows.append(
                (
                    text(name, "name"),
                    text(when),
                    _worst_case(found, cap),
                    any_cell(found.get("bound")),
                    any_cell(found.get("attained")),
                    any_cell(found.get("pieces")),
                )
            )
    columns = ("program", "calls", "worst case", "iterations", "attained", "pieces")
    note = (
        "Over every state, reference and bound in its declared range, whatever the last call was. "
        "Where it is not finished, the iterations are the most that was seen."
    )
    return Table("Iterations certified", columns, tuple(rows), note)


def _worst_case(found: Mapping[str, Any], cap: Any) -> Cell:
    if found.get("exact") is True:
        enough = isinstance(cap, int) and int(found.get("bound") or 0) <= cap
        return Cell("exact", GOOD) if enough else Cell("exact, above the cap", BAD)
    if found.get("refuted"):
        return Cell(f"not certified: {any_cell(found['refuted']).text} were taken", BAD)
    if found.get("finished") is True and found.get("rounding_may_cost_more"):
        return Cell("not certified: rows may round to more than accept", MUTED)
    why = "not attained" if found.get("finished") is True else "not finished"
    return Cell(f"not certified: {why}", MUTED)


def _histogram(measured: Mapping[str, Json]) -> Table:
    """Shares of steps by their number of iterations, in classes that double."""
    counts = {
        name: {int(k): int(v) for k, v in dict(own.get("histogram") or {}).items()}
        for name, own in measured.items()
    }
    most = max((max(own, default=0) for own in counts.values()), default=0)
    ends = list(_FIRST_CLASSES)
    while ends[-1] < most:
        ends.append(2 * ends[-1])
    rows, low = [], 0
    for end in ends:
        if low > most:
            break
        told = number(low) if low == end else f"{number(low)} to {number(end)}"
        cells = []
        for own in counts.values():
            inside = sum(count for i, count in own.items() if low <= i <= end)
            total = max(sum(own.values()), 1)
            cells.append(Cell(percent(inside / total) if inside else "", numeric=True))
        rows.append((text(told), *cells))
        low = end + 1
    return Table("Steps by iterations", ("iterations", *counts), tuple(rows))


def _bound(programs: Mapping[str, Json]) -> int | None:
    """The certified worst case of all programs; None where one has none."""
    bounds = [own.get("certified") for own in programs.values()]
    if not bounds or not all(isinstance(bound, int) for bound in bounds):
        return None
    return max(int(bound) for bound in bounds if isinstance(bound, int))


def _work(budgets: Mapping[str, Json], bound: int, cap: int) -> Table:
    """What every window takes at the cap, and at the certified number of iterations."""
    rows = []
    for window, own in budgets.items():
        total, each = own.get("total_cycles"), own.get("cycles_per_iteration")
        if not isinstance(total, int | float) or not isinstance(each, int | float) or not each:
            continue
        less = total - (cap - bound) * each
        rows.append((text(window, "name"), any_cell(round(total)), any_cell(round(less))))
    columns = ("window", f"cycles at the cap of {cap}", f"at the certified {bound}")
    note = "The static count, of a loop that is left after the certified number of iterations."
    return Table("Worst case at the certified number of iterations", columns, tuple(rows), note)
