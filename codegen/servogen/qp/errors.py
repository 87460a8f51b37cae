"""What can go wrong with a program: it cannot be used, or numbers end its solution."""

from __future__ import annotations

from servogen.errors import ServogenError


class ProgramError(ValueError):
    """A parametric program that cannot be used.

    The parts are those of ``servogen.errors.InputError``; the project check adds file and table.

    Args:
        key: the quantity at fault (``hessian``, ``linear``, ``first_move``, ...).
        value: what it was, or None where it says nothing.
        expected: what was expected, as the end of "expected ...".
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        self.key = key
        self.value = value
        self.expected = expected
        shown = "" if value is None else f" is {value}"
        super().__init__(f"{key}{shown}, expected {expected}")


class NotSolved(ServogenError, ArithmeticError):
    """A method that always ends used up the steps that it is allowed, which rounding alone can
    cause; the message is one sentence."""
