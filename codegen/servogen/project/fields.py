"""Building blocks of the project file's schema: strict models, quantities, and how both are told.

A key carries its unit at its end (``range_m``, ``sample_time_s``), and every field its range and
one line of documentation; messages and docs/project-file.md are made from these alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo
from pydantic.fields import FieldInfo

# Longest first, so that "acceleration_limit_m_per_s2" does not end at "_s2" or "_m".
UNITS = {
    "n_m_s_per_rad": "N m s/rad",
    "ma_s_per_deg": "mA s/deg",
    "n_m_per_rad": "N m/rad",
    "deg_per_s2": "deg/s^2",
    "n_m_per_a": "N m/A",
    "deg_per_s": "deg/s",
    "rad_per_s": "rad/s",
    "m_per_s2": "m/s^2",
    "m_per_s": "m/s",
    "kg_m2": "kg m^2",
    "per_s": "1/s",
    "deg": "deg",
    "n_m": "N m",
    "ma": "mA",
    "hz": "Hz",
    "m": "m",
    "s": "s",
}


class Section(BaseModel):
    """A table of the project file: immutable, no unknown keys, no silent conversions, finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def _tuple_from_list(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


def _no_truth(value: object) -> object:
    if isinstance(value, bool):  # true == 1
        raise ValueError("no number")
    return value


def _resolve(value: object, info: ValidationInfo) -> object:
    """Names of files are relative to the project file, wherever the command is run."""
    if not isinstance(value, str) or not value or "\0" in value:
        raise ValueError("the name of a file")
    folder = (info.context or {}).get("folder")
    return Path(value) if folder is None else folder / value


Vector = Annotated[tuple[float, ...], BeforeValidator(_tuple_from_list), Field(min_length=1)]
Integers = Annotated[tuple[int, ...], BeforeValidator(_tuple_from_list), Field(min_length=1)]
Matrix = Annotated[tuple[Vector, ...], BeforeValidator(_tuple_from_list), Field(min_length=1)]
Version = Annotated[Literal[1], BeforeValidator(_no_truth)]
FileName = Annotated[Path, BeforeValidator(_resolve)]


def unit_of(key: str) -> str | None:
    """Unit that a key's ending stands for, None for a key without one."""
    return next((unit for end, unit in UNITS.items() if key.endswith("_" + end)), None)


def bounds_text(field: FieldInfo) -> str:
    """Range of a field in words, empty where there is none: ``above 0 and at most 5``."""
    words = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
    found = [
        f"{word} {_number(getattr(entry, name))}"
        for name, word in words.items()
        for entry in field.metadata
        if getattr(entry, name, None) is not None
    ]
    return " and ".join(found)


def expected_text(key: str, field: FieldInfo) -> str:
    """What a field takes, as the end of a sentence "... expected <this>"."""
    extra = field.json_schema_extra
    if isinstance(extra, dict) and "expected" in extra:
        return str(extra["expected"])
    unit = unit_of(key)
    noun = _noun(field.annotation)
    return " ".join(filter(None, [noun, bounds_text(field), f"({unit})" if unit else ""]))


def told(expected: str, **limits: Any) -> Any:
    """A Field whose expectation is said in these words rather than made from type and range."""
    return Field(json_schema_extra={"expected": expected}, **limits)


def one_of(names: Sequence[object]) -> str:
    """``"a", "b" or "c"``."""
    quoted = [f'"{name}"' if isinstance(name, str) else str(name) for name in names]
    return quoted[0] if len(quoted) == 1 else ", ".join(quoted[:-1]) + " or " + quoted[-1]


def _noun(annotation: Any) -> str:
    if get_origin(annotation) is Literal:
        return one_of(get_args(annotation))
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "a table"
    names = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
    if annotation in names:
        return names[annotation]
    if get_origin(annotation) is dict:
        return "a table of names and numbers"
    if annotation is Path:
        return "the name of a file"
    return "a list of numbers" if get_origin(annotation) is tuple else "a table"


def _number(value: float) -> str:
    whole = math.isfinite(value) and value == int(value) and abs(value) < 1e6
    return str(int(value)) if whole else f"{value:g}"
