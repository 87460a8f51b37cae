"""Operation classes, counts, and costs that are linear in the named iteration caps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import NamedTuple


@dataclass(frozen=True)
class OperationCounts:
    """How often each class of operation happens.

    ``add`` to ``other_fp``, ``load`` and ``store`` are of the package's scalar type ``sg_real``;
    every pointer, flag and enumeration counts as an integer.

    Attributes:
        add: additions and subtractions.
        mul: multiplications.
        div: divisions.
        cmp: comparisons, also fmin and fmax, and a scalar used as a truth value.
        neg: sign changes and absolute values.
        sqrt: square roots.
        convert: between integer and scalar.
        other_fp: isfinite, isnan and their like; rounding.
        load: elements of arrays and structures, globals, and locals whose address is taken, read.
        store: the same, written.
        int_add: integer and pointer additions, negations, shifts and bit operations.
        int_mul: integer multiplications.
        int_div: integer divisions and remainders.
        int_cmp: integer comparisons, ``!``, and one for each label of a ``switch``.
        int_load: as ``load``, of integers.
        int_store: as ``store``, of integers.
        branch: decisions: ``if``, ``?:``, ``&&``, ``||``, loop tests, labels of a ``switch``.
        call: function calls, inlined or not.
    """

    add: int = 0
    mul: int = 0
    div: int = 0
    cmp: int = 0
    neg: int = 0
    sqrt: int = 0
    convert: int = 0
    other_fp: int = 0
    load: int = 0
    store: int = 0
    int_add: int = 0
    int_mul: int = 0
    int_div: int = 0
    int_cmp: int = 0
    int_load: int = 0
    int_store: int = 0
    branch: int = 0
    call: int = 0

    def as_dict(self) -> dict[str, int]:
        """Class name -> count, in declaration order."""
        return {name: getattr(self, name) for name in CLASSES}

    def __add__(self, other: OperationCounts) -> OperationCounts:
        return OperationCounts(*(getattr(self, n) + getattr(other, n) for n in CLASSES))

    def __mul__(self, times: int) -> OperationCounts:
        return OperationCounts(*(getattr(self, n) * times for n in CLASSES))

    def maximum(self, other: OperationCounts) -> OperationCounts:
        """The larger of both, class by class."""
        return OperationCounts(*(max(getattr(self, n), getattr(other, n)) for n in CLASSES))

    def covers(self, other: OperationCounts) -> bool:
        """True when no class of ``other`` is larger."""
        return all(getattr(self, n) >= getattr(other, n) for n in CLASSES)

    @property
    def floating_point(self) -> int:
        """Arithmetic on scalars: add, mul, div, cmp, neg, sqrt, convert, other."""
        return sum(getattr(self, n) for n in CLASSES[:8])


CLASSES: tuple[str, ...] = tuple(f.name for f in fields(OperationCounts))
INDEX: Mapping[str, int] = {name: i for i, name in enumerate(CLASSES)}


class Cap(NamedTuple):
    """A named bound of a loop, with its value (see ``constants.named_bound``)."""

    name: str
    number: int


class Cost:
    """A mutable sum: a fixed part, and per named bound the part of one turn of its loops.

    Both are lists in the order of ``CLASSES``, since counting adds to them very often. ``loose``
    has a bit for each class of which a run may do less than is counted here; the other classes
    happen in every run just as often.
    """

    __slots__ = ("fixed", "loose", "per_iteration")

    def __init__(self) -> None:
        self.fixed = [0] * len(CLASSES)
        self.per_iteration: dict[Cap, list[int]] = {}
        self.loose = 0

    def hit(self, name: str, times: int = 1) -> None:
        """Count an operation of class ``name`` in the fixed part."""
        self.fixed[INDEX[name]] += times

    def add(self, other: Cost, times: int = 1) -> None:
        """Add ``times`` times the other cost."""
        _add(self.fixed, other.fixed, times)
        for cap, part in other.per_iteration.items():
            _add(self.per_iteration.setdefault(cap, [0] * len(CLASSES)), part, times)
        self.loose |= other.loose

    def raise_to(self, other: Cost) -> None:
        """Take the larger of both in each class of each part: covers either, for every cap."""
        self.loose |= other.loose | _differing(self.fixed, other.fixed)
        for cap in self.per_iteration.keys() | other.per_iteration.keys():
            own = self.per_iteration.setdefault(cap, [0] * len(CLASSES))
            part = other.per_iteration.get(cap, [0] * len(CLASSES))
            self.loose |= _differing(own, part)
            _raise(own, part)
        _raise(self.fixed, other.fixed)

    def loosen(self) -> None:
        """A run may skip any of it."""
        for part in (self.fixed, *self.per_iteration.values()):
            self.loose |= _differing(part, [0] * len(CLASSES))

    def loosen_above(self, sums: list[int]) -> None:
        """A run does no more than this, class by class."""
        twin = self.copy()
        twin.fold()
        self.loose |= _differing(twin.fixed, sums)

    def fold(self) -> None:
        """Named parts go to the fixed part, at the values of their bounds."""
        for cap, part in self.per_iteration.items():
            _add(self.fixed, part, cap.number)
        self.per_iteration.clear()

    def copy(self) -> Cost:
        twin = Cost()
        twin.add(self)
        return twin

    def counts(self) -> tuple[OperationCounts, dict[Cap, OperationCounts]]:
        """Fixed part and the parts of one turn, caps in alphabetical order."""
        per = {cap: OperationCounts(*self.per_iteration[cap]) for cap in sorted(self.per_iteration)}
        return OperationCounts(*self.fixed), per

    def exact(self) -> tuple[str, ...]:
        """Classes of which every run does just what is counted."""
        return tuple(name for name, i in INDEX.items() if not self.loose >> i & 1)


def _add(into: list[int], part: list[int], times: int) -> None:
    for i, n in enumerate(part):
        into[i] += times * n


def _differing(one: list[int], other: list[int]) -> int:
    """A bit for each class that is not equal."""
    return sum(1 << i for i, (a, b) in enumerate(zip(one, other, strict=True)) if a != b)


def _raise(into: list[int], part: list[int]) -> None:
    for i, n in enumerate(part):
        if n > into[i]:
            into[i] = n
