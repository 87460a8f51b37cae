"""The headstock axis under its MPC, as the tests of controllers and systems build it."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "plants"))

from headstock import HEADSTOCK, PERIOD, PRINTED  # noqa: F401

from servogen.controllers.kalman import Noise, design_filter
from servogen.controllers.prediction import Extension, Horizons
from servogen.controllers.servo_mpc import ServoMpc, SolvedMove
from servogen.controllers.servo_mpc_design import ServoMpcDesign
from servogen.controllers.tracking_qp import (
    Bounds,
    Constraints,
    SignalBounds,
    TrackingQp,
    Weights,
    tracking_qp,
)
from servogen.plants.sampled import Sampled
from servogen.precision import PRECISIONS

PLANT = HEADSTOCK.sampled(PERIOD)
ENCODER = 360.0 / 2**20


def headstock_problem(
    trajectory: int = 3,
    extend: Extension = "first_order",
    limit: float = 1000.0,
    change: float | None = None,
    position: float | None = None,
    plant: Sampled = PLANT,
) -> TrackingQp:
    """Horizons and weights of the paper, H_u = H_t."""
    horizons = Horizons(50, trajectory, trajectory)
    constraints = Constraints(
        Bounds.symmetric([limit]),
        None if change is None else Bounds.symmetric([change]),
        None if position is None else SignalBounds(plant.c, Bounds.symmetric([position]), 50),
    )
    weights = Weights.constant(1e6, 1.0, plant, horizons)
    return tracking_qp(plant, horizons, extend, weights, constraints)


def headstock_design(
    precision: str = "float64",
    turn: float = 360.0,
    reach: float = 36_864.0,
    problem: TrackingQp | None = None,
) -> ServoMpcDesign:
    problem = problem or headstock_problem()
    limit = problem.constraints.input
    assert limit is not None
    noise = Noise(np.array([5.0]), np.zeros(4), np.array([ENCODER]))
    found = design_filter(problem.plant, noise, [180.0], limit.upper - limit.lower)
    return ServoMpcDesign("axis", PRECISIONS[precision], problem, found, reach, turn)


def headstock_mpc(**kwargs) -> ServoMpc:
    design = headstock_design(**kwargs)
    return ServoMpc(design, SolvedMove(design.problem, design.precision))
