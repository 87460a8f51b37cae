"""The one error of the plants: what is wrong with a model, in parts a project check can place."""

from __future__ import annotations


class PlantError(ValueError):
    """A model that cannot be used.

    The parts are those of ``servogen.errors.InputError``, so that the project check only adds the
    file and the table: ``InputError(file, f"machine.x.slow.{e.key}", e.value, e.expected)``.

    Args:
        key: the setting at fault (``damping``, ``denominator``, ``file``, ...).
        value: what stood there, or None where it says nothing.
        expected: what was expected, as the end of "expected ...".
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        self.key = key
        self.value = value
        self.expected = expected
        shown = "" if value is None else f" is {value}"
        super().__init__(f"{key}{shown}, expected {expected}")
