"""The one error of the explicit solutions, in parts that a project check can place."""

from __future__ import annotations


class ExplicitError(ValueError):
    """A parametric program, solution or lookup that cannot be built.

    The parts are those of ``servogen.errors.InputError``; the project check adds file and table.

    Args:
        key: the quantity at fault (``hessian``, ``regions``, ``first_move``, ...).
        value: what it was, or None where it says nothing.
        expected: what was expected, as the end of "expected ...".
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        self.key = key
        self.value = value
        self.expected = expected
        shown = "" if value is None else f" is {value}"
        super().__init__(f"{key}{shown}, expected {expected}")
