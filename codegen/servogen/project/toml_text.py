"""The text of a project file as TOML's tables, whatever kind of project it is."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from servogen.errors import InputError
from servogen.project.translate import value_text

_LARGEST_FILE = 1_000_000  # bytes; a project file has a few kilobytes


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a file.

    Raises:
        InputError: the file cannot be read, or is no TOML.
    """
    return _parse(path, _read_text(path))


def _read_text(path: Path) -> str:
    try:
        if path.is_dir():
            raise InputError(path, "the project file", "a folder", "a TOML file")
        if path.stat().st_size > _LARGEST_FILE:
            size = f"{path.stat().st_size} bytes"
            raise InputError(path, "its size", size, f"at most {_LARGEST_FILE} bytes")
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(path, "the project file", "missing", "a TOML file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        told = f"unreadable ({reason})"
        raise InputError(path, "the project file", told, "a readable TOML file") from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        byte = f"the byte 0x{data[error.start]:02x}"
        raise InputError(path, f"line {line}", byte, "text in UTF-8") from None


def _parse(path: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
    except ValueError:  # Python's own limit on the digits of a whole number
        digits = "a whole number of thousands of digits"
        raise InputError(path, "a value", digits, "one that a machine can have") from None
    at = re.search(r" \(at (?:line (\d+), column \d+|end of document)\)$", message)
    reason = message[: at.start()] if at else message
    lines = text.splitlines() or [""]
    number = int(at[1]) if at and at[1] else len(lines)
    line = lines[min(number, len(lines)) - 1].strip()
    expected = f"valid TOML: {reason[:1].lower()}{reason[1:]}"
    raise InputError(path, f"line {number}", value_text(line), expected)
