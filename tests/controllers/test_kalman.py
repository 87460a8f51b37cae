"""The steady-state filter: its gain against a plain recursion, its refusals, its bound."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from headstock_mpc import HEADSTOCK, PERIOD, PLANT, PRINTED
from hypothesis import given, settings
from hypothesis import strategies as st
from random_tracking import random_plant

from servogen.controllers.errors import DesignError
from servogen.controllers.kalman import FilterDesign, Noise, design_filter
from servogen.controllers.velocity_form import velocity_form
from servogen.plants.sampled import Sampled

NOISE = Noise(np.array([5.0]), np.zeros(4), np.array([1e-4]))


def recursion(plant: Sampled, noise: Noise, steps: int) -> np.ndarray:
    """The time-varying filter's gain (n+m, m) after so many samples, in the Joseph form."""
    form = velocity_form(plant)
    reach = np.hstack([plant.b * noise.disturbance, np.diag(noise.state)])
    reach = np.vstack([reach, plant.c @ reach])
    q, r = reach @ reach.T, np.diag(noise.measurement**2)
    size = form.a.shape[0]
    p = q + 1e-6 * np.eye(size)
    gain = np.zeros((size, plant.outputs))
    for _ in range(steps):
        gain = np.linalg.solve(form.c @ p @ form.c.T + r, form.c @ p).T
        kept = np.eye(size) - gain @ form.c
        p = form.a @ (kept @ p @ kept.T + gain @ r @ gain.T) @ form.a.T + q
    return gain


@pytest.mark.parametrize("plant", [PLANT, PRINTED], ids=["model", "printed"])
@pytest.mark.parametrize("ratio", [1.0, 100.0])
def test_the_gain_is_where_the_recursion_settles(plant: Sampled, ratio: float) -> None:
    noise = dataclasses.replace(NOISE, disturbance=ratio * NOISE.disturbance)
    found = design_filter(plant, noise, [180.0], [2000.0])
    expected = recursion(plant, noise, 4000)
    got = np.vstack([found.on_increment, found.on_output])
    np.testing.assert_allclose(got, expected, rtol=1e-4)
    assert found.decay < 1.0


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), sizes=st.tuples(st.integers(2, 4), *[st.integers(1, 2)] * 2))
def test_so_it_is_for_several_outputs(seed: int, sizes: tuple[int, int, int]) -> None:
    plant = random_plant(seed, *sizes)
    noise = Noise(
        np.full(plant.inputs, 0.3), np.full(plant.order, 0.2), np.full(plant.outputs, 0.1)
    )
    try:
        found = design_filter(plant, noise, np.ones(plant.outputs), np.ones(plant.inputs))
    except DesignError:  # a random mode that hardly shows
        return
    expected = recursion(plant, noise, 600)
    got = np.vstack([found.on_increment, found.on_output])
    np.testing.assert_allclose(got, expected, rtol=1e-5, atol=1e-8)


def estimate(found: FilterDesign, outputs: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """(K, n+m) increments and outputs estimated from absolute outputs (K, m), inputs (K, l)."""
    form = velocity_form(found.plant)
    gain = np.vstack([found.on_increment, found.on_output])
    state = np.concatenate([np.zeros(found.plant.order), outputs[0]])
    rows, before = [], np.zeros(inputs.shape[1])
    for y, u in zip(outputs, inputs, strict=True):
        state = state + gain @ (y - form.c @ state)
        rows.append(state)
        state = form.a @ state + form.b @ (u - before)
        before = u
    return np.array(rows)


def test_a_constant_load_leaves_no_error() -> None:
    """The load appears in no increment, so the estimate of them is unbiased with any of it."""
    torque, steps = 20.0, 1500
    both = HEADSTOCK.disturbed(PERIOD)
    generator = np.random.default_rng(1)
    inputs = np.cumsum(generator.normal(size=(steps, 1)), axis=0)
    states = [np.zeros(4)]
    for u in inputs:
        states.append(both.a @ states[-1] + both.b @ np.array([u[0], torque]))
    states = np.array(states)
    found = design_filter(PLANT, NOISE, [180.0], [2000.0])
    got = estimate(found, states[:-1] @ PLANT.c.T, inputs)
    increments = np.diff(states, axis=0)[:-1]  # x(k) - x(k-1), k = 1..
    error = np.abs(got[1:, :4] - increments)
    assert np.max(error[100]) > 1e-6
    np.testing.assert_array_less(error[-1], 1e-9 * (1.0 + np.max(np.abs(increments), axis=0)))


def test_no_measurement_takes_the_estimate_beyond_its_bound() -> None:
    found = design_filter(PLANT, NOISE, [3.0], [500.0])
    generator = np.random.default_rng(2)
    worst = np.zeros(4)
    for _ in range(20):
        outputs = np.cumsum(generator.choice([-3.0, 3.0], size=(800, 1)), axis=0)
        inputs = np.cumsum(generator.choice([-500.0, 500.0], size=(800, 1)), axis=0)
        worst = np.maximum(worst, np.max(np.abs(estimate(found, outputs, inputs)[:, :4]), axis=0))
    assert np.all(worst <= found.increment_bound)
    assert np.all(worst >= 0.1 * found.increment_bound)


def test_what_the_encoder_cannot_show_is_refused() -> None:
    """A speed does not show where the axis stands; a mode of its own that grows shows nowhere."""
    blind = Sampled(PLANT.a, PLANT.b, [[1.0, 0.0, 0.0, 0.0]], PERIOD)
    with pytest.raises(DesignError, match=r"blind to the mode at z = 1\b.*detectability"):
        design_filter(blind, NOISE, [180.0], [2000.0])
    hidden = Sampled(np.diag([0.5, 1.2]), np.array([[1.0], [1.0]]), np.array([[1.0, 0.0]]), PERIOD)
    noise = Noise(np.ones(1), np.ones(2), np.ones(1))
    with pytest.raises(DesignError, match=r"z = 1.2"):
        design_filter(hidden, noise, [1.0], [1.0])
    decaying = Sampled(np.diag([0.5, 0.8]), hidden.b, hidden.c, PERIOD)
    assert design_filter(decaying, noise, [1.0], [1.0]).decay < 1.0


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"disturbance": np.zeros(1)}, "disturbance_noise"),
        ({"measurement": np.zeros(1)}, "measurement_noise"),
        ({"measurement": np.array([np.nan])}, "measurement_noise"),
        ({"state": np.zeros(3)}, "state_noise"),
    ],
)
def test_noise_that_settles_nothing_is_refused(change: dict[str, np.ndarray], key: str) -> None:
    with pytest.raises(DesignError) as caught:
        design_filter(PLANT, dataclasses.replace(NOISE, **change), [180.0], [2000.0])
    assert caught.value.key == key
