"""Random plants and tracking problems, and their costs and signals by plain simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.prediction import Extension, Horizons
from servogen.controllers.tracking_qp import Constraints, TrackingQp, Weights, tracking_qp
from servogen.plants.sampled import Sampled


@dataclass
class Situation:
    """One moment: two successive states, the input between them, the references ahead."""

    before: np.ndarray
    now: np.ndarray
    previous: np.ndarray
    references: np.ndarray  # (H_t, m)


def random_plant(seed: int, n: int = 3, inputs: int = 1, outputs: int = 1) -> Sampled:
    generator = np.random.default_rng(seed)
    a = generator.normal(size=(n, n))
    a *= generator.uniform(0.5, 1.05) / np.max(np.abs(np.linalg.eigvals(a)))
    b, c = generator.normal(size=(n, inputs)), generator.normal(size=(outputs, n))
    return Sampled(a, b, c, 0.1)


def random_problem(
    seed: int, plant: Sampled, horizons: Horizons, extend: Extension, constraints: Constraints
) -> tuple[TrackingQp, Weights]:
    generator = np.random.default_rng(seed)
    weights = Weights(
        generator.uniform(0.0, 2.0, size=(horizons.prediction, plant.outputs)),
        generator.uniform(0.1, 2.0, size=(horizons.control, plant.inputs)),
    )
    return tracking_qp(plant, horizons, extend, weights, constraints), weights


def random_situation(seed: int, plant: Sampled, horizons: Horizons) -> Situation:
    generator = np.random.default_rng(seed)
    before = generator.normal(size=plant.order)
    previous = generator.normal(size=plant.inputs)
    references = generator.normal(size=(horizons.trajectory, plant.outputs))
    return Situation(before, plant.a @ before + plant.b @ previous, previous, references)


def theta_of(problem: TrackingQp, moment: Situation) -> np.ndarray:
    """The parameter in the order that ``Layout`` says."""
    layout, plant = problem.layout, problem.plant
    theta = np.zeros(layout.size)
    theta[layout.increment] = moment.now - moment.before
    theta[layout.previous] = moment.previous
    theta[layout.reference] = (moment.references - plant.c @ moment.now).ravel()
    if problem.constraints.signal is not None:
        theta[layout.signal] = problem.constraints.signal.rows @ moment.now
    return theta


def simulated_states(problem: TrackingQp, moment: Situation, inputs: np.ndarray) -> np.ndarray:
    """(H_p, n) states 1..H_p under inputs (H_u, l), the last one held."""
    state, states = moment.now, []
    for i in range(problem.horizons.prediction):
        state = problem.plant.a @ state + problem.plant.b @ inputs[min(i, len(inputs) - 1)]
        states.append(state)
    return np.array(states)


def extended(references: np.ndarray, steps: int, extend: Extension) -> np.ndarray:
    """(H_p, m): the references given, then the last one or the line through the last two."""
    rows = list(references[:steps])
    while len(rows) < steps:
        rows.append(rows[-1] if extend == "zero_order" else 2.0 * rows[-1] - rows[-2])
    return np.array(rows)


def simulated_cost(
    problem: TrackingQp,
    weights: Weights,
    extend: Extension,
    moment: Situation,
    inputs: np.ndarray,
) -> float:
    """(7) term by term."""
    outputs = simulated_states(problem, moment, inputs) @ problem.plant.c.T
    errors = outputs - extended(moment.references, problem.horizons.prediction, extend)
    changes = np.diff(np.vstack([moment.previous, inputs]), axis=0)
    return float(np.sum(weights.output * errors**2) + np.sum(weights.change * changes**2))
