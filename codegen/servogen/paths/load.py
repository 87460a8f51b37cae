"""One entrance for all kinds of drawing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from servogen.errors import InputError
from servogen.paths.csv_points import read_csv
from servogen.paths.dxf import read_dxf
from servogen.paths.gcode import read_gcode
from servogen.paths.geometry import SHORTEST_M, ToolPath, build_tool_path
from servogen.paths.settings import PathSettings
from servogen.paths.svg import read_svg

_LAYERED = (".dxf", ".svg")
_READERS = {
    ".dxf": (read_dxf, True),
    ".svg": (read_svg, True),
    ".nc": (read_gcode, False),
    ".ngc": (read_gcode, False),
    ".gcode": (read_gcode, False),
    ".csv": (read_csv, False),
}


def load_tool_path(settings: PathSettings, file: Path, axes: int = 2) -> ToolPath:
    """Read a drawing, order its entities and join them into one tool path of ``axes`` axes.

    DXF and SVG entities are ordered (see ``order_strokes``); G-code and CSV keep their order. With
    two axes a height that never changes says nothing; with three one that is not said is 0.

    Raises:
        InputError: naming the file and the place in it.
    """
    suffix = file.suffix.lower()
    if suffix not in _READERS:
        raise InputError(
            file,
            "path.file",
            f"a {suffix or 'nameless'} file",
            "one of " + ", ".join(sorted(_READERS)),
        )
    if settings.layer_feeds_m_per_s and suffix not in _LAYERED:
        name = next(iter(settings.layer_feeds_m_per_s))
        key, expected = (
            f"path.layer_feeds_m_per_s.{name}",
            f"none, as {suffix} files have no layers",
        )
        raise InputError(None, key, settings.layer_feeds_m_per_s[name], expected)
    read, reorder = _READERS[suffix]
    found = build_tool_path(read(file, settings), settings, file, reorder=reorder)
    return with_axes(found, file, axes)


def with_axes(path: ToolPath, file: Path, axes: int) -> ToolPath:
    """The path in two or three axes.

    Raises:
        InputError: naming the first place where z moves, with two axes.
    """
    points = path.points
    if points.shape[1] < axes:
        return replace(path, points=np.column_stack([points, np.zeros(len(points))]))
    if points.shape[1] > axes:
        moved = np.flatnonzero(np.abs(points[1:, 2] - points[0, 2]) > SHORTEST_M)
        if moved.size:
            first = int(moved[0])
            value = f"a move of z to {points[first + 1, 2]:.6g} m"
            raise InputError(file, path.labels[first], value, "a level path: there are two axes")
        return replace(path, points=points[:, :2])
    return path
