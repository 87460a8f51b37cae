"""The one equivalence harness: a reference and its C, driven by the same calls, compared.

Decisions (statuses and integer outputs) must be equal; values must agree within a stated bound.
The references compute the same bits as the C, so the bound is zero unless a controller declares
more.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from servogen.controllers.design import Reference, Status, Value
from servogen.precision import FloatArray


@dataclass(frozen=True)
class Call:
    """One operation with its inputs."""

    operation: str
    inputs: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Difference:
    """The first call on which the two parted: which, what, and what each said."""

    index: int
    operation: str
    item: str
    reference: object
    compiled: object

    def __str__(self) -> str:
        return (
            f"call {self.index} ({self.operation}): {self.item} is {self.reference!r} in the "
            f"reference and {self.compiled!r} in the C"
        )


@dataclass
class Agreement:
    """What a comparison found; ``passed`` where no call differed."""

    calls: int = 0
    decisions: int = 0
    worst: float = 0.0
    statuses: dict[str, int] = field(default_factory=dict)
    difference: Difference | None = None

    @property
    def passed(self) -> bool:
        return self.difference is None and self.calls > 0

    def merge(self, other: Agreement) -> None:
        self.calls += other.calls
        self.decisions += other.decisions
        self.worst = max(self.worst, other.worst)
        for name in sorted(other.statuses):
            self.statuses[name] = self.statuses.get(name, 0) + other.statuses[name]
        self.difference = self.difference or other.difference


def compare_outputs(
    agreement: Agreement,
    call: Call,
    first: tuple[Status, Mapping[str, Value]],
    second: tuple[Status, Mapping[str, Value]],
    bound: float,
) -> bool:
    """Count one call in and note the first difference; True while they agree."""
    agreement.calls += 1
    agreement.decisions += 1
    name = first[0].name
    agreement.statuses[name] = agreement.statuses.get(name, 0) + 1
    if first[0] != second[0]:
        _note(agreement, call, "status", first[0].name, second[0].name)
    if first[1].keys() != second[1].keys():
        _note(agreement, call, "list of outputs", sorted(first[1]), sorted(second[1]))
        return False
    for port, expected in first[1].items():
        got = second[1][port]
        if isinstance(expected, int | np.integer):
            agreement.decisions += 1
            if int(expected) != int(np.asarray(got)):
                _note(agreement, call, port, int(expected), int(np.asarray(got)))
            continue
        a, b = np.asarray(expected, dtype=float), np.asarray(got, dtype=float)
        if np.array_equal(a, b):
            continue
        gap = float(np.max(np.abs(a - b)))
        agreement.worst = max(agreement.worst, gap)
        if not gap <= bound:
            _note(agreement, call, port, expected, got)
    return agreement.difference is None


def _note(agreement: Agreement, call: Call, item: str, first: object, second: object) -> None:
    if agreement.difference is None:
        agreement.difference = Difference(agreement.calls - 1, call.operation, item, first, second)


def compare(
    reference: Reference, compiled: Reference, calls: Iterable[Call], bound: float = 0.0
) -> Agreement:
    """Make every call on both; stop at the first difference."""
    agreement = Agreement()
    for call in calls:
        first = reference.call(call.operation, call.inputs)
        second = compiled.call(call.operation, call.inputs)
        if not compare_outputs(agreement, call, first, second, bound):
            break
    return agreement


class Repeating(Reference, Protocol):
    """A controller that can run an operation without inputs many times."""

    def repeat(self, operation: str, count: int) -> FloatArray:
        """(count, outputs)."""


class Stepwise:
    """A reference that repeats an operation call by call, unless it has a way of its own."""

    def __init__(self, reference: Reference) -> None:
        self.reference, self.declaration = reference, reference.declaration

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        """See ``Reference``."""
        return self.reference.call(operation, inputs)

    def repeat(self, operation: str, count: int) -> FloatArray:
        """See ``Repeating``."""
        own = getattr(self.reference, "repeat", None)
        if own is not None:
            found: FloatArray = own(operation, count)
            return found
        rows = [list(self.call(operation)[1].values()) for _ in range(count)]
        return np.array(rows, dtype=self.declaration.precision.dtype)


class Twin:
    """Both controllers behind one ``call``: a closed loop runs on the C, the reference follows."""

    def __init__(self, reference: Repeating, compiled: Repeating, bound: float = 0.0) -> None:
        self.reference, self.compiled, self.bound = reference, compiled, bound
        self.declaration = compiled.declaration
        self.agreement = Agreement()

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = dict(inputs or {})
        first = self.reference.call(operation, given)
        second = self.compiled.call(operation, given)
        if self.agreement.difference is None:
            compare_outputs(self.agreement, Call(operation, given), first, second, self.bound)
        return second

    def repeat(self, operation: str, count: int) -> FloatArray:
        """Outputs of ``count`` calls, as the C gives them; both are compared."""
        first = self.reference.repeat(operation, count)
        second = self.compiled.repeat(operation, count)
        agreement = self.agreement
        agreement.calls += count
        agreement.decisions += count
        if np.array_equal(first, second):
            return second
        gaps = np.abs(first.astype(float) - second.astype(float))
        agreement.worst = max(agreement.worst, float(np.max(gaps)))
        if agreement.difference is None and not np.all(gaps <= self.bound):
            row, column = np.argwhere(~(gaps <= self.bound))[0]
            port = self.declaration.operation(operation).outputs[int(column)].name
            agreement.difference = Difference(
                agreement.calls - count + int(row),
                operation,
                port,
                float(first[row, column]),
                float(second[row, column]),
            )
        return second
