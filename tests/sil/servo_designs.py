"""Small servo axes for the tests of the emitted C: all shapes that the templates can take."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from shared_builds import compiled_once

from servogen.controllers.kalman import Noise, design_filter
from servogen.controllers.lookup_design import design_lookup
from servogen.controllers.pid_design import Notch, PidDesign
from servogen.controllers.prediction import Horizons
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
from servogen.emit.package import CPackage, emit_package
from servogen.explicit.choose import Choice, choose
from servogen.plants.sampled import Sampled
from servogen.precision import PRECISIONS

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

from headstock_mpc import headstock_problem


@dataclass(frozen=True)
class Axis:
    """``kind``: ``headstock``, turning on; ``slide``, with limits on everything; ``pair`` of
    coupled axes. ``notch``: of the PID, which the pair has none of."""

    prefix: str
    kind: str = "headstock"
    precision: str = "float64"
    moves: int = 2
    turn: float = 360.0
    notch: bool = True


def _slide() -> TrackingQp:
    """A mass in friction, 2 ms: current, its change and the position limited, one move planned."""
    plant = Sampled(
        np.array([[0.98, 0.0], [0.002, 1.0]]),
        np.array([[0.4], [0.0004]]),
        np.array([[0.0, 1.0]]),
        0.002,
    )
    horizons = Horizons(8, 2, 1)
    return tracking_qp(
        plant,
        horizons,
        "first_order",
        Weights.constant(1e6, 1.0, plant, horizons),
        Constraints(
            Bounds([-100.0], [150.0]),
            Bounds([-120.0], [90.0]),
            SignalBounds(plant.c, Bounds([10.0], [50.0]), 3),
        ),
    )


def _pair() -> TrackingQp:
    """Two masses that push each other, each with its own drive."""
    a = np.eye(4)
    a[:2, :2] = [[0.95, 0.02], [0.03, 0.93]]
    a[2, 0] = a[3, 1] = 0.01
    b = np.array([[0.4, 0.05], [0.0, 0.5], [0.002, 0.0], [0.0, 0.0025]])
    c = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    plant, horizons = Sampled(a, b, c, 0.01), Horizons(6, 2, 1)
    weights = Weights.constant(100.0, 0.1, plant, horizons)
    return tracking_qp(
        plant, horizons, "first_order", weights, Constraints(Bounds([-2.0, -3.0], [2.0, 1.0]))
    )


@cache
def problem(axis: Axis) -> TrackingQp:
    match axis.kind:
        case "headstock":
            return headstock_problem(axis.moves, "first_order" if axis.moves > 1 else "zero_order")
        case "slide":
            return _slide()
    return _pair()


@cache
def choice(kind: str, moves: int) -> Choice:
    return choose(problem(Axis("", kind, moves=moves)).qp, 2000, 20)


@cache
def parts(axis: Axis) -> ServoParts:
    precision, program = PRECISIONS[axis.precision], problem(Axis("", axis.kind, moves=axis.moves))
    plant, turn = program.plant, 0.0 if axis.kind == "slide" else axis.turn
    reach = 60.0 if axis.kind == "slide" else 36_864.0
    bounds = program.constraints.input
    assert bounds is not None
    noise = Noise(np.full(plant.inputs, 5.0), np.zeros(plant.order), np.full(plant.outputs, 1e-3))
    found = design_filter(
        plant, noise, np.full(plant.outputs, 0.5 * turn or 2.0 * reach), bounds.upper - bounds.lower
    )
    mpc = ServoMpcDesign(f"{axis.prefix}_mpc", precision, program, found, reach, turn)
    lookup = design_lookup(
        lookup_prefix(mpc), precision, program.qp, choice(axis.kind, axis.moves),
        plant.sample_time_s, 2000,
    )  # fmt: skip
    notch = Notch(0.8, -1.55, 0.76, -1.5, 0.56) if axis.notch else None
    pid = PidDesign(
        f"{axis.prefix}_pid", precision, 21.67, 3.0, 0.02, notch, plant.sample_time_s, 3,
        float(bounds.lower[0]), float(bounds.upper[0]), reach, turn,
    )  # fmt: skip
    return ServoParts(mpc, lookup, None if axis.kind == "pair" else pid)


@cache
def package(axis: Axis) -> CPackage:
    return emit_package(axis.prefix, parts(axis).declarations())


@cache
def compiled(*axes: Axis) -> Any:
    return compiled_once([package(axis) for axis in axes], ["-O0"])
