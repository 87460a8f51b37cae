"""Points from a CSV file to strokes, in the order of the file.

Each row is a point in metres, ``x,y`` or ``x,y,feed``; the feed (m/s) is that of the straight move
to the point, so the first row's has no move to govern. A first row ``x_m,y_m`` or
``x_m,y_m,feed_m_per_s`` is a header. A point that repeats the one before it adds nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from servogen.errors import InputError
from servogen.paths.curves import Line, Stroke
from servogen.paths.settings import PathSettings
from servogen.paths.text import finite_number, read_text

_HEADERS = (["x_m", "y_m"], ["x_m", "y_m", "feed_m_per_s"])


def read_csv(file: Path, settings: PathSettings) -> list[Stroke]:
    """One stroke for each row after the first, labelled with its line.

    Raises:
        InputError: naming the line that is ragged or holds something else than finite numbers,
            or a feed that is not above 0.
    """
    strokes: list[Stroke] = []
    at: tuple[float, float] | None = None
    for number, row in _rows(file):
        point = (row[0], row[1])
        if at is not None and at != point:
            feed = row[2] if len(row) == 3 else None
            strokes.append(Stroke(f"line {number}", (Line(at, point),), feed))
        at = point
    return strokes


def _rows(file: Path) -> Iterator[tuple[int, list[float]]]:
    """Line numbers and the two or three numbers on each line."""
    columns = 0
    for number, text in enumerate(read_text(file, "a CSV file of points").splitlines(), start=1):
        cells = [cell.strip() for cell in text.split(",")]
        if cells == [""]:
            continue
        if not columns:
            columns = len(cells)
            if finite_number(cells[0]) is None and cells in _HEADERS:
                continue
            _check_first(file, number, cells)
        yield number, _numbers(file, number, cells, columns)


def _check_first(file: Path, number: int, cells: list[str]) -> None:
    """Refuse a first row that is neither a header nor a point."""
    if len(cells) not in (2, 3) or not any(finite_number(cell) is not None for cell in cells):
        expected = "the header x_m,y_m or x_m,y_m,feed_m_per_s, or a point x,y or x,y,feed"
        raise InputError(file, f"line {number}", f'"{_short(",".join(cells))}"', expected)


def _numbers(file: Path, number: int, cells: list[str], columns: int) -> list[float]:
    where = f"line {number}"
    if len(cells) != columns:
        found = f"of {len(cells)} column{'s' if len(cells) > 1 else ''}"
        raise InputError(file, where, found, f"{columns} as in the lines before")
    row: list[float] = []
    for name, cell in zip(_HEADERS[1], cells, strict=False):
        value = finite_number(cell)
        if value is None:
            raise InputError(file, f"{where}: {name}", f'"{_short(cell)}"', "a finite number")
        row.append(value)
    if columns == 3 and not row[2] > 0.0:
        raise InputError(file, f"{where}: feed_m_per_s", row[2], "a feed above 0")
    return row


def _short(text: str) -> str:
    """A cell for a message."""
    return text if len(text) <= 40 else text[:37] + "..."
