"""The processor that a project names."""

from __future__ import annotations

from servogen.project.systems import AnyProject
from servogen.systems.judgement import of_the_project
from servogen.wcet.targets import Target, load_target


def check_target(project: AnyProject) -> Target:
    """Read the description of the processor.

    Raises:
        InputError: there is none of that name, it is faulty, or has no cycles for the precision.
    """
    with of_the_project(project):
        target = project_target(project)
    precision = project.output.precision
    if precision not in target.cycles:
        known = " or ".join(f'"{name}"' for name in target.cycles)
        expected = f"{known}, all that target {target.name} has cycles for"
        raise project.error("output.precision", precision, expected)
    return target


def project_target(project: AnyProject, name: str | None = None) -> Target:
    """The target named, or the project's."""
    return load_target(name or project.target.name, project.file.parent)
