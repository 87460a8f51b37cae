"""A project file of whichever system it says it is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from servogen.errors import InputError
from servogen.project.contour_load import ContourProject, load_contour_project
from servogen.project.fields import one_of
from servogen.project.governor_load import GovernorProject, load_governor_project
from servogen.project.load import Project, load_project
from servogen.project.servo_load import ServoProject, load_servo_project
from servogen.project.toml_text import read_toml
from servogen.project.translate import value_text

AnyProject = Project | ServoProject | GovernorProject | ContourProject
_LOADERS: dict[str, Callable[[Path], AnyProject]] = {
    "two_stage": load_project,
    "servo_drive": load_servo_project,
    "command_governor": load_governor_project,
    "contour_lq": load_contour_project,
}
SYSTEMS = tuple(_LOADERS)


def load_any_project(path: Path) -> AnyProject:
    """Read and validate a project file by its key ``system``.

    Raises:
        InputError: as the loader of the system, or a system that is none.
    """
    path = Path(path)
    try:
        system = read_toml(path).get("system", "two_stage")
    except RecursionError:
        raise InputError(path, "the file", None, "tables nested a few levels deep") from None
    if system not in SYSTEMS:
        raise InputError(path, "system", value_text(system), one_of(SYSTEMS))
    return _LOADERS[system](path)
