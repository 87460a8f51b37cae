"""The machine's tables under the contour controller: axes that take a velocity command and have an
encoder."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from servogen.project.fields import Matrix, Section, Vector, told
from servogen.project.machine import AxisLikeX, Bandwidth, Damping, kind_of_y

_MODEL = Field(description="kind of model, see above")


class CentreDrive(Section):
    """A feed drive of the machining centre of paper 2, as identified at 2 kHz."""

    model: Annotated[Literal["machining_centre"], _MODEL]
    axis: Annotated[Literal["x", "y"], Field(description="which of its axes, order 3 or 5")]


class MatricesDrive(Section):
    """x(k+1) = a x(k) + b u(k), position = c x(k), identified at the controller's sample time."""

    model: Annotated[Literal["matrices"], _MODEL]
    a: Annotated[
        Matrix, told("a square matrix: a list of rows of numbers", description="any order")
    ]
    b: Annotated[
        Vector, told("a list of numbers", description="on the command, one number a state")
    ]
    c: Annotated[Vector, told("a list of numbers", description="position = c x, metres")]


class VelocityServo(Section):
    """Velocity loop g w^2 / (s^2 + 2 zeta w s + w^2), then an integrator."""

    model: Annotated[Literal["velocity_servo"], _MODEL]
    bandwidth_rad_per_s: Bandwidth
    damping: Damping
    velocity_per_command_m_per_s: Annotated[
        float, Field(ge=1e-9, le=1e6, description="g, of a command of one unit")
    ] = 1.0


class VelocityTransfer(Section):
    """Velocity over command as a ratio of polynomials in s, then an integrator."""

    model: Annotated[Literal["transfer_function"], _MODEL]
    numerator: Annotated[
        Vector,
        told(
            "a list of numbers, descending powers of s",
            description="descending powers of s, to velocity in m/s",
        ),
    ]
    denominator: Annotated[
        Vector,
        told(
            "a list of at least two numbers, descending powers of s",
            description="descending powers of s; the axis has one state more than its degree",
            min_length=2,
        ),
    ]


Drive = Annotated[
    CentreDrive | MatricesDrive | VelocityServo | VelocityTransfer, Field(discriminator="model")
]


class ContourAxisTable(Section):
    """One axis: what it can be told, where it can be, what is measured of it, how it moves."""

    command_limit: Annotated[
        float,
        Field(ge=1e-9, le=1e9, description="|command| stays within, in the unit of the drive"),
    ]
    position_limit_m: Annotated[
        float, Field(ge=1e-6, le=100, description="|position| of every point of a contour")
    ]
    encoder_m: Annotated[float, Field(ge=1e-12, le=0.01, description="one count of the encoder")]
    command_noise: Annotated[
        float,
        Field(
            ge=1e-12,
            le=1e9,
            description="standard deviation of what disturbs the axis, as if added to the "
            "command: the Kalman filter's; more trusts the encoder more",
        ),
    ]
    drive: Drive


class ContourLikeX(AxisLikeX):
    """An axis that is built as x is."""

    same_as: Annotated[
        Literal["x"], told('"x", or keys and a table drive of its own', description="built as x is")
    ]


def kind_of_z(value: object) -> str:
    """Tag of what stands at ``machine.z``."""
    return "none" if value is None else kind_of_y(value)


class ContourMachineFile(Section):
    """The table ``[machine]`` as the file has it."""

    x: ContourAxisTable
    y: Annotated[
        Annotated[ContourLikeX, Tag("like_x")] | Annotated[ContourAxisTable, Tag("own")],
        Discriminator(kind_of_y),
    ] = ContourLikeX(same_as="x")
    z: Annotated[
        Annotated[None, Tag("none")]
        | Annotated[ContourLikeX, Tag("like_x")]
        | Annotated[ContourAxisTable, Tag("own")],
        Discriminator(kind_of_z),
    ] = None

    @property
    def resolved(self) -> tuple[tuple[str, ContourAxisTable], ...]:
        """("x", ...), ("y", ...) and, where there is one, ("z", ...)."""
        axes = [("x", self.x)]
        for name, axis in (("y", self.y), ("z", self.z)):
            if axis is not None:
                axes.append((name, self.x if isinstance(axis, AxisLikeX) else axis))
        return tuple(axes)
