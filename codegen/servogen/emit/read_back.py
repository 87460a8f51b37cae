"""Tables and dimensions of a controller, read back from the text of its emitted C.

Strict: what is not of the form that the templates lay out is refused, not passed over.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from servogen.emit.package import CPackage
from servogen.errors import CheckFailed
from servogen.precision import FloatArray, IntArray, Precision

_COMMENT = re.compile(r"/\*.*?\*/", re.S)
_TABLE = re.compile(r"static const (sg_real|int32_t) (\w+)\[(\d+)\] = \{([^{}]*)\};")
_ENUM = re.compile(r"\benum \{([^{}]*)\};")
_ENTRY = re.compile(r"(\w+) = (-?\d+)")
_REAL = re.compile(r"-?\d+(\.\d*)?(e[+-]?\d+)?")
_INTEGER = re.compile(r"-?\d+")


@dataclass(frozen=True)
class ReadBack:
    """``tables`` and ``dimensions`` by the names of the declaration; reals as the C holds them."""

    tables: dict[str, FloatArray | IntArray]
    dimensions: dict[str, int]
    precision: Precision


def read_back(package: CPackage, prefix: str) -> ReadBack:
    """What the C of one controller says.

    Raises:
        CheckFailed: a file is missing, or text that no template lays out so.
    """
    precision = package.declarations[0].precision
    return ReadBack(
        _tables(_text(package, f"{prefix}_tables.h"), prefix, precision),
        _dimensions(_text(package, f"{prefix}.h"), prefix),
        precision,
    )


def _text(package: CPackage, name: str) -> str:
    if name not in package.files:
        raise CheckFailed(f"{name}: not among the files emitted")
    return _COMMENT.sub("", package.files[name])


def _tables(text: str, prefix: str, precision: Precision) -> dict[str, FloatArray | IntArray]:
    found: dict[str, FloatArray | IntArray] = {}
    for kind, name, size, body in _TABLE.findall(text):
        items = [item.strip() for item in body.split(",")]
        own = name.removeprefix(f"{prefix}_")
        if own == name or own in found or len(items) != int(size):
            raise CheckFailed(f"{name}: {len(items)} values in a table of {size}, or twice there")
        if kind == "int32_t":
            found[own] = np.array([_integer(name, item) for item in items], dtype=np.int32)
        else:
            found[own] = np.array([_real(name, item, precision) for item in items])
    if text.count("static const") != len(found):
        raise CheckFailed(f"{prefix}_tables.h: constants that are no tables of numbers")
    return found


def _integer(name: str, text: str) -> int:
    if not _INTEGER.fullmatch(text):
        raise CheckFailed(f"{name}: {text!r} is no integer")
    return int(text)


def _real(name: str, text: str, precision: Precision) -> np.floating:
    digits = text.removesuffix("f") if precision.is_float32 else text
    if not _REAL.fullmatch(digits):
        raise CheckFailed(f"{name}: {text!r} is no number")
    value: np.floating = precision.dtype.type(digits)
    return value


def _dimensions(text: str, prefix: str) -> dict[str, int]:
    bodies = _ENUM.findall(text)
    if len(bodies) != 1:
        raise CheckFailed(f"{prefix}.h: {len(bodies)} enumerations where there is one")
    found = {}
    for entry in bodies[0].split(","):
        match = _ENTRY.fullmatch(entry.strip())
        if match is None or not match[1].startswith(f"{prefix.upper()}_"):
            raise CheckFailed(f"{prefix}.h: {entry.strip()!r} in its enumeration")
        found[match[1].removeprefix(f"{prefix.upper()}_")] = int(match[2])
    return found
