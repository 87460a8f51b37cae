"""From the TOML file of a command governor to a GovernorProject: read, validated, resolved once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from servogen.errors import InputError
from servogen.project.governor_consistency import check_governor
from servogen.project.governor_machine import GovernedMachine
from servogen.project.governor_schema import GovernorController, GovernorFile, GovernorTarget
from servogen.project.machine import AxisLikeX
from servogen.project.schema import Output, PathTable, Sampling
from servogen.project.toml_text import read_toml
from servogen.project.translate import to_input_error, value_text

_FLOAT32_MARGIN = 1e-5


@dataclass(frozen=True)
class GovernorProject:
    """A validated project, in SI units; its fields mirror the tables of the file.

    Attributes:
        file: the project file as it was named to ``load_governor_project``.
        machine: both axes, y resolved.
        path: ``path.file`` is resolved against the project file's folder, as are the files of
            ``model = "python"``.
    """

    file: Path
    name: str
    system: str
    machine: GovernedMachine
    sampling: Sampling
    controller: GovernorController
    path: PathTable
    output: Output
    target: GovernorTarget

    @property
    def sources(self) -> tuple[Path, ...]:
        """Every file that the machine is made from: this one, the drawing, models in Python."""
        stages = [axis.slow for _, axis in self.machine.axes]
        models = [Path(stage.file) for stage in stages if stage.model == "python"]
        return (self.file, Path(self.path.file), *models)

    def error(self, key: str, value: object, expected: str) -> InputError:
        """An InputError about a key of this project's file, to be raised by the caller."""
        return InputError(self.file, key, value_text(value), expected)


def load_governor_project(path: Path) -> GovernorProject:
    """Read and validate the project file of a command governor.

    Raises:
        InputError: the file cannot be read, is no TOML, or breaks the schema or a relation
            between its keys. Plants, sets and drawing are judged later, in
            ``systems.command_governor``.
    """
    path = Path(path)
    try:
        return _build(path, read_toml(path))
    except RecursionError:
        raise InputError(path, "the file", None, "tables nested a few levels deep") from None


def _build(path: Path, raw: dict[str, Any]) -> GovernorProject:
    try:
        found = GovernorFile.model_validate(raw, context={"folder": path.parent})
    except ValidationError as error:
        raise to_input_error(path, raw, error, GovernorFile) from None
    y = found.machine.x if isinstance(found.machine.y, AxisLikeX) else found.machine.y
    project = GovernorProject(
        file=path,
        name=found.name,
        system=found.system,
        machine=GovernedMachine(x=found.machine.x, y=y),
        sampling=found.sampling,
        controller=_with_margin(found.controller, found.output),
        path=found.path,
        output=found.output,
        target=found.target,
    )
    check_governor(project)
    return project


def _with_margin(controller: GovernorController, output: Output) -> GovernorController:
    """The margin that float32 can honour, where the file leaves it open."""
    solver = controller.solver
    if output.precision != "float32" or "constraint_margin" in solver.model_fields_set:
        return controller
    wider = solver.model_copy(update={"constraint_margin": _FLOAT32_MARGIN})
    return controller.model_copy(update={"solver": wider})
