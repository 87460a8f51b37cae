"""Points from a CSV file to strokes, in the order of the file.

Each row is a point in metres, ``x,y`` or ``x,y,feed``; the feed (m/s) is that of the straight move
to the point, so the first row's has no move to govern. A first row ``x_m,y_m`` or
``x_m,y_m,feed_m_per_s`` is a header; with a z it is needed, ``x_m,y_m,z_m`` or
``x_m,y_m,z_m,feed_m_per_s``. A point that repeats the one before it adds nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from servogen.errors import InputError
from servogen.paths.curves import Line, Stroke
from servogen.paths.settings import PathSettings
from servogen.paths.text import finite_number, read_text

_FEED = "feed_m_per_s"
_PLANE = ("x_m", "y_m")
_HEADERS = (_PLANE, (*_PLANE, _FEED), (*_PLANE, "z_m"), (*_PLANE, "z_m", _FEED))
_BY_COLUMNS = {2: _PLANE, 3: (*_PLANE, _FEED)}


def read_csv(file: Path, settings: PathSettings) -> list[Stroke]:
    """One stroke for each row after the first, labelled with its line.

    Raises:
        InputError: naming the line that is ragged or holds something else than finite numbers,
            or a feed that is not above 0; fewer than two places.
    """
    strokes: list[Stroke] = []
    at: tuple[float, ...] | None = None
    for number, row in _rows(file):
        point = tuple(value for name, value in row.items() if name != _FEED)
        if at is not None and at != point:
            strokes.append(Stroke(f"line {number}", (Line(at, point),), row.get(_FEED)))
        at = point
    if not strokes:
        value = "without a point" if at is None else "a single point"
        raise InputError(file, "drawing", value, "points at two places at least")
    return strokes


def _rows(file: Path) -> Iterator[tuple[int, dict[str, float]]]:
    """Line numbers and the numbers on each line by their columns' names."""
    names: tuple[str, ...] = ()
    headed = False
    for number, text in enumerate(read_text(file, "a CSV file of points").splitlines(), start=1):
        cells = [cell.strip() for cell in text.split(",")]
        if cells == [""]:
            continue
        if not names:
            headed = tuple(cells) in _HEADERS
            names = tuple(cells) if headed else _names(file, number, cells)
            if headed:
                continue
        yield number, _numbers(file, number, cells, names, headed)


def _names(file: Path, number: int, cells: list[str]) -> tuple[str, ...]:
    """Of a file without a header; a first row that is neither that nor a point is refused."""
    if len(cells) not in _BY_COLUMNS or not any(finite_number(cell) is not None for cell in cells):
        headers = " or ".join(",".join(header) for header in _HEADERS)
        expected = f"the header {headers}, or a point x,y or x,y,feed"
        raise InputError(file, f"line {number}", f'"{_short(",".join(cells))}"', expected)
    return _BY_COLUMNS[len(cells)]


def _numbers(
    file: Path, number: int, cells: list[str], names: tuple[str, ...], headed: bool
) -> dict[str, float]:
    where = f"line {number}"
    if len(cells) != len(names):
        found = f"of {len(cells)} column{'s' if len(cells) > 1 else ''}"
        raise InputError(file, where, found, f"{len(names)} as in the lines before")
    row: dict[str, float] = {}
    for name, cell in zip(names, cells, strict=True):
        value = finite_number(cell)
        if value is None:
            raise InputError(file, f"{where}: {name}", f'"{_short(cell)}"', "a finite number")
        row[name] = value
    if _FEED in row and not row[_FEED] > 0.0:
        expected = (
            "a feed above 0" if headed else "a feed above 0 (the header x_m,y_m,z_m if it is z)"
        )
        raise InputError(file, f"{where}: {_FEED}", row[_FEED], expected)
    return row


def _short(text: str) -> str:
    """A cell for a message."""
    return text if len(text) <= 40 else text[:37] + "..."
