"""Motion states, transfer functions, and what a stage's settings become."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.plants.build import build_stage, fast_plant, slow_plant
from servogen.plants.errors import PlantError
from servogen.plants.motion import to_motion_states
from servogen.plants.servo import servo
from servogen.plants.settings import (
    PythonSettings,
    ServoSettings,
    StateSpaceSettings,
    TransferFunctionSettings,
)
from servogen.plants.statespace import StateSpace, discretise
from servogen.plants.transfer import transfer_function

MODERATE = settings(max_examples=40, deadline=None, derandomize=True)
FREQUENCIES = (0.1, 1.0, 7.0, 30.0)


def scrambled(plant: StateSpace, seed: int) -> StateSpace:
    """The same system in random coordinates of moderate condition, time in units of its poles."""
    generator = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(generator.normal(size=(plant.order, plant.order)))
    rate = np.max(np.abs(plant.poles))
    turn = turn * generator.uniform(0.5, 2.0, plant.order) / rate ** np.arange(plant.order)
    back = np.linalg.inv(turn)
    return StateSpace(turn @ plant.a @ back, turn @ plant.b, plant.c @ back)


def unit_gain(poles: list[float], zeros: list[float]) -> tuple[np.ndarray, np.ndarray]:
    denominator = np.poly(-np.array(poles))
    numerator = np.atleast_1d(np.poly(-np.array(zeros)))
    return numerator * denominator[-1] / numerator[-1], denominator


pole_lists = st.lists(st.floats(1.0, 20.0), min_size=3, max_size=5)


@MODERATE
@given(poles=pole_lists, zero=st.floats(2.0, 50.0), seed=st.integers(0, 2**32 - 1))
def test_any_coordinates_give_the_same_motion_states(
    poles: list[float], zero: float, seed: int
) -> None:
    """Transfer function -> motion states -> scrambled -> back: the same matrices and response."""
    numerator, denominator = unit_gain(poles, [zero] if len(poles) > 3 else [])
    plant = transfer_function(numerator, denominator)
    again = to_motion_states(scrambled(plant, seed))
    np.testing.assert_allclose(again.a, plant.a, rtol=1e-6, atol=1e-6 * np.max(np.abs(plant.a)))
    for w in FREQUENCIES:
        wanted = np.polyval(numerator, 1j * w) / np.polyval(denominator, 1j * w)
        assert abs(plant.response(w) - wanted) < 1e-9
        assert abs(again.response(w) - wanted) < 1e-6


@MODERATE
@given(poles=pole_lists, zero=st.floats(2.0, 50.0))
def test_first_states_are_position_velocity_acceleration(poles: list[float], zero: float) -> None:
    """Rows of the matrices say dp/dt = v, dv/dt = a; any (p, 0, 0, ...) is at rest under p."""
    plant = transfer_function(*unit_gain(poles, [zero] if len(poles) > 3 else []))
    n = plant.order
    np.testing.assert_array_equal(plant.c, np.eye(n)[0])
    np.testing.assert_array_equal(plant.a[:2], np.eye(n, k=1)[:2])
    np.testing.assert_array_equal(plant.b[:2], 0.0)
    size = np.max(np.abs(plant.a))
    np.testing.assert_allclose(plant.a[:, 0] + plant.b, 0.0, atol=1e-12 * size)


def test_velocity_state_is_the_derivative_of_the_position() -> None:
    """Against a fine simulation with fourth-order plant and a zero: central differences."""
    plant = transfer_function(*unit_gain([10.0, 12.0, 30.0, 40.0], [25.0]))
    step = discretise(plant, 1e-4)
    states = [np.zeros(4)]
    for _ in range(2000):
        states.append(step.a @ states[-1] + step.b * 0.1)
    x = np.array(states)
    velocity = (x[2:, 0] - x[:-2, 0]) / 2e-4
    acceleration = (x[2:, 1] - x[:-2, 1]) / 2e-4
    np.testing.assert_allclose(x[1:-1, 1], velocity, atol=1e-4 * np.max(np.abs(velocity)))
    np.testing.assert_allclose(x[1:-1, 2], acceleration, atol=1e-3 * np.max(np.abs(acceleration)))


def test_servo_equals_its_transfer_function() -> None:
    for w in (45.0, 2250.0):
        ours = servo(w, 0.7)
        other = transfer_function([w**3], [1.0, 2.4 * w, 2.4 * w**2, w**3])
        np.testing.assert_allclose(other.a, ours.a, rtol=1e-13)
        np.testing.assert_allclose(other.b, ours.b, rtol=1e-13)


def test_leading_zeros_and_scale_of_coefficients_do_not_matter() -> None:
    plain = transfer_function([24.0], [1.0, 9.0, 26.0, 24.0])
    other = transfer_function([0.0, 0.0, 48.0], [0.0, 2.0, 18.0, 52.0, 48.0])
    np.testing.assert_array_equal(plain.a, other.a)
    np.testing.assert_array_equal(plain.b, other.b)


def test_position_and_command_that_share_nothing() -> None:
    hidden = StateSpace(np.diag([-1.0, -2.0, -3.0]), np.ones(3), np.array([1.0, 1.0, 0.0]))
    with pytest.raises(PlantError, match="every state"):
        to_motion_states(hidden)
    with pytest.raises(PlantError, match="every state"):
        to_motion_states(scrambled(hidden, 4))
    deaf = StateSpace(servo(5.0, 0.7).a, np.zeros(3), np.eye(3)[0])
    with pytest.raises(PlantError, match="command moves"):
        to_motion_states(deaf)


@pytest.mark.parametrize(("markov", "degree"), [([1.0, 0, 0], 1), ([0, 1.0, 0], 2)])
def test_command_that_reaches_too_far(markov: list[float], degree: int) -> None:
    plant = StateSpace(servo(5.0, 0.7).a, np.array(markov), np.eye(3)[0])
    with pytest.raises(PlantError) as caught:
        to_motion_states(scrambled(plant, 3))
    assert caught.value.key == "relative_degree"
    assert caught.value.value == degree


@pytest.mark.parametrize(
    ("numerator", "denominator", "key"),
    [
        ([], [1.0, 1, 1, 1], "numerator"),
        ([0.0], [1.0, 1, 1, 1], "numerator"),
        ([1.0], [0.0, 0.0], "denominator"),
        ([1.0], [1.0, 2.0, 1.0], "denominator"),
        ([1.0, 1.0], [1.0, 3.0, 3.0, 1.0], "numerator"),
        ([float("nan")], [1.0, 3.0, 3.0, 1.0], "numerator"),
    ],
)
def test_bad_transfer_functions(numerator: list[float], denominator: list[float], key: str) -> None:
    with pytest.raises(PlantError) as caught:
        transfer_function(numerator, denominator)
    assert caught.value.key == key


def test_order_below_three() -> None:
    with pytest.raises(PlantError, match="order is 2"):
        to_motion_states(StateSpace(-np.eye(2), np.ones(2), np.ones(2)))


@pytest.mark.parametrize("w", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_servo_numbers(w: float) -> None:
    with pytest.raises(PlantError, match="bandwidth_rad_per_s"):
        servo(w, 0.7)
    with pytest.raises(PlantError, match="damping"):
        servo(45.0, w)


def test_every_kind_of_settings_gives_the_same_stage() -> None:
    w, zeta = 45.0, 0.7
    wanted = servo(w, zeta)
    example = Path(__file__).parent / "data_servo_model.py"
    turned = scrambled(wanted, 5)
    kinds = (
        ServoSettings(w, zeta),
        TransferFunctionSettings((w**3,), (1.0, 2.4 * w, 2.4 * w**2, w**3)),
        StateSpaceSettings(
            tuple(tuple(row) for row in turned.a.tolist()),
            tuple(turned.b.tolist()),
            tuple(turned.c.tolist()),
        ),
        PythonSettings(example, "servo", {"w": w, "zeta": zeta}),
    )
    for kind in kinds:
        plant = slow_plant(kind)
        np.testing.assert_allclose(plant.a, wanted.a, rtol=1e-8, atol=1e-3)
        np.testing.assert_array_equal(plant.a[:, 0] + plant.b, 0.0)
    assert fast_plant(ServoSettings(2250.0, 0.7)).b[2] == 2250.0**3


def test_stage_must_be_stable_and_of_unit_gain() -> None:
    with pytest.raises(PlantError, match="unstable") as caught:
        build_stage(TransferFunctionSettings((6.0,), (1.0, -6.0, 11.0, 6.0)))
    assert caught.value.key == "denominator"
    with pytest.raises(PlantError, match=r"dc gain 0\.5"):
        build_stage(TransferFunctionSettings((3.0,), (1.0, 6.0, 11.0, 6.0)))
    with pytest.raises(PlantError, match="unstable"):
        build_stage(TransferFunctionSettings((1.0,), (1.0, 2.0, 1.0, 0.0)))


def test_gain_one_but_for_typed_digits_is_made_one() -> None:
    plant = build_stage(TransferFunctionSettings((6.0000001,), (1.0, 6.0, 11.0, 6.0)))
    assert plant.dc_gain == pytest.approx(1.0, abs=1e-15)
    assert plant.b[2] == 6.0


def test_ragged_matrix() -> None:
    with pytest.raises(PlantError, match="a row of 2 numbers"):
        build_stage(StateSpaceSettings(((1.0, 2.0),) * 3, (1.0,) * 3, (1.0,) * 3))
