"""The machine's tables under the extended command governor: a slow stage with a model, a fast one
that is where it is told to be."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from servogen.project.fields import Section, told
from servogen.project.limits import LARGEST_LIMIT, AnyLimits
from servogen.project.machine import (
    AxisLikeX,
    FastLimits,
    PythonModel,
    ServoModel,
    StateSpaceModel,
    TransferFunctionModel,
    kind_of_y,
)


class EqualPolesModel(Section):
    """p^3 / (s + p)^3: three equal poles, dc gain one."""

    model: Annotated[Literal["equal_poles"], Field(description="kind of model, see above")]
    pole_rad_per_s: Annotated[float, Field(gt=0, le=1e6, description="p, of all three")]


class GovernedLimits(Section):
    """What the slow stage must never exceed."""

    position_limit_m: Annotated[
        AnyLimits,
        told(
            f"a number above 0, or two, [low, high], within {LARGEST_LIMIT:g} of 0 (m)",
            description="the slow stage stays between them, or within one to either side",
        ),
    ]
    velocity_limit_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="|velocity| of the slow stage stays within")
    ]
    acceleration_limit_m_per_s2: Annotated[
        float, Field(gt=0, le=1e4, description="|acceleration| of the slow stage stays within")
    ]


# The limits come first among the bases so that the model's own keys stand first in the tables.
class GovernedEqualPoles(GovernedLimits, EqualPolesModel): ...


class GovernedServo(GovernedLimits, ServoModel): ...


class GovernedTransferFunction(GovernedLimits, TransferFunctionModel): ...


class GovernedStateSpace(GovernedLimits, StateSpaceModel): ...


class GovernedPython(GovernedLimits, PythonModel): ...


GovernedStage = Annotated[
    GovernedEqualPoles
    | GovernedServo
    | GovernedTransferFunction
    | GovernedStateSpace
    | GovernedPython,
    Field(discriminator="model"),
]


class GovernedAxis(Section):
    """One axis: tool position = slow position + fast position, the fast one within its range."""

    slow: GovernedStage
    fast: FastLimits


class GovernedMachineFile(Section):
    """The table ``[machine]`` as the file has it."""

    x: GovernedAxis
    y: Annotated[
        Annotated[AxisLikeX, Tag("like_x")] | Annotated[GovernedAxis, Tag("own")],
        Discriminator(kind_of_y),
    ] = AxisLikeX(same_as="x")


class GovernedMachine(Section):
    """Both axes, resolved."""

    x: GovernedAxis
    y: GovernedAxis

    @property
    def axes(self) -> tuple[tuple[str, GovernedAxis], tuple[str, GovernedAxis]]:
        """("x", ...), ("y", ...)."""
        return (("x", self.x), ("y", self.y))
