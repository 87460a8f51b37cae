"""The machine's tables: each axis has a slow and a fast stage, each stage one of four models."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from servogen.project.fields import FileName, Matrix, Section, Vector, told

_MODEL = Field(description="kind of model, see above")
Bandwidth = Annotated[float, Field(gt=0, le=1e6, description="speed of the servo loop")]
Damping = Annotated[float, Field(gt=0, le=5, description="damping of its complex pair")]
Numerator = Annotated[
    Vector, told("a list of numbers, descending powers of s", description="descending powers of s")
]
Denominator = Annotated[
    Vector,
    told(
        "a list of at least two numbers, descending powers of s",
        description="descending powers of s; its degree is the number of states",
        min_length=2,
    ),
]
StateMatrix = Annotated[
    Matrix, told("a square matrix: a list of rows of numbers", description="dx/dt = a x + b u")
]
InputVector = Annotated[Vector, told("a list of numbers", description="one number a state")]
OutputVector = Annotated[Vector, told("a list of numbers", description="position = c x, metres")]
ModelFile = Annotated[
    FileName,
    told("the name of a Python file", description="Python file, relative to this project file"),
]
Function = Annotated[
    str,
    told(
        "the name of a function in the model file",
        description="function in it that builds the model from CasADi expressions",
        pattern=r"^[A-Za-z_][A-Za-z0-9_]*$",
    ),
]


class ServoModel(Section):
    """Third-order servo loop w^3 / ((s + w)(s^2 + 2 zeta w s + w^2)), dc gain one."""

    model: Annotated[Literal["servo"], _MODEL]
    bandwidth_rad_per_s: Bandwidth
    damping: Damping


class TransferFunctionModel(Section):
    """Position over commanded position as a ratio of polynomials in s."""

    model: Annotated[Literal["transfer_function"], _MODEL]
    numerator: Numerator
    denominator: Denominator


class StateSpaceModel(Section):
    """Continuous-time state space with one input, the commanded position in metres."""

    model: Annotated[Literal["state_space"], _MODEL]
    a: StateMatrix
    b: InputVector
    c: OutputVector


class PythonModel(Section):
    """A user's own model, written as CasADi expressions in a Python file."""

    model: Annotated[Literal["python"], _MODEL]
    file: ModelFile
    function: Function
    parameters: Annotated[
        dict[str, float], Field(description="values that the function is called with")
    ] = Field(default_factory=dict)


class SlowLimits(Section):
    """What the slow stage must never exceed."""

    position_limit_m: Annotated[
        float, Field(gt=0, le=100, description="|position| of the slow stage stays within")
    ]
    velocity_limit_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="|velocity| of the slow stage stays within")
    ]
    acceleration_limit_m_per_s2: Annotated[
        float, Field(gt=0, le=1e4, description="|acceleration| of the slow stage stays within")
    ]


class FastLimits(Section):
    """Range of the fast stage, and the limits of the ideal machine that the path is timed for."""

    range_m: Annotated[
        float, Field(gt=0, le=10, description="the fast stage moves this far to either side")
    ]
    velocity_limit_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="velocity of the ideal machine, for path timing")
    ]
    acceleration_limit_m_per_s2: Annotated[
        float, Field(gt=0, le=1e5, description="acceleration of the ideal machine")
    ]


# The limits come first among the bases so that the model's own keys stand first in the tables.
class SlowServo(SlowLimits, ServoModel): ...


class SlowTransferFunction(SlowLimits, TransferFunctionModel): ...


class SlowStateSpace(SlowLimits, StateSpaceModel): ...


class SlowPython(SlowLimits, PythonModel): ...


class FastServo(FastLimits, ServoModel): ...


class FastTransferFunction(FastLimits, TransferFunctionModel): ...


class FastStateSpace(FastLimits, StateSpaceModel): ...


class FastPython(FastLimits, PythonModel): ...


SlowStage = Annotated[
    SlowServo | SlowTransferFunction | SlowStateSpace | SlowPython, Field(discriminator="model")
]
FastStage = Annotated[
    FastServo | FastTransferFunction | FastStateSpace | FastPython, Field(discriminator="model")
]


class Axis(Section):
    """One axis: the stages in series, tool position = slow position + fast position."""

    slow: SlowStage
    fast: FastStage


class AxisLikeX(Section):
    """The y axis when it is built as x is."""

    same_as: Annotated[
        Literal["x"], told('"x", or the tables slow and fast', description="y is built as x is")
    ]


def kind_of_y(value: object) -> str:
    """Tag of what stands at ``machine.y``."""
    return "like_x" if isinstance(value, AxisLikeX) or _has_same_as(value) else "own"


def _has_same_as(value: object) -> bool:
    return isinstance(value, dict) and "same_as" in value


class MachineFile(Section):
    """The table ``[machine]`` as the file has it."""

    x: Axis
    y: Annotated[
        Annotated[AxisLikeX, Tag("like_x")] | Annotated[Axis, Tag("own")],
        Discriminator(kind_of_y),
    ] = AxisLikeX(same_as="x")


class Machine(Section):
    """Both axes, resolved."""

    x: Axis
    y: Axis

    @property
    def axes(self) -> tuple[tuple[str, Axis], tuple[str, Axis]]:
        """("x", ...), ("y", ...)."""
        return (("x", self.x), ("y", self.y))
