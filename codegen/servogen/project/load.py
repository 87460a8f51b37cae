"""From a TOML file to a Project: read, validated and resolved once; after it everything is typed.

Every fault is an InputError that names file, key, value and what was expected.
"""

from __future__ import annotations

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
from servogen.project.toml_text import read_toml
from servogen.project.translate import to_input_error, value_text

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
        return _build(path, read_toml(path))
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
