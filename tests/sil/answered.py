"""A reference's answers kept, so that many versions of its C are held against one run of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import Declaration, Reference, Status, Value
from servogen.sil.harness import Agreement, Call, compare
from servogen.sil.scenarios import Scenario

Answer = tuple[Status, dict[str, Value]]


class Replay:
    """Says again what a reference said, call by call, and to the same calls only."""

    def __init__(self, declaration: Declaration, calls: Sequence[Call], answers: Sequence[Answer]):
        self.declaration, self.calls, self.answers = declaration, calls, answers
        self.told = 0

    def call(self, operation: str, inputs: Mapping[str, Value] | None = None) -> Answer:
        """See ``controllers.design.Reference``."""
        asked = self.calls[self.told]
        assert operation == asked.operation
        assert inputs is asked.inputs
        self.told += 1
        return self.answers[self.told - 1]


@dataclass(frozen=True)
class Answered:
    """A scenario and the answers of its reference to every call."""

    name: str
    declaration: Declaration
    calls: Sequence[Call]
    answers: Sequence[Answer]

    def held_against(self, compiled: Reference) -> Agreement:
        """What ``compare`` finds between the reference and this C."""
        return compare(Replay(self.declaration, self.calls, self.answers), compiled, self.calls)


def copied(values: Mapping[str, Value]) -> dict[str, Value]:
    """Arrays are copied: whose they are may use them again."""
    return {k: v.copy() if isinstance(v, np.ndarray) else v for k, v in values.items()}


class Listener:
    """Passes calls on to a reference and keeps them with the answers."""

    def __init__(self, reference: Reference) -> None:
        self.reference, self.declaration = reference, reference.declaration
        self.calls: list[Call] = []
        self.answers: list[Answer] = []

    def call(self, operation: str, inputs: Mapping[str, Value] | None = None) -> Answer:
        """See ``controllers.design.Reference``."""
        kept = copied(inputs or {})
        status, outputs = self.reference.call(operation, kept)
        self.calls.append(Call(operation, kept))
        self.answers.append((status, copied(outputs)))
        return status, outputs

    def answered(self, name: str) -> Answered:
        """Everything up to now."""
        return Answered(name, self.declaration, tuple(self.calls), tuple(self.answers))


def answered(scenarios: Iterable[Scenario]) -> list[Answered]:
    """Every scenario with what its reference says, in their order."""
    told = []
    for name, reference, calls in scenarios:
        listener = Listener(reference())
        for call in calls:
            listener.call(call.operation, call.inputs)
        told.append(listener.answered(name))
    return told
