"""The tables of a project file with an extended command governor (``system = "command_governor"``).

SI units throughout. Defaults are those of paper 4.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from servogen.identifiers import MAX_LENGTH
from servogen.project.fields import Section, Version, told
from servogen.project.governor_machine import GovernedMachineFile
from servogen.project.schema import (
    MAX_HORIZON,
    MAX_ITERATIONS,
    Output,
    PathTable,
    Sampling,
    identifier,
)

# The window of points that a plan can use is an array of the emitted C's arguments, twice for each
# axis.
MOST_WINDOW = 200_000
# With one or two iterations a period drawings go on as well, but stand for most of the time.
LEAST_CAP = 3


class Motion(Section):
    """Where the slow stage is sent: the reference that the governor follows."""

    reference: Annotated[
        Literal["minimal_motion", "pattern"],
        Field(
            description="the least motion (19)-(20) from which the fast stage reaches the pattern, "
            "or the pattern itself"
        ),
    ] = "minimal_motion"
    stroke_reserve_m: Annotated[
        float,
        Field(gt=0, le=1, description="eps of (19), part of the stroke that it leaves unused"),
    ] = 0.001
    streamed_window: Annotated[
        int,
        Field(
            ge=0,
            le=MOST_WINDOW,
            description="points known ahead of a reference by the C that makes the motion while "
            "the path is streamed, emitted with the governor; 0: none, the motion is made of the "
            "whole drawing",
        ),
    ] = 0


class GovernorTable(Section):
    """The extended command governor (17)-(18)."""

    horizon: Annotated[
        int, Field(ge=1, le=MAX_HORIZON, description="n of (13), slow periods of the register")
    ] = 40
    sub_samples: Annotated[
        int, Field(ge=1, le=20, description="N of (12), instants of a period with constraints")
    ] = 3
    steady_state_tightening: Annotated[
        float,
        Field(ge=1e-6, le=0.5, description="eps of V' = (1 - eps) V, where commands may end"),
    ] = 0.005
    weight_auxiliary: Annotated[
        float, Field(ge=1e-6, le=1e6, description="Q of (17), on each of its entries")
    ] = 1.0
    weight_reference: Annotated[
        float, Field(ge=1e-6, le=1e6, description="R of (17), on the last command")
    ] = 0.01
    reference_index: Annotated[
        Literal["after", "at"],
        Field(
            description="r of (21) is the first point after those machined in a period, l + 1, or "
            "the first of them, l"
        ),
    ] = "after"
    points_ahead: Annotated[
        Literal["all"] | Annotated[int, Field(ge=1, le=MOST_WINDOW)],
        told(
            f'a whole number from 1 to {MOST_WINDOW} or "all"',
            description="of the path, that a plan looks at, more than M; all: as many as its "
            "periods could take, (horizon + 1) M + 1",
        ),
    ] = "all"
    sub_step_stroke: Annotated[
        bool, Field(description="the stroke is kept at the N instants, not at their ends alone")
    ] = False
    stroke_margin_m: Annotated[
        float, Field(ge=0, le=1, description="the governor's stroke is shorter by so much")
    ] = 0.0


class GovernorSolver(Section):
    """The dual active-set method that solves (17), one program an axis."""

    iteration_cap: Annotated[
        Literal["target"] | Annotated[int, Field(ge=LEAST_CAP, le=MAX_ITERATIONS)],
        told(
            f'a whole number from {LEAST_CAP} to {MAX_ITERATIONS} or "target"',
            description="iterations, then the plan before, moved on; target: as many as fit its "
            "budget",
        ),
    ] = "target"
    constraint_margin: Annotated[
        float,
        Field(ge=0, le=0.01, description="tightening of the rows; 1e-5 by default with float32"),
    ] = 1e-6


class Baseline(Section):
    """The low pass of the comparison; its feed is the highest one that keeps every limit."""

    cutoff_hz: Annotated[float, Field(gt=0, le=1e4, description="of the low-pass filter")] = 2.0


class GovernorController(Section):
    """The table ``[controller]``."""

    motion: Motion = Motion()
    governor: GovernorTable = GovernorTable()
    solver: GovernorSolver = GovernorSolver()
    low_pass: Baseline = Baseline()


class GovernorTarget(Section):
    """The processor."""

    name: Annotated[
        str,
        told(
            "the name of a target or of a TOML file that describes one",
            description="a bundled target, or a TOML file relative to this project file",
            min_length=1,
        ),
    ] = "tms320c6678"
    share: Annotated[
        float, Field(gt=0, le=1, description="of every slow period, for the governor of both axes")
    ] = 0.5


class GovernorFile(Section):
    """The whole file as it stands."""

    schema_version: Annotated[
        Version, Field(alias="schema", description="version of this file's format")
    ]
    name: Annotated[
        str,
        AfterValidator(identifier),
        told(
            f"a C identifier of at most {MAX_LENGTH} letters, digits and _, no keyword, not the "
            "name of a standard header or (with _t) type, not beginning with sg_",
            description="prefix of all emitted names",
        ),
    ]
    system: Annotated[
        Literal["command_governor"], Field(description="which of the systems this machine is")
    ]
    machine: GovernedMachineFile
    sampling: Sampling
    controller: GovernorController = GovernorController()
    path: PathTable
    output: Output = Output()
    target: GovernorTarget = GovernorTarget()
