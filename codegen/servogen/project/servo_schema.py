"""The tables of a servo drive's project file (``system = "servo_drive"``).

Angles in degrees and currents in milliamperes, as drives have them; all else in SI units. Each key
says its unit. Defaults are the headstock axis of paper 5.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from servogen.identifiers import MAX_LENGTH, is_free_prefix
from servogen.project.fields import Integers, Matrix, Section, Vector, Version, told
from servogen.project.limits import (
    LARGEST_LIMIT,
    LEAST,
    AnyLimits,
    LimitsAroundZero,
    LimitsEitherSide,
)
from servogen.project.servo_reference import SineReference, TrapezoidReference

# As ``LEAST``, of what is small in SI units.
LEAST_INERTIA = 1e-12
# Between weights in milliamperes and degrees squared there are no fifteen decades and fifteen.
LARGEST_WEIGHT = 1e15
# In coordinates that make a model's numbers larger, no design is left by rounding.
LARGEST_ENTRY, LEAST_ENTRY = 1e12, 1e-12
MAX_PREDICTION = 500
MAX_CONTROL = 20
LARGEST_TURN = 4096


def _identifier(name: str) -> str:
    if not is_free_prefix(name):
        raise ValueError("not a name that emitted ones can begin with")
    return name


def _list_of_one(value: object) -> object:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return (value,) if plain else value


def as_numbers(weights: tuple[float, ...]) -> float | list[float]:
    """Weights as a file says them: one number where it stands for a whole horizon."""
    return weights[0] if len(weights) == 1 else list(weights)


Weights = Annotated[Vector, BeforeValidator(_list_of_one)]
_MODEL = Field(description="kind of model, see above")


class TwoMassDrive(Section):
    """Motor and load joined by an elastic coupling; from one current only ratios can be told."""

    model: Annotated[Literal["two_mass"], _MODEL]
    motor_inertia_kg_m2: Annotated[
        float, Field(ge=LEAST_INERTIA, le=1e6, description="of the motor's rotor")
    ]
    load_inertia_kg_m2: Annotated[
        float, Field(ge=LEAST_INERTIA, le=1e6, description="of what it turns")
    ]
    stiffness_n_m_per_rad: Annotated[float, Field(ge=LEAST, le=1e12, description="of the coupling")]
    coupling_damping_n_m_s_per_rad: Annotated[
        float, Field(ge=0, le=1e9, description="of the coupling")
    ]
    motor_friction_n_m_s_per_rad: Annotated[
        float, Field(ge=0, le=1e9, description="viscous, of the motor's bearings")
    ]
    load_friction_n_m_s_per_rad: Annotated[
        float, Field(ge=0, le=1e9, description="viscous, of the load's bearings")
    ]
    torque_constant_n_m_per_a: Annotated[
        float, Field(ge=LEAST, le=1e6, description="torque of the motor")
    ]


StateMatrix = Annotated[
    Matrix, told("a square matrix: a list of rows of numbers", description="A_p of (1), sampled")
]
InputMatrix = Annotated[
    Vector, told("a list of numbers", description="B_p of (1), sampled: on the current in mA")
]
OutputMatrix = Annotated[
    Vector, told("a list of numbers", description="C_p of (1): the measured angle in degrees")
]


class MatricesDrive(Section):
    """A sampled model (1) at the controller's sample time."""

    model: Annotated[Literal["matrices"], _MODEL]
    a: StateMatrix
    b: InputMatrix
    c: OutputMatrix


Drive = Annotated[TwoMassDrive | MatricesDrive, Field(discriminator="model")]


class DesignModel(Section):
    """What the controller is designed on, where that is not the drive itself."""

    a: StateMatrix
    b: InputMatrix
    c: OutputMatrix


class Axis(Section):
    """What is measured, and how far."""

    encoder_resolution_deg: Annotated[
        float, Field(ge=LEAST, le=360, description="angle of one step of the encoder")
    ]
    turn_deg: Annotated[
        int,
        Field(ge=0, le=LARGEST_TURN, description="measurements come round after it; 0: never"),
    ] = 360
    position_range_deg: Annotated[
        float, Field(ge=LEAST, le=1e6, description="|position| measured or wanted stays within")
    ] = 36000.0


class ServoSampling(Section):
    """The two periods of the drive."""

    sample_time_s: Annotated[float, Field(ge=1e-6, le=1, description="T, of position control")]
    current_sample_time_s: Annotated[
        float, Field(ge=1e-7, le=1, description="of the current loop with its notch; T / 1..64")
    ]


class ServoMpc(Section):
    """The trajectory-tracking MPC (7), (10)-(12)."""

    prediction_horizon: Annotated[
        int, Field(ge=1, le=MAX_PREDICTION, description="H_p, samples")
    ] = 50
    trajectory_horizon: Annotated[
        int, Field(ge=1, le=MAX_PREDICTION, description="H_t, references that are taken")
    ] = 3
    control_horizon: Annotated[
        int, Field(ge=1, le=MAX_CONTROL, description="H_u, inputs that are free")
    ] = 3
    reference_extension: Annotated[
        Literal["first_order", "zero_order"],
        Field(description="how the reference goes on beyond H_t: as a line, or as it is"),
    ] = "first_order"
    weight_error: Annotated[
        Weights,
        told(
            "a number or a list of H_p numbers, none negative",
            description="Q(1..H_p), on the error in degrees squared",
            min_length=1,
        ),
    ] = (1e6,)
    weight_change: Annotated[
        Weights,
        told(
            "a number or a list of H_u numbers, all above 0",
            description="R(0..H_u-1), on the change of the current in mA squared",
            min_length=1,
        ),
    ] = (1.0,)
    current_limit_ma: Annotated[
        LimitsAroundZero,
        told(
            f"a number from {LEAST:g} to {LARGEST_LIMIT:g}, or two, [low, high], with 0 between "
            "them or at one of them (mA)",
            description="(10), to either side or below and above; the PID's too",
        ),
    ] = (-1000.0, 1000.0)
    current_step_limit_ma: Annotated[
        LimitsEitherSide | None,
        told(
            f"a number from {LEAST:g} to {LARGEST_LIMIT:g}, or two, [low, high], with 0 between "
            "them (mA)",
            description="(11), in one sample, to either side or down and up; or none",
        ),
    ] = None
    position_bound_deg: Annotated[
        AnyLimits | None,
        told(
            f"a number from {LEAST:g} to {LARGEST_LIMIT:g}, or two, [low, high] (deg)",
            description="(12), to either side or below and above; or none",
        ),
    ] = None
    position_bound_samples: Annotated[
        Integers | None,
        told(
            "a list of whole numbers, from 1 to H_p, ascending",
            description="predicted samples at which (12) holds; none: at all, 1 to H_p",
            min_length=1,
        ),
    ] = None
    model: Annotated[
        DesignModel | None, Field(description="design on these rather than on the drive")
    ] = None


class Estimator(Section):
    """The Kalman filter."""

    disturbance_step_ma: Annotated[
        float,
        Field(ge=LEAST, le=1e6, description="by how much a load changes in one sample (deviation)"),
    ] = 5.0
    measurement_noise_deg: Annotated[
        float | None,
        told(
            f"a number from {LEAST:g} to 360 (deg)",
            ge=LEAST,
            le=360,
            description="of the encoder (deviation); by default its resolution / sqrt(12)",
        ),
    ] = None


_COEFFICIENTS = "a list of three numbers, descending powers of z"


class LookupTable(Section):
    """The explicit solution of the MPC's program: its size, and the search for a small tree."""

    max_regions: Annotated[
        int,
        Field(
            ge=1,
            le=1_000_000,
            description="critical regions beyond which a form of the lookup is left out; "
            "refused if none is left",
        ),
    ] = 5000
    max_nodes: Annotated[
        int,
        Field(
            ge=1,
            le=1_000_000,
            description="inner nodes of a search tree beyond which a form of the lookup is left "
            "out; refused if none is left",
        ),
    ] = 5000
    search_nodes: Annotated[
        int,
        Field(
            ge=0,
            le=10_000_000,
            description="that the search for shallower and smaller trees may open, all forms "
            "together, one with many pieces of regions for several; 0: greedy trees",
        ),
    ] = 10_000


class NotchTable(Section):
    """The filter (16) of the current loop."""

    numerator: Annotated[
        Vector, told(_COEFFICIENTS, description=_COEFFICIENTS[2:], min_length=3, max_length=3)
    ]
    denominator: Annotated[
        Vector, told(_COEFFICIENTS, description=_COEFFICIENTS[2:], min_length=3, max_length=3)
    ]


class PidTable(Section):
    """The cascaded PID of Figure 12, simulated and emitted beside the MPC."""

    position_gain_per_s: Annotated[
        float, Field(ge=LEAST, le=1e6, description="of the position loop")
    ]
    velocity_gain_ma_s_per_deg: Annotated[
        float, Field(ge=LEAST, le=1e9, description="of the speed loop")
    ]
    integral_time_s: Annotated[float, Field(ge=LEAST, le=1e3, description="of the speed loop")]
    notch: Annotated[NotchTable | None, Field(description="none: no filter")] = None


class ServoController(Section):
    """The table ``[controller]``."""

    mpc: ServoMpc = ServoMpc()
    lookup: LookupTable = LookupTable()
    estimator: Estimator = Estimator()
    pid: Annotated[PidTable | None, Field(description="none: no PID beside it")] = None


Reference = Annotated[SineReference | TrapezoidReference, Field(discriminator="shape")]


class ServoOutput(Section):
    """What the emitted C computes in."""

    precision: Annotated[
        Literal["float64", "float32"], Field(description="arithmetic of the emitted C")
    ] = "float32"


class ServoTarget(Section):
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
        float, Field(gt=0, le=1, description="of every period, for all that has to be done in it")
    ] = 0.2
    tracking_error_limit_deg: Annotated[
        float | None,
        told(
            "a number above 0 (deg)",
            gt=0,
            le=1e6,
            description="|output - reference| of the MPC stays within; none: half a turn or range",
        ),
    ] = None


class ServoFile(Section):
    """The whole file as it stands."""

    schema_version: Annotated[
        Version, Field(alias="schema", description="version of this file's format")
    ]
    name: Annotated[
        str,
        AfterValidator(_identifier),
        told(
            f"a C identifier of at most {MAX_LENGTH} letters, digits and _, no keyword, not the "
            "name of a standard header or (with _t) type, not beginning with sg_",
            description="prefix of all emitted names",
        ),
    ]
    system: Annotated[
        Literal["servo_drive"], Field(description="which of the systems this machine is")
    ]
    drive: Drive
    axis: Axis
    sampling: ServoSampling
    controller: ServoController = ServoController()
    reference: Reference
    output: ServoOutput = ServoOutput()
    target: ServoTarget = ServoTarget()
