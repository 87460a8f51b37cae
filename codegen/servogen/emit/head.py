"""What the head of an emitted file says of its worst case: rows of text, made before rendering."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from servogen.controllers.design import Declaration
from servogen.wcet.operations import OperationCounts
from servogen.wcet.package import Count, PackageCount

COLUMNS = ("add", "mul", "div", "cmp", "other", "load", "store", "stack")


@dataclass(frozen=True)
class Head:
    """Lines of a table, aligned, and the bytes of the constant tables of the file."""

    lines: tuple[str, ...]
    table_bytes: int


def head_of(declaration: Declaration, counts: PackageCount) -> Head:
    """The worst case of each entry point of a controller; of one with named bounds also its parts.

    Raises:
        KeyError: one of its entry points was not counted.
    """
    p = declaration.prefix
    rows: list[tuple[str, ...]] = [("worst case of one call", *COLUMNS)]
    for name in ("init", *(op.name for op in declaration.entries)):
        rows += _rows(f"{p}_{name}", counts.entry_points[f"{p}_{name}"])
    own = (f"{p}.c", f"{p}_tables.c")
    size = sum(b for file, b in counts.source_table_bytes.items() if file in own)
    return Head(tuple(_aligned(rows)), size)


def _rows(name: str, count: Count) -> list[tuple[str, ...]]:
    rows = [(name, *_arithmetic(count.total()), str(count.stack_bytes))]
    parts = {**count.per_iteration, **count.per_level}
    if parts:
        rows.append(("  fixed part", *_arithmetic(count.fixed), ""))
    for bound, part in parts.items():
        rows.append((f"  each of {count.caps[bound]} {bound}", *_arithmetic(part), ""))
    return rows


def _arithmetic(counts: OperationCounts) -> list[str]:
    other = counts.neg + counts.sqrt + counts.convert + counts.other_fp
    shown = (counts.add, counts.mul, counts.div, counts.cmp, other, counts.load, counts.store)
    return [str(number) for number in shown]


def _aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        " ".join(
            cell.rjust(w) if i else cell.ljust(w)
            for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
