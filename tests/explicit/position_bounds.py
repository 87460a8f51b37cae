"""Tracking programs with bounds (12) on the position, as a drive's project file makes them."""

from __future__ import annotations

import numpy as np

from servogen.controllers.prediction import Horizons
from servogen.controllers.tracking_qp import (
    Bounds,
    Constraints,
    SignalBounds,
    Weights,
    tracking_qp,
)
from servogen.explicit.solution import ExplicitSolution
from servogen.plants.sampled import Sampled
from servogen.plants.two_mass import TwoMass
from servogen.qp.parametric import ParametricQP


def free_mass() -> Sampled:
    """Degrees per milliampere, twice integrated, at 500 us."""
    a, b = np.array([[1.0, 5e-4], [0.0, 1.0]]), np.array([[3.6e-7], [1.44e-3]])
    return Sampled(a, b, np.array([[1.0, 0.0]]), 5e-4)


def headstock() -> Sampled:
    """The two-mass drive of the bundled example."""
    inertia = 0.01
    return TwoMass(
        inertia, inertia / 0.285, 59500.0, 0.48, 0.01, inertia / 0.285, 2.254
    ).sampled(5e-4)  # fmt: skip


def program(
    plant: Sampled, control: int, prediction: int, bound: float, samples: tuple[int, ...] = ()
) -> ParametricQP:
    """|u| <= 1000 mA, |y| <= bound at the samples, all of the horizon if none are named."""
    horizons = Horizons(prediction, min(3, prediction), control)
    weights = Weights.constant(1e6, 1.0, plant, horizons)
    signal = SignalBounds(plant.c, Bounds.symmetric([bound]), prediction, samples)
    constraints = Constraints(Bounds.symmetric([1000.0]), None, signal)
    return tracking_qp(plant, horizons, "first_order", weights, constraints).qp


def parameters(solution: ExplicitSolution, each: int, seed: int = 0) -> np.ndarray:
    """Of every region some inside its ball, and one on each facet but a hair."""
    generator = np.random.default_rng(seed)
    eta = []
    for region in solution.regions:
        way = generator.normal(size=(each, region.centre.size))
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        eta += list(region.centre + 0.9 * region.radius * way)
        for h, k in zip(region.h, region.k, strict=True):
            foot = region.centre + h * (k - h @ region.centre)
            if np.all(region.h @ foot <= region.k + 1e-9):
                eta.append(foot - 1e-6 * h)
    back = np.linalg.pinv(solution.image.matrix)
    found: np.ndarray = (np.array(eta) - solution.image.offset) @ back.T
    return found
