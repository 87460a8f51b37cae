"""The tables of ``servogen wcet`` for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from servogen.wcet.operations import OperationCounts

if TYPE_CHECKING:
    from servogen.steps.count import Fit, WcetResult

Row = Sequence[str]
_COLUMNS = ("add", "mul", "div", "cmp", "other", "load", "store", "int")


def entry_table(result: WcetResult) -> list[str]:
    """All entry points: worst case, and where a bound is named the fixed part and one turn."""
    head = ("worst case of one call", *_COLUMNS, "stack", "cycles", "of period")
    rows: list[Row] = [head]
    for name, count in result.counts.entry_points.items():
        used = result.utilisation(name)
        rows.append(
            (
                name,
                *_classes(count.total()),
                str(count.stack_bytes),
                f"{result.cycles(name):.0f}",
                "" if used is None else f"{used:.2%}",
            )
        )
        for label, part in _parts(result, name):
            rows.append((f"  {label}", *_classes(part), "", f"{_cycles(result, part):.0f}", ""))
    rows.append(("other: sign, square root, conversion; int: integers, branches, calls",))
    return aligned(rows)


def target_table(fits: Mapping[str, Fit]) -> list[str]:
    """Every target and every window of time: cycles, utilisation, largest cap, memory."""
    rows: list[Row] = [
        ("target", "within", "cycles", "of budget", "cap that fits", "data", "tables", "verdict")
    ]
    for name, fit in fits.items():
        m = fit.memory
        occupied = (
            f"{m.data_bytes / m.data_limit:.1%}",
            f"{m.table_bytes / m.program_limit:.1%}",
        )
        if fit.missing:
            rows.append((name, "", "", "", "", *occupied, fit.missing))
        for number, b in enumerate(fit.budgets):
            cap = "" if b.largest_cap is None else str(b.largest_cap)
            verdict = "fits" if b.fits else f"over: {b.culprit}"
            if number == 0 and not m.fits:
                verdict += "; memory too small"
            rows.append(
                (
                    name if number == 0 else "",
                    b.label,
                    f"{b.total_cycles:.0f}",
                    f"{b.utilisation:.1%}",
                    cap,
                    *(occupied if number == 0 else ("", "")),
                    verdict,
                )
            )
    if all(row[4] == "" for row in rows[1:]):  # nothing has a cap
        return aligned([(*row[:4], *row[5:]) for row in rows], left=(0, 6))
    return aligned(rows, left=(0, 7))


def aligned(rows: Sequence[Row], left: Sequence[int] = (0,)) -> list[str]:
    """Columns under one another; rows of one cell are notes and go as they are."""
    table = [row for row in rows if len(row) > 1]
    widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))]

    def pad(i: int, cell: str) -> str:
        return cell.ljust(widths[i]) if i in left else cell.rjust(widths[i])

    return [
        "  ".join(pad(i, cell) for i, cell in enumerate(row)).rstrip() if len(row) > 1 else row[0]
        for row in rows
    ]


def _parts(result: WcetResult, name: str) -> Iterator[tuple[str, OperationCounts]]:
    count = result.counts.entry_points[name]
    if count.per_iteration or count.per_level:
        yield "fixed part", count.fixed
    for bound, part in count.per_iteration.items():
        yield f"each of {count.caps[bound]} iterations, {bound}", part
    for bound, part in count.per_level.items():
        yield f"each of {count.caps[bound]} levels, {bound}", part


def _cycles(result: WcetResult, part: OperationCounts) -> float:
    return result.fit.target.cost(part, result.counts.precision)


def _classes(counts: OperationCounts) -> list[str]:
    c = counts
    other = c.neg + c.sqrt + c.convert + c.other_fp
    integers = c.int_add + c.int_mul + c.int_div + c.int_cmp + c.int_load + c.int_store
    whole = integers + c.branch + c.call
    return [str(n) for n in (c.add, c.mul, c.div, c.cmp, other, c.load, c.store, whole)]
