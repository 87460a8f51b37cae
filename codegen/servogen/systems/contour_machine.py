"""Paper 2's machine: from a project to its axes and its contour controller."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servogen.controllers.contour_axis import AxisModel, axis_model
from servogen.controllers.contour_lq_design import (
    AxisData,
    ContourLqDesign,
    design_contour_lq,
)
from servogen.controllers.contour_table_design import tabulate
from servogen.controllers.contour_tangent import distinct
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.controllers.errors import DesignError
from servogen.errors import InputError
from servogen.plants.errors import PlantError
from servogen.plants.machining_centre import machining_centre
from servogen.plants.statespace import Discrete, FloatArray, StateSpace, discretise
from servogen.precision import PRECISIONS, Precision
from servogen.project.contour_load import ContourProject
from servogen.project.contour_machine import (
    CentreDrive,
    ContourAxisTable,
    MatricesDrive,
    VelocityServo,
    VelocityTransfer,
)
from servogen.systems.contour_axes import check_axis
from servogen.systems.contour_task import ContourTask, contour_task

# An axis that goes no faster, or that much faster, has a gain in another unit.
SLOWEST_M_PER_S, FASTEST_M_PER_S = 1e-6, 1e3
_WEIGHTS = ("tracking_weight", "contour_weight", "control_weight", "preview")
_KEYS = {
    "input_limit": "command_limit",
    "reach": "position_limit_m",
    "disturbance_noise": "command_noise",
    "measurement_noise": "encoder_m",
}


@dataclass(frozen=True)
class ContourSettings:
    """What a design is made with; the project's own, or another one of a study.

    entries: 0 for gains computed on line.
    """

    weights: ContourWeights
    terminal: Terminal
    preview: int
    entries: int = 0
    direction_at: int = 1


@dataclass(frozen=True)
class ContourMachine:
    """What every design and every closed loop of a project starts from.

    Attributes:
        axes: sampled, in their order. gains: m/s per unit of command. task: the contour in time.
    """

    project: ContourProject
    axes: tuple[Discrete, ...]
    gains: tuple[float, ...]
    task: ContourTask

    @property
    def precision(self) -> Precision:
        return PRECISIONS[self.project.output.precision]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the axes."""
        return tuple(name for name, _ in self.project.axes)

    @property
    def encoder_m(self) -> FloatArray:
        """(p,) counts of the encoders, m."""
        return np.array([axis.encoder_m for _, axis in self.project.axes])

    @property
    def limits(self) -> FloatArray:
        """(p,) largest commands."""
        return np.array([axis.command_limit for _, axis in self.project.axes])


def contour_machine(project: ContourProject) -> ContourMachine:
    """Build and judge axes, design and contour.

    Raises:
        InputError: an axis or a contour that is none, each named.
    """
    axes = tuple(_axis(project, name, table) for name, table in project.axes)
    gains = []
    for plant, (name, table) in zip(axes, project.axes, strict=True):
        try:
            check_axis(plant)
            model = axis_model(plant, table.command_limit, table.position_limit_m)
        except DesignError as error:
            named = DesignError(f"{name}.{error.key}", error.value, error.expected)
            raise _fault(project, named) from error
        gains.append(velocity_gain(model))
        fastest = gains[-1] * table.command_limit
        if not SLOWEST_M_PER_S <= fastest <= FASTEST_M_PER_S:
            raise project.fault(
                f"machine.{name}.command_limit",
                f"{table.command_limit!r}, with which the axis goes {fastest:.3g} m/s",
                f"a velocity from {SLOWEST_M_PER_S:g} to {FASTEST_M_PER_S:g} m/s",
            )
    return ContourMachine(project, axes, tuple(gains), contour_task(project, gains))


def contour_settings(project: ContourProject) -> ContourSettings:
    """Those that the project file asks for."""
    table = project.controller.contour
    return ContourSettings(
        ContourWeights(table.tracking_weight, table.contour_weight, table.control_weight),
        Terminal(table.terminal),
        table.preview,
        table.entries if table.form == "tabulated" else 0,
        table.direction_at,
    )


def contour_design(
    machine: ContourMachine,
    precision: Precision | None = None,
    settings: ContourSettings | None = None,
) -> ContourLqDesign:
    """The project's controller, or one with other settings on its axes.

    Raises:
        InputError: an axis that none can be designed for, or a contour too slow for the precision.
    """
    project, asked = machine.project, settings or contour_settings(machine.project)
    data = [
        AxisData(
            plant, table.command_limit, table.position_limit_m, table.command_noise, table.encoder_m
        )
        for plant, (_, table) in zip(machine.axes, project.axes, strict=True)
    ]
    resolution = project.controller.contour.resolution_m
    try:
        design = design_contour_lq(
            project.name, precision or machine.precision, data, asked.weights, asked.terminal,
            asked.preview, resolution, not asked.entries,
        )  # fmt: skip
        if asked.entries:
            design = tabulate(design, asked.entries, asked.direction_at)
    except DesignError as error:
        raise _fault(project, error) from error
    _check_points(machine, design)
    return design


def _check_points(machine: ContourMachine, design: ContourLqDesign) -> None:
    """Points that the precision hardly tells apart have no directions to weight errors by."""
    coarse = distinct(design.precision, design.reach, 0.0)
    step = float(np.max(np.abs(np.diff(machine.task.motion.points, axis=0)), initial=0.0))
    if 0.0 < step <= coarse:
        raise machine.project.fault(
            "output.precision",
            design.precision.name,
            f"one that tells the contour's points apart: they are at most {step:.2g} m from one to "
            f"the next, and within position_limit_m = {design.reach:g} m it takes {coarse:.2g} m; "
            "float64, less reach or more feed",
        )


def with_weights(settings: ContourSettings, tracking: float, contour: float) -> ContourSettings:
    """The same with other weights on the errors."""
    weights = ContourWeights(tracking, contour, settings.weights.control)
    return replace(settings, weights=weights)


def velocity_gain(model: AxisModel) -> float:
    """Steady velocity per unit of the command where the position is zero, m/s."""
    hidden = np.linalg.solve(np.eye(model.hidden) - model.a[1:, 1:], model.b[1:])
    moved = float(model.a[0, 1:] @ hidden + model.b[0])
    return abs(moved) / model.plant.sample_time_s


def _fault(project: ContourProject, error: DesignError) -> InputError:
    name, _, key = error.key.rpartition(".")
    if not name:
        place = f"controller.contour.{key}" if key in _WEIGHTS else "controller.contour"
        return project.fault(place, error.value, error.expected)
    table = dict(project.axes)[name]
    if key in _KEYS:
        return project.fault(f"machine.{name}.{_KEYS[key]}", error.value, error.expected)
    model = table.drive.model
    place = f"machine.{name}.drive.{key}" if model == "matrices" else f"machine.{name}.drive"
    return project.fault(place, error.value, error.expected)


def _axis(project: ContourProject, name: str, table: ContourAxisTable) -> Discrete:
    drive, period = table.drive, project.sampling.sample_time_s
    try:
        match drive:
            case CentreDrive():
                return machining_centre()["xy".index(drive.axis)]
            case MatricesDrive():
                a, b, c = np.array(drive.a), np.array(drive.b), np.array(drive.c)
                return Discrete(a, b, c, period)
            case VelocityServo():
                w, zeta = drive.bandwidth_rad_per_s, drive.damping
                gain = drive.velocity_per_command_m_per_s * w**2
                return _integrated((gain,), (1.0, 2.0 * zeta * w, w**2), period)
            case VelocityTransfer():
                return _integrated(drive.numerator, drive.denominator, period)
    except PlantError as error:
        raise project.fault(f"machine.{name}.drive", error.value, error.expected) from error


def _integrated(
    numerator: tuple[float, ...], denominator: tuple[float, ...], period: float
) -> Discrete:
    """Of velocity's ratio of polynomials in s; states: the position, then the chain of a companion
    form in time constants of the fastest pole, which keeps its numbers near one."""
    den = np.trim_zeros(np.array(denominator), "f")
    num = np.array(numerator) / den[0]
    den, n = den / den[0], den.size - 1
    rate = max(float(np.max(np.abs(np.roots(den)))), 1.0)
    powers = rate ** np.arange(n + 1)
    num = np.concatenate([np.zeros(n - num.size), num]) / powers[1:]
    den = den / powers
    a, b, c = np.zeros((n + 1, n + 1)), np.zeros(n + 1), np.zeros(n + 1)
    a[0, 1:] = num[::-1]  # the chain's output is the velocity
    a[1:n, 2:] = rate * np.eye(n - 1)
    a[n, 1:] = -rate * den[:0:-1]
    b[n], c[0] = rate, 1.0
    return discretise(StateSpace(a, b, c), period)
