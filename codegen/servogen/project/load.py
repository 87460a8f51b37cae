"""From a TOML file to a Project: read, validated and resolved once; after it everything is typed.

Every fault is an InputError that names file, key, value and what was expected.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from servogen.errors import InputError
from servogen.project.consistency import check_consistency
from servogen.project.machine import AxisLikeX, Machine
from servogen.project.schema import (
    Controller,
    Output,
    PathTable,
    ProjectFile,
    Sampling,
    Target,
)
from servogen.project.translate import to_input_error, value_text

_LARGEST_FILE = 1_000_000  # bytes; a project file has a few kilobytes
_FLOAT32_MARGIN = 1e-5


@dataclass(frozen=True)
class Project:
    """A validated project, in SI units; its fields mirror the tables of the file.

    Attributes:
        file: the project file as it was named to ``load_project``.
        name: C identifier, prefix of all emitted names.
        system: which system the machine is ("two_stage").
        machine: both axes, y resolved.
        path: ``path.file`` is resolved against the project file's folder, as are the files of
            ``model = "python"``.
    """

    file: Path
    name: str
    system: str
    machine: Machine
    sampling: Sampling
    controller: Controller
    path: PathTable
    output: Output
    target: Target

    def resolve(self, name: str) -> Path:
        """A file that the project names, relative to the project file's folder."""
        return self.file.parent / name

    def error(self, key: str, value: object, expected: str) -> InputError:
        """An InputError about a key of this project's file, to be raised by the caller."""
        return InputError(self.file, key, value_text(value), expected)


def load_project(path: Path) -> Project:
    """Read and validate a project file.

    Raises:
        InputError: the file cannot be read, is no TOML, or breaks the schema or a relation
            between its keys. Plants and drawing are judged later, in ``systems.judgement``.
    """
    path = Path(path)
    try:
        return _build(path, _parse(path, _read_text(path)))
    except RecursionError:
        raise InputError(path, "the file", None, "tables nested a few levels deep") from None


def _build(path: Path, raw: dict[str, Any]) -> Project:
    try:
        found = ProjectFile.model_validate(raw, context={"folder": path.parent})
    except ValidationError as error:
        raise to_input_error(path, raw, error) from None
    y = found.machine.x if isinstance(found.machine.y, AxisLikeX) else found.machine.y
    project = Project(
        file=path,
        name=found.name,
        system=found.system,
        machine=Machine(x=found.machine.x, y=y),
        sampling=found.sampling,
        controller=_with_margin(found.controller, found.output),
        path=found.path,
        output=found.output,
        target=found.target,
    )
    check_consistency(project)
    return project


def _with_margin(controller: Controller, output: Output) -> Controller:
    """The margin that float32 can honour, where the file leaves it open."""
    solver = controller.solver
    if output.precision != "float32" or "constraint_margin" in solver.model_fields_set:
        return controller
    wider = solver.model_copy(update={"constraint_margin": _FLOAT32_MARGIN})
    return controller.model_copy(update={"solver": wider})


def _read_text(path: Path) -> str:
    try:
        if path.is_dir():
            raise InputError(path, "the project file", "a folder", "a TOML file")
        if path.stat().st_size > _LARGEST_FILE:
            size = f"{path.stat().st_size} bytes"
            raise InputError(path, "its size", size, f"at most {_LARGEST_FILE} bytes")
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(path, "the project file", "missing", "a TOML file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        told = f"unreadable ({reason})"
        raise InputError(path, "the project file", told, "a readable TOML file") from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        byte = f"the byte 0x{data[error.start]:02x}"
        raise InputError(path, f"line {line}", byte, "text in UTF-8") from None


def _parse(path: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
    except ValueError:  # Python's own limit on the digits of a whole number
        digits = "a whole number of thousands of digits"
        raise InputError(path, "a value", digits, "one that a machine can have") from None
    at = re.search(r" \(at (?:line (\d+), column \d+|end of document)\)$", message)
    reason = message[: at.start()] if at else message
    lines = text.splitlines() or [""]
    number = int(at[1]) if at and at[1] else len(lines)
    line = lines[min(number, len(lines)) - 1].strip()
    expected = f"valid TOML: {reason[:1].lower()}{reason[1:]}"
    raise InputError(path, f"line {number}", value_text(line), expected)
