"""The two ways a run can end badly, and what each tells the user."""

from __future__ import annotations

from pathlib import Path


class ServogenError(Exception):
    """Base of every error servogen raises on purpose. ``exit_status`` is what the command returns."""

    exit_status = 2


class InputError(ServogenError):
    """The user's input was wrong (exit status 2): one sentence naming file, key, value, expectation.

    Args:
        file: the file at fault, or None where the command line is.
        key: dotted key (``machine.x.slow.damping``), entity or line (``line 12``, ``point 3041``).
        value: what stood there.
        expected: what was expected, as the end of "expected ...".
    """

    exit_status = 2

    def __init__(self, file: Path | str | None, key: str, value: object, expected: str) -> None:
        self.file = None if file is None else str(file)
        self.key = key
        self.value = value
        self.expected = expected
        where = f"{self.file}: " if self.file else ""
        shown = "" if value is None else f" is {value!r}" if not isinstance(value, str) else f" is {value}"
        super().__init__(f"{where}{key}{shown}, expected {expected}")


class CheckFailed(ServogenError):
    """A check failed (exit status 1): equivalence, budget or constraint."""

    exit_status = 1
