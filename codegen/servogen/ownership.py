"""Which folders servogen may replace: empty ones, and those that hold only what it made itself.

A folder that servogen made has a marker file: a JSON object whose "schema" begins with
"servogen.". Its "files" (a list, or an object whose keys are the names), if it is there, names
everything that was written; a file beyond it is the user's, and the folder is left alone.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

from servogen.errors import InputError

SCRATCH_PREFIX = ".servogen-tmp-"

_KEY = "the output folder"


def check_replaceable(out: Path, marker: str | None) -> None:
    """Raise an InputError unless ``out`` is free, an empty folder, or a folder servogen made.

    Raises:
        InputError: it is a file, or holds something that servogen did not make.
        OSError: it cannot be read.
    """
    if not os.path.lexists(out):
        return
    if not out.is_dir():
        raise InputError(out, _KEY, "a file", "a folder, or a name that is free")
    if not any(_names(out)):
        return
    if marker is None:
        raise InputError(out, _KEY, "not empty", "an empty folder, or a name that is free")
    reason = _why_foreign(out, marker)
    if reason is not None:
        expected = "an empty folder, a name that is free, or one with servogen's output alone"
        raise InputError(out, _KEY, f"not servogen's to replace ({reason})", expected)


def _why_foreign(out: Path, marker: str) -> str | None:
    try:
        manifest = json.loads((out / marker).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError, RecursionError):
        return f"it has no {marker} of servogen's"
    schema = manifest.get("schema") if isinstance(manifest, dict) else None
    if not (isinstance(schema, str) and schema.startswith("servogen.")):
        return f"its {marker} is not servogen's"
    listed = manifest.get("files")
    if not isinstance(listed, list | dict):
        return None
    known = {marker, *(name for name in listed if isinstance(name, str))}
    extra = next((name for name in _names(out) if name not in known), None)
    return None if extra is None else f"{extra} in it is not"


def _names(folder: Path) -> Iterator[str]:
    """Names of the files below a folder, relative with /, sorted; leftovers of a kill left out."""
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith(SCRATCH_PREFIX))
        for name in sorted(files):
            if not name.startswith(SCRATCH_PREFIX):
                yield (Path(place) / name).relative_to(folder).as_posix()
