"""The few C types the emitted code uses, with their sizes on the target."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

POINTER_BYTES = 4  # every shipped target has 32-bit addresses; the host only counts


@dataclass(frozen=True)
class Scalar:
    """An arithmetic type, or void. Enumerations and _Bool are integers."""

    kind: Literal["int", "float", "double", "void"]
    bytes: int
    signed: bool = True

    @property
    def is_real(self) -> bool:
        return self.kind in ("float", "double")


@dataclass(frozen=True)
class Pointer:
    target: CType


@dataclass(frozen=True)
class Array:
    element: CType
    length: int | None  # None where the declaration leaves it open


@dataclass(eq=False)
class Record:
    """A structure or union; ``members`` is None until it is defined."""

    tag: str
    is_union: bool
    members: dict[str, CType] | None = field(default=None)


@dataclass(frozen=True)
class Function:
    result: CType
    parameters: tuple[CType, ...]


CType = Scalar | Pointer | Array | Record | Function

INT = Scalar("int", 4)
UNSIGNED = Scalar("int", 4, signed=False)
DOUBLE = Scalar("double", 8)
FLOAT = Scalar("float", 4)
VOID = Scalar("void", 0)

_INTEGERS = {
    "char": Scalar("int", 1),
    "short": Scalar("int", 2),
    "int": INT,
    "long": Scalar("int", 4),
    "long long": Scalar("int", 8),
    "_Bool": Scalar("int", 1, signed=False),
}


def builtin(names: list[str]) -> CType | None:
    """Type of a list of C keywords (``["unsigned", "long"]``), None if it is not built in."""
    if names == ["float"]:
        return FLOAT
    if names == ["double"]:
        return DOUBLE
    if names == ["void"]:
        return VOID
    words = [n for n in names if n not in ("signed", "unsigned")]
    longs = words.count("long")
    base = " ".join(["long"] * longs) if longs else next((w for w in words if w != "int"), "int")
    found = _INTEGERS.get(base)
    if found is None or any(w not in ("char", "short", "int", "long", "_Bool") for w in words):
        return None
    return Scalar("int", found.bytes, signed="unsigned" not in names and found.signed)


def decay(kind: CType) -> CType:
    """What a value of this type is once used: an array becomes a pointer to its element."""
    return Pointer(kind.element) if isinstance(kind, Array) else kind


def arithmetic(a: CType, b: CType) -> CType:
    """Result of the usual arithmetic conversions; pointer arithmetic keeps the pointer."""
    for side in (decay(a), decay(b)):
        if isinstance(side, Pointer | Function):
            return side
    if not isinstance(a, Scalar) or not isinstance(b, Scalar):
        return VOID
    for wide in ("double", "float"):
        for scalar in (a, b):
            if scalar.kind == wide:
                return scalar
    left, right = promote(a), promote(b)
    if left.bytes != right.bytes:
        return left if left.bytes > right.bytes else right
    return left if not left.signed else right


def promote(kind: Scalar) -> Scalar:
    """Integer promotion."""
    return INT if kind.kind == "int" and kind.bytes < INT.bytes else kind


def alignment(kind: CType) -> int:
    """Natural alignment in bytes."""
    if isinstance(kind, Array):
        return alignment(kind.element)
    if isinstance(kind, Record):
        return max((alignment(m) for m in (kind.members or {}).values()), default=1)
    return max(1, size_of(kind))


def size_of(kind: CType) -> int:
    """Bytes with natural alignment; an open array counts as empty."""
    if isinstance(kind, Scalar):
        return kind.bytes
    if isinstance(kind, Array):
        return (kind.length or 0) * size_of(kind.element)
    if isinstance(kind, Record):
        end = 0
        for member in (kind.members or {}).values():
            start = 0 if kind.is_union else -(-end // alignment(member)) * alignment(member)
            end = max(end, start + size_of(member))
        return -(-end // alignment(kind)) * alignment(kind)
    return POINTER_BYTES


def elements(kind: CType) -> tuple[int, int]:
    """(scalars of floating point, everything else) that a copy of this type moves."""
    if isinstance(kind, Array):
        reals, others = elements(kind.element)
        return reals * (kind.length or 0), others * (kind.length or 0)
    if isinstance(kind, Record):
        parts = [elements(m) for m in (kind.members or {}).values()]
        return sum(r for r, _ in parts), sum(o for _, o in parts)
    return (1, 0) if isinstance(kind, Scalar) and kind.is_real else (0, 1)
