"""The two-mass drive and sampled plants of several inputs and outputs."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from headstock import HEADSTOCK, PERIOD, PRINTED
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete

from servogen.plants.errors import PlantError
from servogen.plants.sampled import Sampled, hold


def two_digits(values: np.ndarray) -> list[str]:
    return [f"{value:.1e}" for value in np.ravel(values)]


def test_the_headstock_rounds_to_all_that_is_printed() -> None:
    held = HEADSTOCK.sampled(PERIOD)
    assert two_digits(held.a) == two_digits(PRINTED.a)
    assert two_digits(held.b) == two_digits(PRINTED.b)
    assert two_digits(held.c) == two_digits(PRINTED.c)


def test_the_model_is_newton_s_law() -> None:
    """Against the two equations of motion written out, by an integrator of another house."""
    h = HEADSTOCK
    current, torque = 700.0, -3.0

    def motion(_: float, x: np.ndarray) -> list[float]:
        motor, load, angle, load_angle = x
        twist = h.stiffness_n_m_per_rad * (angle - load_angle) + (
            h.coupling_damping_n_m_s_per_rad * (motor - load)
        )
        drive = h.torque_constant_n_m_per_a * current / 1000.0
        return [
            (drive - twist - h.motor_friction_n_m_s_per_rad * motor) / h.motor_inertia_kg_m2,
            (twist + torque - h.load_friction_n_m_s_per_rad * load) / h.load_inertia_kg_m2,
            motor,
            load,
        ]

    start = np.array([1.0, -2.0, 0.001, -0.002])
    found = solve_ivp(motion, (0.0, PERIOD), start, rtol=1e-11, atol=1e-13, method="DOP853")
    held = h.disturbed(PERIOD)
    expected = held.a @ start + held.b @ np.array([current, torque])
    np.testing.assert_allclose(found.y[:, -1], expected, rtol=1e-8)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 5),
    inputs=st.integers(1, 3),
    outputs=st.integers(1, 3),
)
def test_hold_of_several_inputs_equals_scipy(seed: int, n: int, inputs: int, outputs: int) -> None:
    generator = np.random.default_rng(seed)
    a = generator.normal(size=(n, n))
    b, c = generator.normal(size=(n, inputs)), generator.normal(size=(outputs, n))
    ours = hold(a, b, c, 0.3)
    a_d, b_d, *_ = cont2discrete((a, b, c, np.zeros((outputs, inputs))), 0.3, method="zoh")
    np.testing.assert_allclose(ours.a, a_d, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(ours.b, b_d, rtol=1e-10, atol=1e-12)
    assert (ours.order, ours.inputs, ours.outputs) == (n, inputs, outputs)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("motor_inertia_kg_m2", 0.0),
        ("stiffness_n_m_per_rad", -1.0),
        ("load_friction_n_m_s_per_rad", -0.1),
        ("torque_constant_n_m_per_a", float("nan")),
    ],
)
def test_impossible_parameters_are_refused(key: str, value: float) -> None:
    with pytest.raises(PlantError, match=key):
        dataclasses.replace(HEADSTOCK, **{key: value})


def test_no_friction_is_possible() -> None:
    free = dataclasses.replace(HEADSTOCK, motor_friction_n_m_s_per_rad=0.0)
    assert free.a[0, 0] == pytest.approx(-48.0)


@pytest.mark.parametrize(
    ("key", "a", "b", "c", "period"),
    [
        ("a", np.zeros((2, 3)), np.zeros((2, 1)), np.zeros((1, 2)), 1.0),
        ("b", np.eye(2), np.zeros(2), np.zeros((1, 2)), 1.0),
        ("c", np.eye(2), np.zeros((2, 1)), np.zeros((1, 3)), 1.0),
        ("a", np.full((2, 2), np.inf), np.zeros((2, 1)), np.zeros((1, 2)), 1.0),
        ("sample_time_s", np.eye(2), np.zeros((2, 1)), np.zeros((1, 2)), 0.0),
    ],
)
def test_shapes_that_do_not_fit_are_refused(key, a, b, c, period) -> None:
    with pytest.raises(PlantError) as caught:
        Sampled(a, b, c, period)
    assert caught.value.key == key
