"""Listens to a controller and keeps the calls, so that they can be played again elsewhere."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.design import Status, Value
from servogen.precision import FloatArray
from servogen.sil.harness import Call, Repeating
from servogen.sil.player import Play


class Recorder:
    """A controller that passes every call on and remembers it."""

    def __init__(self, controller: Repeating) -> None:
        self.controller, self.declaration = controller, controller.declaration
        self._calls: list[Call] = []
        self._repeats: list[int] = []

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        """See ``controllers.design.Reference``; arrays are copied, the caller may reuse them."""
        kept = {k: v.copy() if isinstance(v, np.ndarray) else v for k, v in (inputs or {}).items()}
        self._note(operation, kept, 1)
        return self.controller.call(operation, kept)

    def repeat(self, operation: str, count: int) -> FloatArray:
        """See ``harness.Repeating``."""
        self._note(operation, {}, count)
        return self.controller.repeat(operation, count)

    def play(self, name: str) -> Play:
        """Everything up to now."""
        return Play(name, self.declaration.prefix, tuple(self._calls), tuple(self._repeats))

    def _note(self, operation: str, inputs: Mapping[str, Value], times: int) -> None:
        self._calls.append(Call(operation, inputs))
        self._repeats.append(times)
