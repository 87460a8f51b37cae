"""From the TOML file of a contour controller to a ContourProject: read, validated, resolved."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from servogen.errors import InputError
from servogen.project.contour_consistency import check_contour
from servogen.project.contour_machine import ContourAxisTable
from servogen.project.contour_schema import (
    ButterflyContour,
    CircleContour,
    ContourController,
    ContourFile,
    ContourPath,
    ContourSampling,
    ContourTarget,
)
from servogen.project.schema import Output
from servogen.project.toml_text import read_toml
from servogen.project.translate import to_input_error, value_text


@dataclass(frozen=True)
class ContourProject:
    """A validated project, in SI units; its fields mirror the tables of the file.

    Attributes:
        file: the project file as it was named to ``load_contour_project``.
        axes: by name, those that are alike resolved.
        contour: a curve or a drawing, one of them.
    """

    file: Path
    name: str
    system: str
    axes: tuple[tuple[str, ContourAxisTable], ...]
    sampling: ContourSampling
    controller: ContourController
    contour: CircleContour | ButterflyContour | ContourPath
    output: Output
    target: ContourTarget

    @property
    def sources(self) -> tuple[Path, ...]:
        """Every file that the machine is made from: this one and the drawing, if there is one."""
        if isinstance(self.contour, ContourPath):
            return (self.file, Path(self.contour.file))
        return (self.file,)

    def error(self, key: str, value: object, expected: str) -> InputError:
        """An InputError about a key of this project's file, to be raised by the caller."""
        return InputError(self.file, key, value_text(value), expected)

    def fault(self, key: str, said: object, expected: str) -> InputError:
        """The same about what was found out beyond the file: words are told as they are."""
        told = said if said is None or isinstance(said, str) else value_text(said)
        return InputError(self.file, key, told, expected)


def load_contour_project(path: Path) -> ContourProject:
    """Read and validate the project file of a contour controller.

    Raises:
        InputError: the file cannot be read, is no TOML, or breaks the schema or a relation
            between its keys. Axes, design and contour are judged later, in
            ``systems.contour_machine``.
    """
    path = Path(path)
    try:
        return _build(path, read_toml(path))
    except RecursionError:
        raise InputError(path, "the file", None, "tables nested a few levels deep") from None


def _build(path: Path, raw: dict[str, Any]) -> ContourProject:
    try:
        found = ContourFile.model_validate(raw, context={"folder": path.parent})
    except ValidationError as error:
        raise to_input_error(path, raw, error, ContourFile) from None
    contour = found.contour or found.path
    if contour is None:
        expected = "a table: a curve, or a drawing in [path] in place of it"
        raise InputError(path, "contour", "missing", expected)
    if found.contour is not None and found.path is not None:
        raise InputError(path, "path", "a table", "none beside [contour]: a drawing or a curve")
    project = ContourProject(
        file=path,
        name=found.name,
        system=found.system,
        axes=found.machine.resolved,
        sampling=found.sampling,
        controller=found.controller,
        contour=contour,
        output=found.output,
        target=found.target,
    )
    check_contour(project)
    return project
