"""The project file's tables other than the machine's, and the whole file.

SI units throughout. Defaults are the bundled two-stage machine's (MPC-20-B).
"""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, Field

from servogen.identifiers import MAX_LENGTH, is_free_prefix
from servogen.project.fields import FileName, Section, Version, one_of, told
from servogen.project.machine import MachineFile

KNOWN_SYSTEMS = ("two_stage",)
DRAWING_SUFFIXES = (".dxf", ".svg", ".nc", ".gcode", ".ngc", ".csv")
MAX_HORIZON = 60
MAX_ITERATIONS = 100_000


def identifier(name: str) -> str:
    """A prefix of emitted names; ValueError where it is none."""
    if not is_free_prefix(name):
        raise ValueError("not a name that emitted ones can begin with")
    return name


class Sampling(Section):
    """The two periods of the cascade."""

    fast_sample_time_s: Annotated[
        float, Field(ge=1e-6, le=1, description="T_f, period of the fast stage's loop")
    ]
    slow_sample_time_s: Annotated[
        float, Field(ge=1e-5, le=10, description="T_s, period of the slow stage's loop; M T_f")
    ]

    @property
    def ratio(self) -> int:
        """M = T_s / T_f, fast samples in one slow period."""
        return round(self.slow_sample_time_s / self.fast_sample_time_s)


class Governor(Section):
    """The scheduled-path reference governor (14)-(15)."""

    steady_state_tightening: Annotated[
        float,
        Field(ge=1e-6, le=0.5, description="eps, steady states keep 1 - eps of the limits"),
    ] = 0.01
    inter_sample_rows: Annotated[
        int, Field(ge=0, le=10, description="instants inside T_s where v and a are constrained")
    ] = 0
    range_check: Annotated[
        Literal["both_ends", "as_printed"],
        Field(
            description="ends of an interval at which the fast range is tested; as_printed is the "
            "paper's, which lets the slow stage leave it and fails the checks"
        ),
    ] = "both_ends"


Weight = Annotated[float, Field(ge=0, le=1e6, description="weight, divided by its limit squared")]


class Mpc(Section):
    """The tracking MPC (16)."""

    horizon: Annotated[int, Field(ge=1, le=MAX_HORIZON, description="N, slow periods")] = 20
    weight_position: Weight = 0.003
    weight_velocity: Weight = 0.1
    weight_acceleration: Weight = 1.0
    weight_command: Annotated[
        float, Field(gt=0, le=1e6, description="weight, divided by its limit squared")
    ] = 0.001
    terminal_weight: Annotated[
        Literal["lyapunov"] | Annotated[float, Field(ge=1, le=1e6)],
        told(
            '"lyapunov" or a number at least 1 that scales it',
            description="P from the Lyapunov equation, or that scaled",
        ),
    ] = "lyapunov"
    inter_sample_rows: Annotated[
        int, Field(ge=0, le=10, description="instants inside T_s where v and a are constrained")
    ] = 0


Method = Literal["pqp", "active_set"]


def _of_method(value: object) -> object:
    """``solver = "active_set"`` is the table with this method and the defaults."""
    if not isinstance(value, str):
        return value
    if value not in get_args(Method):
        raise ValueError("no method")
    return {"method": value}


class Solver(Section):
    """The iteration that solves the MPC's program."""

    method: Annotated[
        Method,
        Field(
            description="the paper's iteration (20)-(21), or the dual active-set method; "
            '`solver = "active_set"` in `[controller]` is this key alone, with no table '
            "`[controller.solver]` beside it: TOML takes one or the other"
        ),
    ] = "pqp"
    iteration_cap: Annotated[
        Literal["target"] | Annotated[int, Field(ge=1, le=MAX_ITERATIONS)],
        told(
            f'a whole number from 1 to {MAX_ITERATIONS} or "target"',
            description="iterations, then the backup; target: as many as fit its budget",
        ),
    ] = "target"
    phi: Annotated[
        float, Field(gt=0, le=10, description="pqp: phi_i in (20) is this times Q_ii of the dual")
    ] = 0.1
    acceleration_period: Annotated[
        int, Field(ge=0, le=1000, description="pqp: iterations between acceleration steps, 0: none")
    ] = 6
    gap_tolerance: Annotated[
        float, Field(ge=1e-9, le=0.1, description="pqp: duality gap at which the iteration ends")
    ] = 1e-4
    constraint_margin: Annotated[
        float,
        Field(
            ge=0,
            le=0.01,
            description="tightening of the rows; below 1e-9 (float32: 1e-5) it is raised to that; "
            "1e-5 by default with float32",
        ),
    ] = 1e-6


class FastLaw(Section):
    """The fast stage's command (22), (23)."""

    matching: Annotated[bool, Field(description="true for (23), false for (22)")] = True
    feed_ramp: Annotated[bool, Field(description="ramp the feed inside the interval")] = True


class Lfs(Section):
    """The baseline: low-pass filtered path for the slow stage."""

    cutoff_hz: Annotated[float, Field(gt=0, le=1e4, description="of the low-pass filter")] = 4.0


class Controller(Section):
    """The table ``[controller]``."""

    kind: Annotated[
        Literal["sprg_mpc", "sprg"], Field(description="which controller is emitted")
    ] = "sprg_mpc"
    governor: Governor = Governor()
    mpc: Mpc = Mpc()
    solver: Annotated[
        Solver,
        BeforeValidator(_of_method),
        told(f"the table [controller.solver], or its method alone: {one_of(get_args(Method))}"),
    ] = Solver()
    fast: FastLaw = FastLaw()
    lfs: Lfs = Lfs()


LayerFeed = Annotated[float, Field(gt=0, le=100)]


class PathTable(Section):
    """The drawing and how it becomes a timed path."""

    file: Annotated[
        FileName,
        told(
            f"the name of a file ending in {', '.join(DRAWING_SUFFIXES)}",
            description="drawing (.dxf .svg .nc .gcode .ngc .csv), relative to this project file",
        ),
    ]
    tolerance_m: Annotated[
        float, Field(ge=1e-9, le=0.01, description="chord error of flattening curves")
    ] = 5e-6
    feed_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="where the drawing gives none")
    ] = 0.3
    feed_scale: Annotated[float, Field(gt=0, le=100, description="multiplies every feed")] = 1.0
    join_tolerance_m: Annotated[
        float, Field(ge=0, le=0.01, description="ends of entities this close are joined")
    ] = 1e-5
    tangential_acceleration_m_per_s2: Annotated[
        float, Field(gt=0, le=1e5, description="along the path, of the ideal machine")
    ] = 24.5
    centripetal_acceleration_m_per_s2: Annotated[
        float, Field(gt=0, le=1e5, description="across the path, slows curves")
    ] = 34.3
    corner_time_s: Annotated[
        float, Field(gt=0, le=1, description="a corner changes velocity within this time")
    ] = 0.0002
    traverse_feed_m_per_s: Annotated[
        float, Field(gt=0, le=100, description="of the moves that join entities")
    ] = 0.6
    layer_feeds_m_per_s: Annotated[
        dict[str, LayerFeed],
        told(
            "a number above 0 and at most 100 (m/s)",
            description="feed of each DXF layer or SVG group",
        ),
    ] = Field(default_factory=dict)


class Output(Section):
    """What the emitted C computes in."""

    precision: Annotated[
        Literal["float64", "float32"], Field(description="arithmetic of the emitted C")
    ] = "float64"


class Target(Section):
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
    contour_error_limit_m: Annotated[
        float, Field(gt=0, le=1, description="largest contour error that simulate accepts")
    ] = 5e-5


class ProjectFile(Section):
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
        Literal["two_stage"], Field(description="which of the systems this machine is")
    ]
    machine: MachineFile
    sampling: Sampling
    controller: Controller = Controller()
    path: PathTable
    output: Output = Output()
    target: Target = Target()
