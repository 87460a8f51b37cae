"""Drawings that are text files, read with messages for the user."""

from __future__ import annotations

import math
from pathlib import Path

from servogen.errors import InputError

_LARGEST_BYTES = 200_000_000


def read_text(file: Path, what: str) -> str:
    """The text of a drawing; ``what`` says what it should be ("a G-code file").

    Raises:
        InputError: unreadable, empty, too large, or not UTF-8 text.
    """
    try:
        if file.stat().st_size > _LARGEST_BYTES:
            expected = f"at most {_LARGEST_BYTES} bytes"
            raise InputError(file, "drawing", f"{file.stat().st_size} bytes large", expected)
        data = file.read_bytes()
    except OSError as error:
        raise InputError(file, "drawing", "unreadable", f"{what} ({error.strerror})") from error
    if not data.strip():
        raise InputError(file, "drawing", "empty", what)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        value = f"not UTF-8 (byte 0x{data[error.start]:02x})"
        raise InputError(file, f"line {line}", value, what) from error
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise InputError(file, f"line {line}", "binary (a byte of 0)", what)
    return text


def finite_number(text: str) -> float | None:
    """The number that a text stands for, or None where it is none or not finite."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None
