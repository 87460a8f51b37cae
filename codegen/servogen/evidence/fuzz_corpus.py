"""The kept sequences of calls: one folder per kind of controller, small, named by content."""

from __future__ import annotations

import os
from pathlib import Path

from servogen.controllers.design import Declaration

_PACKAGE = Path(__file__).resolve().parents[1]
STEPS = 40  # calls of one operation in a first sequence: enough to fill a horizon
MOST_BYTES = 40_000  # of one kind; beyond it nothing more is kept


def corpus_dir() -> Path:
    """In a checkout ``tests/evidence/corpus``, in an installed wheel a copy of it."""
    inside = _PACKAGE / "_data" / "corpus"
    return inside if inside.is_dir() else _PACKAGE.parents[1] / "tests" / "evidence" / "corpus"


def may_grow(folder: Path) -> bool:
    """Whether new sequences are kept there: in a checkout, up to a size, unless FUZZ_KEEP=0."""
    if (
        os.environ.get("FUZZ_KEEP") == "0"
        or not folder.parent.is_dir()
        or _PACKAGE in folder.parents
    ):
        return False
    return sum(file.stat().st_size for file in kept_files(folder)) < MOST_BYTES


def kept_files(folder: Path) -> list[Path]:
    """All sequences of a folder, in the order of their names."""
    return sorted(file for file in folder.glob("*") if file.is_file()) if folder.is_dir() else []


def first_sequences(declaration: Declaration) -> list[bytes]:
    """Where fuzzing starts from nothing: each operation many times at rest, all in turn."""
    names = [op.name for op in declaration.operations]
    start = bytes((names.index("reset"), 0)) if "reset" in names else b""
    each = [bytes((i, 0)) for i in range(len(names)) if names[i] != "reset"]
    return [start + one * STEPS for one in each] + [start + b"".join(each) * STEPS]
