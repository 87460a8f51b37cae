"""Processors: clock, memory and the cycles of each class of operation, from TOML files."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from servogen.errors import InputError
from servogen.wcet.operations import CLASSES, OperationCounts

PRECISIONS = ("float32", "float64")
REAL_CLASSES = ("add", "mul", "div", "cmp", "neg", "sqrt", "convert", "other_fp", "load", "store")
COMMON_CLASSES = tuple(name for name in CLASSES if name not in REAL_CLASSES)

_TOP = ("name", "description", "clock_hz", "int_bits", "memory", "cycles")
_MEMORY = ("data_bytes", "program_bytes", "together_bytes")
_FOLDER = Path(__file__).resolve().parent / "targets"
_INT_BITS = 32


@dataclass(frozen=True)
class Number:
    """A number with where it comes from: a manual, or the word estimate."""

    value: float
    source: str


@dataclass(frozen=True)
class Target:
    """A processor as the budget sees it.

    Attributes:
        name: name of its file.
        description: one line for people.
        clock_hz: cycles per second of one core.
        data_bytes: memory for tables and state.
        program_bytes: memory for code (and tables, where it is flash).
        together_bytes: where data and tables lie in the same memory, its size.
        int_bits: of its compiler's int.
        cycles: precision -> class of operation -> cycles; a precision may be missing.
    """

    name: str
    description: str
    clock_hz: Number
    data_bytes: Number
    program_bytes: Number
    cycles: Mapping[str, Mapping[str, Number]]
    together_bytes: Number | None = None
    int_bits: int = _INT_BITS

    def cost(self, counts: OperationCounts, precision: str) -> float:
        """Cycles of these operations: the sum over the classes of count times cycles.

        Raises:
            InputError: the target states no cycles for this precision.
        """
        if precision not in self.cycles:
            known = " or ".join(f"'{p}'" for p in self.cycles)
            raise InputError(
                None, "output.precision", precision, f"{known}: target '{self.name}' has no other"
            )
        table = self.cycles[precision]
        return math.fsum(n * table[name].value for name, n in counts.as_dict().items())


def bundled_targets() -> tuple[str, ...]:
    """Names of the targets that come with servogen."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def target_file(name_or_path: str | Path, base: Path | None = None) -> Path:
    """Where ``load_target`` reads a target from."""
    bundled = str(name_or_path) in bundled_targets()
    return _FOLDER / f"{name_or_path}.toml" if bundled else (base or Path()) / name_or_path


def load_target(name_or_path: str | Path, base: Path | None = None) -> Target:
    """A bundled target by name, or any from a TOML file of the same form.

    Args:
        name_or_path: bundled name, or path.
        base: folder that a relative path starts from (default: the current one).

    Raises:
        InputError: no such target, or a key that is missing, unknown or no number.
    """
    text = str(name_or_path)
    path = target_file(name_or_path, base)
    if text not in bundled_targets() and (path.suffix != ".toml" or not path.is_file()):
        known = ", ".join(bundled_targets())
        raise InputError(None, "target.name", text, f"one of {known}, or a TOML file")
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, "file", None, f"TOML ({error})") from error
    except OSError as error:
        raise InputError(path, "file", None, f"to be readable ({error.strerror})") from error
    return _Reader(path).target(data)


class _Reader:
    def __init__(self, path: Path) -> None:
        self.path = path

    def target(self, data: dict[str, object]) -> Target:
        self.keys(data, _TOP, "")
        memory = self.table(data, "memory", "memory")
        self.keys(memory, _MEMORY, "memory.")
        return Target(
            name=self.text(data, "name"),
            description=self.text(data, "description"),
            clock_hz=self.number(data, "clock_hz", "clock_hz", positive=True),
            data_bytes=self.number(memory, "data_bytes", "memory.data_bytes", positive=True),
            program_bytes=self.number(
                memory, "program_bytes", "memory.program_bytes", positive=True
            ),
            cycles=self.cycles(self.table(data, "cycles", "cycles")),
            together_bytes=self.number(
                memory, "together_bytes", "memory.together_bytes", positive=True
            )
            if "together_bytes" in memory
            else None,
            int_bits=int(self.number(data, "int_bits", "int_bits", positive=True).value)
            if "int_bits" in data
            else _INT_BITS,
        )

    def cycles(self, data: dict[str, object]) -> dict[str, dict[str, Number]]:
        common = self.classes(data, "common", COMMON_CLASSES)
        found = {p: common | self.classes(data, p, REAL_CLASSES) for p in PRECISIONS if p in data}
        if not found:
            raise InputError(self.path, "cycles", None, "a table 'float32' or 'float64'")
        self.keys(data, ("common", *found), "cycles.")
        return found

    def classes(
        self, data: dict[str, object], key: str, names: tuple[str, ...]
    ) -> dict[str, Number]:
        table = self.table(data, key, f"cycles.{key}")
        self.keys(table, names, f"cycles.{key}.")
        return {name: self.number(table, name, f"cycles.{key}.{name}") for name in names}

    def keys(self, data: dict[str, object], names: tuple[str, ...], prefix: str) -> None:
        for key in data:
            if key not in names:
                expected = "one of " + ", ".join(names)
                raise InputError(self.path, f"{prefix}{key}", "unknown", expected)

    def table(self, data: dict[str, object], key: str, full: str) -> dict[str, object]:
        found = data.get(key)
        if not isinstance(found, dict):
            raise InputError(self.path, full, found if key in data else "missing", "a table")
        return found

    def text(self, data: dict[str, object], key: str) -> str:
        found = data.get(key)
        if not isinstance(found, str) or not found:
            raise InputError(self.path, key, found if key in data else "missing", "some text")
        return found

    def number(
        self, data: dict[str, object], key: str, full: str, positive: bool = False
    ) -> Number:
        """``key = { value = 3, source = "..." }``: no number without a source."""
        table = self.table(data, key, full)
        self.keys(table, ("value", "source"), f"{full}.")
        value = table.get("value")
        expected = "a positive number" if positive else "a number that is not negative"
        wrong = isinstance(value, bool) or not isinstance(value, int | float)
        if wrong or not math.isfinite(float(str(value))) or float(str(value)) < 0:
            shown = value if "value" in table else "missing"
            raise InputError(self.path, f"{full}.value", shown, expected)
        if positive and float(str(value)) == 0:
            raise InputError(self.path, f"{full}.value", value, expected)
        source = table.get("source")
        if not isinstance(source, str) or not source:
            raise InputError(self.path, f"{full}.source", "missing", "the manual, or an estimate")
        return Number(float(str(value)), source)
