"""The project file: TOML in, one frozen and typed Project in SI units out."""

from servogen.project.load import Project, load_project
from servogen.project.machine import (
    Axis,
    FastPython,
    FastServo,
    FastStage,
    FastStateSpace,
    FastTransferFunction,
    Machine,
    SlowPython,
    SlowServo,
    SlowStage,
    SlowStateSpace,
    SlowTransferFunction,
)
from servogen.project.schema import (
    Controller,
    Governor,
    Mpc,
    Output,
    PathTable,
    Sampling,
    Solver,
    Target,
)

__all__ = [
    "Axis",
    "Controller",
    "FastPython",
    "FastServo",
    "FastStage",
    "FastStateSpace",
    "FastTransferFunction",
    "Governor",
    "Machine",
    "Mpc",
    "Output",
    "PathTable",
    "Project",
    "Sampling",
    "SlowPython",
    "SlowServo",
    "SlowStage",
    "SlowStateSpace",
    "SlowTransferFunction",
    "Solver",
    "Target",
    "load_project",
]
