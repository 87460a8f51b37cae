"""Trajectory-tracking MPC of a servo axis: estimate, parameter, first move; its declaration.

A step takes the measured position and the next H_t references. The filter's estimate and the
references less the position are the parameter of the program; the first input of its solution goes
to the drive. How that is found (tree, clips, online) is the affair of a ``FirstMove``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Status,
    Table,
)
from servogen.controllers.errors import DesignError
from servogen.controllers.kalman import FilterDesign
from servogen.controllers.tracking_qp import Bounds, TrackingQp
from servogen.controllers.wrapping import Wrapping, turn_constants
from servogen.precision import FloatArray, Precision


class FirstMove(Protocol):
    """The first input (l,) for a parameter, both in the target precision; INFEASIBLE where the
    program has no solution, OK otherwise."""

    def __call__(self, theta: FloatArray) -> tuple[Status, FloatArray]: ...


@dataclass(frozen=True)
class ServoMpcDesign:
    """All that the emitted controller is made of but for the first move's lookup.

    Attributes:
        reach: largest magnitude of a measured or wanted position, in the outputs' unit.
        turn: units of position in one turn of an axis that comes round, 0 for one that does not.
        input_unit, output_unit: for the comments.

    Raises:
        DesignError: no finite bounds on the inputs, bounds that zero does not lie between, signals
            in (12) that are not the measured outputs, or such on an axis that comes round.
    """

    prefix: str
    precision: Precision
    problem: TrackingQp
    filter: FilterDesign
    reach: float
    turn: float
    input_unit: str = "mA"
    output_unit: str = "deg"

    def __post_init__(self) -> None:
        bounds = self.problem.constraints.input
        if bounds is None or not np.all(np.isfinite([bounds.lower, bounds.upper])):
            raise DesignError("input", None, "finite bounds on every input")
        for key, pair in (("input", bounds), ("change", self.problem.constraints.change)):
            if pair is not None and not (np.all(pair.lower <= 0.0) and np.all(pair.upper >= 0.0)):
                raise DesignError(key, list(pair.lower), "bounds with zero between them")
        signal = self.problem.constraints.signal
        if signal is not None and not np.array_equal(signal.rows, self.problem.plant.c):
            raise DesignError("signal", None, "bounds on the measured outputs alone")
        if signal is not None and self.turn:
            raise DesignError("signal", None, "no bounds on the position of an axis that wraps")
        Wrapping(self.turn, self.reach, self.precision)

    @property
    def input_bounds(self) -> Bounds:
        """(10), finite."""
        bounds = self.problem.constraints.input
        assert bounds is not None
        return bounds

    @property
    def change_bounds(self) -> Bounds:
        """(11), infinite where there is none."""
        found = self.problem.constraints.change
        return found or Bounds.symmetric(np.full(self.problem.plant.inputs, np.inf))

    @property
    def parameter_bound(self) -> float:
        """No step makes an entry of theta larger, whatever comes: the lookup relies on it.

        Inputs are checked, increments and last currents kept within bounds; what is left is how far
        references lie ahead, and the output's estimate off, twice for all roundings.
        """
        plant, found = self.problem.plant, self.filter
        innovation = 0.5 * self.turn or 4.0 * self.reach
        gain = float(np.max(np.sum(np.abs(found.on_output - np.eye(plant.outputs)), axis=1)))
        ahead = 0.5 * self.turn * self.problem.horizons.trajectory or 2.0 * self.reach
        own = [*found.increment_bound, *np.abs(self.input_bounds.lower), *self.input_bounds.upper]
        return float(2.0 * max(*own, ahead + gain * innovation))


def _ports(design: ServoMpcDesign) -> tuple[tuple[Port, ...], tuple[Port, ...], Port]:
    plant, unit = design.problem.plant, design.output_unit
    m, inputs, reach = plant.outputs, plant.inputs, design.reach
    position = Port(
        "position", unit, "measured now", 0 if m == 1 else m, low=-reach, high=reach
    )  # fmt: skip
    reference = Port(
        "reference",
        unit,
        "wanted one to H_t samples ahead" + ("" if m == 1 else ", the outputs of one together"),
        size=design.problem.horizons.trajectory * m,
        low=-reach,
        high=reach,
    )
    low, high = design.input_bounds.lower, design.input_bounds.upper
    current = Port(
        "current",
        design.input_unit,
        "what the drive is given; moves towards zero where the status is not OK",
        0 if inputs == 1 else inputs,
        low=float(np.min(low)),
        high=float(np.max(high)),
    )
    return (position,), (position, reference), current


def lookup_prefix(design: ServoMpcDesign) -> str:
    """Prefix of the controller that finds the first move."""
    return f"{design.prefix}_lookup"


def declare_servo_mpc(design: ServoMpcDesign) -> Declaration:
    """Names, sizes, tables and ports; ``theta`` is laid out as ``tracking_qp.Layout`` says."""
    problem, found = design.problem, design.filter
    plant, period = problem.plant, problem.plant.sample_time_s
    at_rest, at_work, current = _ports(design)
    identity = np.eye(plant.outputs)
    most = 0.25 * design.precision.max  # for none
    limited = problem.constraints.change is not None
    bounds = [("input", design.input_bounds)]
    bounds += [("change", design.change_bounds)] if limited else []
    return Declaration(
        kind="servo_mpc",
        prefix=design.prefix,
        summary="Trajectory-tracking MPC of a servo axis, with its Kalman filter",
        precision=design.precision,
        sample_time_s=period,
        dimensions=(
            Dimension("ORDER", plant.order, "n, states"),
            Dimension("INPUTS", plant.inputs, "l"),
            Dimension("OUTPUTS", plant.outputs, "m"),
            Dimension("TRAJECTORY", problem.horizons.trajectory, "H_t, references taken"),
            Dimension("PARAMETERS", problem.layout.size, "length of theta"),
        ),
        constants=turn_constants(design.turn, design.output_unit)
        or (Constant("twice_reach", 2.0 * design.reach, "two positions are not farther apart"),),
        tables=(
            Table("on_state", plant.a.T, "A_p, transposed"),
            Table("on_input", plant.b.T, "B_p, transposed"),
            Table("on_output", plant.c.T, "C_p, transposed"),
            Table("gain_state", found.on_increment.T, "Kalman gain of dx_p, transposed"),
            Table(
                "gain_output",
                (found.on_output - identity).T,
                "of the output's estimate, less what is measured, transposed",
            ),
            Table("bound", found.increment_bound, "largest dx_p that measurements can make"),
            *(
                Table(
                    f"{name}_{side}",
                    np.clip(getattr(pair, attribute), -most, most),
                    f"{what} of (1{i})",
                )
                for i, (name, pair) in enumerate(bounds)
                for side, attribute, what in (
                    ("low", "lower", "lower bounds"),
                    ("high", "upper", "upper bounds"),
                )
            ),
        ),
        state=(
            StateField("increment", "dx_p, predicted for the next sample", "ORDER"),
            StateField("drift", "output predicted for it, less the last measured", "OUTPUTS"),
            StateField("last", "last usable measurement", "OUTPUTS"),
            StateField("previous", "u(k-1)", "INPUTS"),
            StateField("lookup", "of the first move", type=lookup_prefix(design)),
            StateField("ready", "whether reset has been called", type="int32_t"),
        ),
        operations=(
            Operation("reset", "The axis stands at a position, without current.", at_rest),
            Operation(
                "step",
                "One sample: measure, estimate, look up, bound; then predict the next.",
                at_work,
                (current,),
                period_s=period,
            ),
        ),
        uses=(lookup_prefix(design),),
        facts={"comes_round": bool(design.turn), "limits_change": limited,
               "bounds_signal": problem.constraints.signal is not None},
    )  # fmt: skip
