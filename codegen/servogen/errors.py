"""The two ways a run can end badly, and what each tells the user."""

from __future__ import annotations

from pathlib import Path


class ServogenError(Exception):
    """Base of every error raised on purpose; ``exit_status`` is what the command returns."""

    exit_status = 2


class InputError(ServogenError):
    """The user's input was wrong: one sentence with file, key, value and expectation.

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
        text = value if isinstance(value, str) else repr(value)
        shown = "" if value is None else f" is {text}"
        super().__init__(f"{where}{key}{shown}, expected {expected}")


class CheckFailed(ServogenError):
    """A check failed (exit status 1): equivalence, budget or constraint."""

    exit_status = 1
