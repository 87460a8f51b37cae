"""One entrance for all kinds of drawing."""

from __future__ import annotations

from pathlib import Path

from servogen.errors import InputError
from servogen.paths.csv_points import read_csv
from servogen.paths.dxf import read_dxf
from servogen.paths.gcode import read_gcode
from servogen.paths.geometry import ToolPath, build_tool_path
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


def load_tool_path(settings: PathSettings, file: Path) -> ToolPath:
    """Read a drawing, order its entities and join them into one tool path.

    DXF and SVG entities are ordered (see ``order_strokes``); G-code and CSV keep their order.

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
    return build_tool_path(read(file, settings), settings, file, reorder=reorder)
