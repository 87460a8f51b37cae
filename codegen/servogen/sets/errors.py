"""The one error of the sets, in parts that a project check can place."""

from __future__ import annotations


class SetError(ValueError):
    """A constraint set that cannot be built: empty, unbounded, or not finitely determined.

    The parts are those of ``servogen.errors.InputError``; the project check adds file and table.

    Args:
        key: the quantity at fault (``steady_state_tightening``, ``position_limit_m``, ...).
        value: what it was, or None where it says nothing.
        expected: what was expected, as the end of "expected ...".
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        self.key = key
        self.value = value
        self.expected = expected
        shown = "" if value is None else f" is {value}"
        super().__init__(f"{key}{shown}, expected {expected}")


class EmptySetError(SetError):
    """A set without a point, where one is needed: told from a program that found no answer."""
