"""Paper 5's machine: from a servo drive's project to its plants and its controllers' designs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.errors import DesignError
from servogen.controllers.kalman import Noise, design_filter
from servogen.controllers.lookup_design import design_lookup
from servogen.controllers.pid_design import Notch, PidDesign
from servogen.controllers.prediction import Extension, Horizons
from servogen.controllers.servo_mpc_design import ServoMpcDesign, lookup_prefix
from servogen.controllers.servo_parts import ServoParts
from servogen.controllers.tracking_qp import (
    Bounds,
    Constraints,
    SignalBounds,
    TrackingQp,
    Weights,
    tracking_qp,
)
from servogen.errors import InputError
from servogen.explicit.choose import Choice, choose
from servogen.plants.errors import PlantError
from servogen.plants.sampled import Sampled
from servogen.plants.two_mass import TwoMass
from servogen.precision import PRECISIONS, Precision
from servogen.progress import Progress
from servogen.project.limits import Limits
from servogen.project.servo_load import ServoProject
from servogen.project.servo_schema import DesignModel, MatricesDrive, PidTable, as_numbers
from servogen.project.translate import value_text
from servogen.qp.errors import ProgramError
from servogen.sets.errors import SetError

# Over the horizon a mode may grow by this much at most, and by this much before it, rather than the
# weights, is to blame for a program whose numbers are lost: a float64 has sixteen digits.
MOST_GROWTH, SOME_GROWTH = 1e12, 1e3
# A design's quantity and the key of the file that it comes from.
_MPC_KEYS = {
    "prediction": "prediction_horizon",
    "trajectory": "trajectory_horizon",
    "control": "control_horizon",
    "output": "weight_error",
    "change": "weight_change",
}
_KEYS = {
    "measurement_noise": "controller.estimator.measurement_noise_deg",
    "turn": "axis.turn_deg",
    "reach": "axis.position_range_deg",
    "notch": "controller.pid.notch.denominator",
}


@dataclass(frozen=True)
class ServoDrive:
    """A judged project.

    Attributes:
        plant: what the controller is designed on, at the sample time.
        drive: what is simulated at the sample time, current alone.
        fine: what is simulated at the current loop's, current (mA) and load torque (N m).
        ratio: samples of ``fine`` in one of ``plant``.
    """

    project: ServoProject
    plant: Sampled
    drive: Sampled
    fine: Sampled
    ratio: int


def servo_drive(project: ServoProject) -> ServoDrive:
    """The plants of a project.

    Raises:
        InputError: parameters or matrices of which no plant can be made.
    """
    sampling, model = project.sampling, project.drive
    try:
        if isinstance(model, MatricesDrive):
            drive = _matrices(model, sampling.sample_time_s)
            no_load = np.hstack([drive.b, np.zeros_like(drive.b)])
            fine = Sampled(drive.a, no_load, drive.c, drive.sample_time_s)
        else:
            masses = TwoMass(**model.model_dump(exclude={"model"}))
            drive = masses.sampled(sampling.sample_time_s)
            fine = masses.disturbed(sampling.current_sample_time_s)
    except PlantError as error:
        if isinstance(model, MatricesDrive) or hasattr(model, error.key):
            raise project.fault(f"drive.{error.key}", error.value, error.expected) from error
        said = "one whose sampled matrices are not finite"
        raise project.fault("drive", said, "a slower drive, or a shorter sample time") from error
    own = project.controller.mpc.model
    plant = drive if own is None else _matrices(own, sampling.sample_time_s)
    return ServoDrive(project, plant, drive, fine, project.ratio)


def _matrices(model: MatricesDrive | DesignModel, sample_time_s: float) -> Sampled:
    a, b, c = (np.array(values, dtype=np.float64) for values in (model.a, model.b, model.c))
    return Sampled(a, b[:, None], c[None, :], sample_time_s)


def tracking_problem(
    servo: ServoDrive,
    trajectory: int | None = None,
    extension: Extension | None = None,
    limit_ma: float | None = None,
) -> TrackingQp:
    """The program of the project, or of the study's variations on it.

    Args:
        trajectory: H_t = H_u instead of the project's own two.
        extension, limit_ma: instead of the project's.

    Raises:
        InputError: weights or horizons of which no program can be made.
    """
    mpc = servo.project.controller.mpc
    control = mpc.control_horizon if trajectory is None else trajectory
    _require_growth_below(servo, MOST_GROWTH)
    try:
        horizons = Horizons(mpc.prediction_horizon, trajectory or mpc.trajectory_horizon, control)
        if trajectory is not None and len(mpc.weight_change) > 1:
            raise DesignError("weight_change", None, "one number, where the horizon is varied")
        weights = Weights.constant(
            np.array(mpc.weight_error)[:, None],
            np.array(mpc.weight_change)[:, None],
            servo.plant,
            horizons,
        )
        step, bound = mpc.current_step_limit_ma, mpc.position_bound_deg
        constraints = Constraints(
            _bounds(mpc.current_limit_ma if limit_ma is None else (-limit_ma, limit_ma)),
            None if step is None else _bounds(step),
            None
            if bound is None
            else SignalBounds(
                servo.plant.c,
                _bounds(bound),
                horizons.prediction,
                mpc.position_bound_samples or (),
            ),
        )
        return tracking_qp(
            servo.plant, horizons, extension or mpc.reference_extension, weights, constraints
        )
    except DesignError as error:
        key = f"controller.mpc.{_MPC_KEYS.get(error.key, error.key)}"
        raise servo.project.fault(key, error.value, error.expected) from error
    except ProgramError as error:
        _require_growth_below(servo, SOME_GROWTH)
        told, beside = (as_numbers(each) for each in (mpc.weight_change, mpc.weight_error))
        expected = f"one that is not lost beside weight_error = {value_text(beside)}"
        raise servo.project.error("controller.mpc.weight_change", told, expected) from error


def _require_growth_below(servo: ServoDrive, most: float) -> None:
    """Refuse a model one of whose modes grows by more than that over the prediction horizon."""
    steps = servo.project.controller.mpc.prediction_horizon
    simulated = "drive.a" if isinstance(servo.project.drive, MatricesDrive) else "drive"
    for key, plant in ((_model_key(servo, "a"), servo.plant), (simulated, servo.drive)):
        modes = np.linalg.eigvals(plant.a)
        fastest = complex(modes[np.argmax(np.abs(modes))])
        decades = steps * np.log10(max(abs(fastest), 1e-300))
        if decades > np.log10(most):
            shown = f"{fastest:.4g}" if fastest.imag else f"{fastest.real:.4g}"
            said = (
                f"unstable: its mode at z = {shown} grows by 1e{decades:.0f} over {steps} samples"
            )
            expected = "a model that grows less, or a shorter controller.mpc.prediction_horizon"
            raise servo.project.fault(key, said, expected)


def _model_key(servo: ServoDrive, name: str) -> str:
    """The key of one of the matrices that the controller is designed on."""
    if servo.project.controller.mpc.model is not None:
        return f"controller.mpc.model.{name}"
    return f"drive.{name}" if isinstance(servo.project.drive, MatricesDrive) else "drive"


def _bounds(limits: Limits) -> Bounds:
    return Bounds(np.array([limits[0]]), np.array([limits[1]]))


def mpc_design(
    servo: ServoDrive, problem: TrackingQp | None = None, precision: Precision | None = None
) -> ServoMpcDesign:
    """The MPC with its filter.

    Raises:
        InputError: an encoder that does not show every motion that stays, noise that settles no
            filter, a range that the precision cannot hold.
    """
    project, axis = servo.project, servo.project.axis
    estimator = project.controller.estimator
    program = problem or tracking_problem(servo)
    bounds = program.constraints.input
    assert bounds is not None
    noise = estimator.measurement_noise_deg or axis.encoder_resolution_deg / np.sqrt(12.0)
    order = servo.plant.order
    farthest = 0.5 * axis.turn_deg if axis.turn_deg else 2.0 * axis.position_range_deg
    try:
        found = design_filter(
            servo.plant,
            Noise(np.array([estimator.disturbance_step_ma]), np.zeros(order), np.array([noise])),
            [farthest],
            bounds.upper - bounds.lower,
        )
        return ServoMpcDesign(
            prefix=f"{project.name}_mpc",
            precision=precision or PRECISIONS[project.output.precision],
            problem=program,
            filter=found,
            reach=axis.position_range_deg,
            turn=float(axis.turn_deg),
        )
    except DesignError as error:
        raise _placed(servo, error) from error


def pid_design(
    servo: ServoDrive, limit_ma: float | None = None, precision: Precision | None = None
) -> PidDesign | None:
    """The cascaded PID, None where the project has none.

    Raises:
        InputError: a notch whose poles are not stable.
    """
    project, pid = servo.project, servo.project.controller.pid
    if pid is None:
        return None
    low, high = project.controller.mpc.current_limit_ma
    try:
        return PidDesign(
            prefix=f"{project.name}_pid",
            precision=precision or PRECISIONS[project.output.precision],
            position_gain_per_s=pid.position_gain_per_s,
            velocity_gain=pid.velocity_gain_ma_s_per_deg,
            integral_time_s=pid.integral_time_s,
            notch=_notch(pid),
            sample_time_s=project.sampling.sample_time_s,
            ratio=servo.ratio,
            current_low=low if limit_ma is None else -limit_ma,
            current_high=high if limit_ma is None else limit_ma,
            reach=project.axis.position_range_deg,
            turn=float(project.axis.turn_deg),
        )
    except DesignError as error:
        raise _placed(servo, error) from error


def lookup_choice(
    servo: ServoDrive, problem: TrackingQp | None = None, progress: Progress | None = None
) -> Choice:
    """The forms that the first move's lookup can take, and the cheapest.

    Raises:
        InputError: a program with more regions than the project allows, or without any form.
    """
    program, limits = problem or tracking_problem(servo), servo.project.controller.lookup
    try:
        return choose(
            program.qp, limits.max_regions, limits.search_nodes, progress, limits.max_nodes
        )
    except (ProgramError, SetError) as error:
        raise _unsolved(servo, error) from error


def servo_parts(
    servo: ServoDrive,
    choice: Choice,
    problem: TrackingQp | None = None,
    precision: Precision | None = None,
    progress: Progress | None = None,
) -> ServoParts:
    """All that is emitted for the project: the MPC with its lookup, and the PID.

    Args:
        choice: of ``lookup_choice`` for the same program.

    Raises:
        InputError: as ``mpc_design`` and ``pid_design``; a program whose lookup the precision
            cannot hold.
    """
    program = problem or tracking_problem(servo)
    mpc = mpc_design(servo, program, precision)
    try:
        lookup = design_lookup(
            lookup_prefix(mpc),
            mpc.precision,
            program.qp,
            choice,
            program.plant.sample_time_s,
            servo.project.controller.lookup.max_regions,
            progress=progress,
        )
    except (DesignError, ProgramError, SetError) as error:
        raise _unsolved(servo, error) from error
    return ServoParts(mpc, lookup, pid_design(servo, precision=mpc.precision))


# What cannot be found where a program's numbers do not tell its regions apart.
UNTOLD = ("active set", "set of facets", "search tree")


def _unsolved(servo: ServoDrive, error: DesignError | ProgramError | SetError) -> InputError:
    """A program without an explicit solution, or whose solution the precision cannot hold."""
    project, remedy = servo.project, _remedy(servo)
    limits = project.controller.lookup
    if error.key == "number of regions":
        expected = f"room for {error.value} regions, or {remedy}"
        return project.error("controller.lookup.max_regions", limits.max_regions, expected)
    if error.key == "number of tree nodes":
        expected = f"room for {error.value} nodes, or {remedy}"
        return project.error("controller.lookup.max_nodes", limits.max_nodes, expected)
    if isinstance(error, SetError) or error.key in UNTOLD:
        # linear programs among its regions that neither of two solvers settles, and the like
        said = "a program whose regions its numbers do not tell apart"
        return project.fault("controller.mpc", said, remedy)
    told = "will not do" if error.value is None else f"is {error.value}"
    return project.fault("controller.mpc", f"a program whose {error.key} {told}", error.expected)


def _remedy(servo: ServoDrive) -> str:
    """What makes a program smaller."""
    mpc = servo.project.controller.mpc
    if mpc.position_bound_deg is None:
        return "a shorter controller.mpc.control_horizon or fewer constraints"
    samples = mpc.position_bound_samples or range(1, mpc.prediction_horizon + 1)
    few = "position bounds at fewer samples than the "
    return (
        f"{few}{len(samples)} they hold at (controller.mpc.position_bound_samples, such as "
        f"[1, {min(10, mpc.prediction_horizon)}]), or a shorter controller.mpc.control_horizon"
    )


def _notch(pid: PidTable) -> Notch | None:
    if pid.notch is None:
        return None
    lead = pid.notch.denominator[0]
    b0, b1, b2 = (value / lead for value in pid.notch.numerator)
    a1, a2 = (value / lead for value in pid.notch.denominator[1:])
    return Notch(b0, b1, b2, a1, a2)


def _placed(servo: ServoDrive, error: DesignError) -> InputError:
    fault = servo.project.fault
    match error.key:
        case "c":
            return fault(_model_key(servo, "c"), error.value, error.expected)
        case "disturbance_noise":  # a load acts where the current does
            expected = "a model whose current reaches every mode that does not decay"
            return fault(_model_key(servo, "b"), error.value, expected)
        case "plant":
            expected = (
                f"{error.expected}, or a ratio of controller.estimator.disturbance_step_ma to "
                "measurement_noise_deg that is less extreme"
            )
            return fault(_model_key(servo, "a"), "a model without a Kalman filter", expected)
    model = "drive" if servo.project.controller.mpc.model is None else "controller.mpc.model"
    return fault(_KEYS.get(error.key, model), error.value, error.expected)
