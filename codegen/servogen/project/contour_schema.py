"""The tables of a project file with contour control (``system = "contour_lq"``).

SI units throughout; commands are in the unit of the drive. Defaults are those of paper 2.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from servogen.identifiers import MAX_LENGTH
from servogen.project.contour_machine import ContourMachineFile
from servogen.project.fields import Section, Version, told
from servogen.project.schema import Output, PathTable, identifier

# The law's cost grows with the third power of it.
MOST_PREVIEW = 60
MOST_ENTRIES = 4096


class ContourSampling(Section):
    """The controller's period."""

    sample_time_s: Annotated[
        float, Field(ge=1e-6, le=1, description="T_s, of controller and contour")
    ]


class ContourTable(Section):
    """The receding-horizon controller (3)-(13)."""

    tracking_weight: Annotated[
        float, Field(gt=0, le=1e15, description="alpha of (7), on every error, per square metre")
    ]
    contour_weight: Annotated[
        float,
        Field(
            ge=0,
            le=1e15,
            description="beta of (7), on the error across the contour too; 0: plain tracking",
        ),
    ]
    control_weight: Annotated[
        float, Field(gt=0, le=1e15, description="rho, on the squares of the commands")
    ] = 2e-9
    preview: Annotated[
        int, Field(ge=1, le=MOST_PREVIEW, description="N_p, points of the contour known ahead")
    ] = 10
    terminal: Annotated[
        Literal["output", "stationary"],
        Field(
            description="weight at the end of the preview: C'QC, without guarantee, or H_s(Q_max), "
            "stable at every angle by Theorem 1"
        ),
    ] = "stationary"
    resolution_m: Annotated[
        float,
        Field(
            ge=0,
            le=0.01,
            description="points closer than this make no direction; what the arithmetic can tell, "
            "if that is more",
        ),
    ] = 0.0
    form: Annotated[
        Literal["on_line", "tabulated"],
        Field(
            description="gains computed in every sample, or taken from a table of directions: "
            "less work, two axes, not quite as close"
        ),
    ] = "on_line"
    entries: Annotated[
        int, Field(ge=4, le=MOST_ENTRIES, description="tabulated: directions over half a turn")
    ] = 64
    direction_at: Annotated[
        int, Field(ge=1, le=MOST_PREVIEW, description="tabulated: point ahead that gives it")
    ] = 4


class ContourController(Section):
    """The table ``[controller]``."""

    contour: ContourTable


class CircleContour(Section):
    """A circle about the origin, anticlockwise; with a third axis a helix or a level one."""

    kind: Annotated[Literal["circle"], Field(description="which contour, see above")]
    radius_m: Annotated[float, Field(ge=1e-6, le=100, description="of the circle")]
    feed_m_per_s: Annotated[float, Field(ge=1e-7, le=100, description="along the contour")]
    repetitions: Annotated[int, Field(ge=2, le=1000, description="turns")] = 4
    rise_m: Annotated[
        float, Field(ge=-1, le=1, description="of the third axis in a turn, from 0 on")
    ] = 0.0
    ramp_s: Annotated[
        float, Field(ge=0, le=10, description="from rest to the feed, and back at the end")
    ] = 0.05


class ButterflyContour(Section):
    """Fay's butterfly: closes after twelve turns, crosses itself and bends sharply."""

    kind: Annotated[Literal["butterfly"], Field(description="which contour, see above")]
    size_m: Annotated[float, Field(ge=1e-6, le=100, description="farthest from the origin")]
    feed_m_per_s: Annotated[float, Field(ge=1e-7, le=100, description="along the contour")]
    repetitions: Annotated[int, Field(ge=1, le=1000, description="of the whole curve")] = 1
    ramp_s: Annotated[
        float, Field(ge=0, le=10, description="from rest to the feed, and back at the end")
    ] = 0.05


ContourKind = Annotated[
    CircleContour | ButterflyContour | None, Field(discriminator="kind", description="a curve")
]


class ContourPath(PathTable):
    """The drawing or part program, and how it becomes a contour in time."""

    tolerance_m: Annotated[
        float, Field(ge=1e-9, le=0.01, description="chord error of flattening curves")
    ] = 1e-7
    feed_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="where the drawing gives none")
    ] = 0.05
    tangential_acceleration_m_per_s2: Annotated[
        float, Field(gt=0, le=1e5, description="along the path")
    ] = 1.0
    centripetal_acceleration_m_per_s2: Annotated[
        float, Field(gt=0, le=1e5, description="across the path, slows curves")
    ] = 2.5
    corner_time_s: Annotated[
        float, Field(gt=0, le=1, description="a corner changes velocity within this time")
    ] = 0.002
    traverse_feed_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="of the moves that join entities")
    ] = 0.1
    acceleration_limit_m_per_s2: Annotated[
        float, Field(gt=0, le=1e5, description="of every axis, corners included")
    ] = 3.0


class ContourTarget(Section):
    """The processor and what is asked of it."""

    name: Annotated[
        str,
        told(
            "the name of a target or of a TOML file that describes one",
            description="a bundled target, or a TOML file relative to this project file",
            min_length=1,
        ),
    ] = "tms320c6678"
    share: Annotated[
        float, Field(gt=0, le=1, description="of every period, for the controller of all axes")
    ] = 0.5
    contour_error_limit_m: Annotated[
        float, Field(gt=0, le=1, description="largest contour error that simulate accepts")
    ] = 1e-5


class ContourFile(Section):
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
        Literal["contour_lq"], Field(description="which of the systems this machine is")
    ]
    machine: ContourMachineFile
    sampling: ContourSampling
    controller: ContourController
    contour: ContourKind = None
    path: ContourPath | None = None
    output: Output = Output()
    target: ContourTarget = ContourTarget()
