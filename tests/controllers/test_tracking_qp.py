"""Velocity form, prediction, cost and constraints against plain simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_tracking import (
    extended,
    random_plant,
    random_problem,
    random_situation,
    simulated_cost,
    simulated_states,
    theta_of,
)

from servogen.controllers.errors import DesignError
from servogen.controllers.prediction import Horizons, extension, predict
from servogen.controllers.tracking_qp import (
    Bounds,
    Constraints,
    SignalBounds,
    Weights,
    tracking_qp,
)
from servogen.controllers.velocity_form import velocity_form

MANY = settings(max_examples=60, deadline=None, derandomize=True)
SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.tuples(st.integers(1, 4), st.integers(1, 3), st.integers(1, 3))
EXTENSIONS = st.sampled_from(["zero_order", "first_order"])


@st.composite
def horizons(draw: st.DrawFn) -> Horizons:
    prediction = draw(st.integers(2, 12))
    return Horizons(prediction, draw(st.integers(2, prediction)), draw(st.integers(1, prediction)))


@MANY
@given(seed=SEEDS, sizes=SIZES)
def test_the_velocity_form_runs_as_the_plant_does(seed: int, sizes: tuple[int, int, int]) -> None:
    plant = random_plant(seed, *sizes)
    form = velocity_form(plant)
    generator = np.random.default_rng(seed)
    states = [generator.normal(size=plant.order) for _ in range(1)]
    inputs = generator.normal(size=(6, plant.inputs))
    for u in inputs:
        states.append(plant.a @ states[-1] + plant.b @ u)
    x = np.concatenate([states[1] - states[0], plant.c @ states[1]])
    for k in range(1, 6):
        np.testing.assert_allclose(form.c @ x, plant.c @ states[k], atol=1e-9)
        x = form.a @ x + form.b @ (inputs[k] - inputs[k - 1])
    np.testing.assert_allclose(x[: plant.order], states[6] - states[5], atol=1e-9)


@MANY
@given(seed=SEEDS, sizes=SIZES, span=horizons())
def test_prediction_is_simulation(seed: int, sizes: tuple[int, int, int], span: Horizons) -> None:
    plant = random_plant(seed, *sizes)
    problem, _ = random_problem(seed, plant, span, "zero_order", Constraints())
    moment = random_situation(seed, plant, span)
    inputs = np.random.default_rng(seed + 1).normal(size=(span.control, plant.inputs))
    ahead = predict(plant, span.prediction, span.control)
    changes = np.diff(np.vstack([moment.previous, inputs]), axis=0).ravel()
    found = ahead.on_increment @ (moment.now - moment.before) + ahead.on_change @ changes
    outputs = simulated_states(problem, moment, inputs) @ plant.c.T
    expected = (outputs - plant.c @ moment.now).ravel()
    np.testing.assert_allclose(found, expected, atol=1e-8)


@MANY
@given(seed=SEEDS, span=horizons(), kind=EXTENSIONS, outputs=st.integers(1, 3))
def test_the_reference_is_extended_as_it_is_told(seed, span, kind, outputs) -> None:
    references = np.random.default_rng(seed).normal(size=(span.trajectory, outputs))
    found = extension(span, kind, outputs) @ references.ravel()
    expected = extended(references, span.prediction, kind)
    np.testing.assert_allclose(found.reshape(-1, outputs), expected, atol=1e-10)


@MANY
@given(seed=SEEDS, sizes=SIZES, span=horizons(), kind=EXTENSIONS)
def test_the_cost_is_the_sum_it_stands_for(seed, sizes, span, kind) -> None:
    plant = random_plant(seed, *sizes)
    problem, weights = random_problem(seed, plant, span, kind, Constraints())
    moment = random_situation(seed, plant, span)
    theta = theta_of(problem, moment)
    generator = np.random.default_rng(seed + 1)

    def condensed(u: np.ndarray) -> float:
        return float(0.5 * u @ problem.qp.H @ u + (problem.qp.F @ theta + problem.qp.f) @ u)

    one, two = generator.normal(size=(2, span.control * plant.inputs))
    costs = [
        simulated_cost(problem, weights, kind, moment, u.reshape(-1, plant.inputs))
        for u in (one, two)
    ]
    found = condensed(one) - condensed(two)
    assert found == pytest.approx(costs[0] - costs[1], abs=1e-9 * (1.0 + max(costs)))


@MANY
@given(seed=SEEDS, sizes=SIZES, span=horizons(), kind=EXTENSIONS)
def test_the_program_is_the_papers_in_other_coordinates(seed, sizes, span, kind) -> None:
    """(9) as printed, in changes of the inputs and with the output in the parameter; there the
    references and the output are a million, here their differences are of size one."""
    plant = random_plant(seed, *sizes)
    problem, weights = random_problem(seed, plant, span, kind, Constraints())
    moment = random_situation(seed, plant, span)
    form = velocity_form(plant)
    powers = [form.c @ np.linalg.matrix_power(form.a, i) for i in range(span.prediction + 1)]
    psi = np.vstack(powers[1:])
    theta = np.zeros((span.prediction, plant.outputs, span.control, plant.inputs))
    for i in range(span.prediction):
        for j in range(min(i + 1, span.control)):
            theta[i, :, j] = powers[i - j] @ form.b
    big = theta.reshape(psi.shape[0], -1)
    q = np.diag(weights.output.ravel())
    hessian = 2.0 * np.diag(weights.change.ravel()) + 2.0 * big.T @ q @ big
    shift = 2.0**20  # exact in binary
    x = np.concatenate([moment.now - moment.before, plant.c @ moment.now + shift])
    references = extended(moment.references + shift, span.prediction, kind).ravel()
    changes = np.linalg.solve(hessian, -2.0 * big.T @ q @ (psi @ x - references))
    expected = moment.previous + np.cumsum(changes.reshape(-1, plant.inputs), axis=0)
    qp = problem.qp
    found = np.linalg.solve(qp.H, -(qp.F @ theta_of(problem, moment) + qp.f))
    size = 1.0 + np.max(np.abs(expected)) + np.max(np.abs(psi))
    np.testing.assert_allclose(found, expected.ravel(), atol=1e-7 * size)


@MANY
@given(seed=SEEDS, sizes=SIZES, span=horizons())
def test_the_rows_are_the_bounds_of_what_is_simulated(seed, sizes, span) -> None:
    """All three kinds: G U - S theta - w is each value's excess over its bound."""
    plant = random_plant(seed, *sizes)
    generator = np.random.default_rng(seed + 2)
    inputs, signals = plant.inputs, 2
    rows = generator.normal(size=(signals, plant.order))

    def bounds(k: int) -> Bounds:
        return Bounds(-generator.uniform(0.1, 2.0, k), generator.uniform(0.1, 2.0, k))

    steps = int(generator.integers(1, span.prediction + 1))
    constraints = Constraints(
        bounds(inputs), bounds(inputs), SignalBounds(rows, bounds(signals), steps)
    )
    problem, _ = random_problem(seed, plant, span, "zero_order", constraints)
    assert not problem.is_box
    moment = random_situation(seed, plant, span)
    u = generator.normal(size=(span.control, inputs))
    qp = problem.qp
    found = qp.G @ u.ravel() - qp.w - qp.S @ theta_of(problem, moment)
    values = (
        (u, constraints.input),
        (np.diff(np.vstack([moment.previous, u]), axis=0), constraints.change),
        (simulated_states(problem, moment, u)[:steps] @ rows.T, constraints.signal.bounds),
    )
    expected = []
    for value, bound in values:
        expected += [(value - bound.upper).ravel(), (bound.lower - value).ravel()]
    np.testing.assert_allclose(found, np.concatenate(expected), atol=1e-8)


def test_input_bounds_alone_make_a_box_and_infinite_ones_no_row() -> None:
    plant = random_plant(3, 3, 2, 1)
    span = Horizons(6, 2, 3)
    half = Constraints(input=Bounds([-np.inf, -1.0], [2.0, np.inf]))
    problem, _ = random_problem(1, plant, span, "zero_order", half)
    assert problem.is_box
    assert problem.qp.rows == 3 * 2
    assert problem.layout.size == 3 + 2 + 2


def test_a_box_of_parameters_is_passed_on() -> None:
    plant, span = random_plant(3), Horizons(6, 2, 3)
    weights = Weights.constant(1.0, 0.5, plant, span)
    box = Bounds.symmetric(np.arange(1.0, 7.0))
    problem = tracking_qp(plant, span, "zero_order", weights, Constraints(), box)
    np.testing.assert_array_equal(problem.qp.upper, np.arange(1.0, 7.0))
    with pytest.raises(DesignError, match="box"):
        tracking_qp(plant, span, "zero_order", weights, Constraints(), Bounds.symmetric([1.0]))


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda plant: Horizons(0, 1, 1), "prediction"),
        (lambda plant: Horizons(5, 6, 1), "trajectory"),
        (lambda plant: Horizons(5, 1, 6), "control"),
        (lambda plant: extension(Horizons(5, 1, 1), "first_order", 1), "trajectory"),
        (lambda plant: Bounds([1.0], [1.0]), "lower"),
        (lambda plant: Bounds([np.nan], [1.0]), "lower"),
        (lambda plant: Weights([[1.0]], [[0.0]]), "change"),
        (lambda plant: Weights([[-1.0]], [[1.0]]), "output"),
        (lambda plant: _asked(plant, Constraints(input=Bounds.symmetric([1.0, 1.0]))), "input"),
        (
            lambda plant: _asked(
                plant,
                Constraints(signal=SignalBounds(np.eye(2), Bounds.symmetric([1.0, 1.0]), 1)),
            ),
            "signal",
        ),
        (
            lambda plant: _asked(
                plant,
                Constraints(signal=SignalBounds(np.eye(3), Bounds.symmetric(np.ones(3)), 99)),
            ),
            "steps",
        ),
    ],
)
def test_what_does_not_fit_is_refused(make, key: str) -> None:
    with pytest.raises(DesignError) as caught:
        make(random_plant(1))
    assert caught.value.key == key


def _asked(plant, constraints: Constraints):
    span = Horizons(5, 2, 2)
    weights = Weights.constant(1.0, 1.0, plant, span)
    return tracking_qp(plant, span, "zero_order", weights, constraints)
