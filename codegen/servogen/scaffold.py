"""``servogen init``: a copy of a bundled example, for the user to edit."""

from __future__ import annotations

from pathlib import Path

from servogen.errors import InputError
from servogen.outputs import write_tree
from servogen.resources import resource_dir

PROJECT_FILE = "servogen.toml"


def copy_example(system: str, folder: Path) -> Path:
    """Copy the example of a system into a new or empty folder; returns its project file.

    Raises:
        InputError: an unknown system, or a folder that is not empty or cannot be written.
    """
    examples = resource_dir("examples")
    known = sorted(place.parent.name for place in examples.glob(f"*/{PROJECT_FILE}"))
    if system not in known:
        raise InputError(None, "SYSTEM", system, "one of " + ", ".join(known))
    source = examples / system
    files = {
        path.relative_to(source).as_posix(): path.read_bytes()
        for path in sorted(source.rglob("*"))
        if path.is_file() and _is_for_users(path)
    }
    write_tree(folder, files, marker=None)
    return folder / PROJECT_FILE


def _is_for_users(path: Path) -> bool:
    """Not what made the example's drawing, nor what Python leaves beside its files."""
    return not path.name.startswith("make_") and path.suffix != ".pyc"
