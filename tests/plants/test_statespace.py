"""Exact hold, read-only arrays, and the properties of a state space."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import cont2discrete

from servogen.plants.errors import PlantError
from servogen.plants.servo import servo
from servogen.plants.statespace import StateSpace, discretise

MODERATE = settings(max_examples=40, deadline=None, derandomize=True)


def stable_plant(seed: int, n: int) -> StateSpace:
    generator = np.random.default_rng(seed)
    a = generator.normal(size=(n, n))
    a -= (np.max(np.linalg.eigvals(a).real) + 0.5) * np.eye(n)
    return StateSpace(a, generator.normal(size=n), generator.normal(size=n))


@MODERATE
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), time=st.floats(1e-3, 2.0))
def test_hold_equals_scipy(seed: int, n: int, time: float) -> None:
    plant = stable_plant(seed, n)
    ours = discretise(plant, time)
    b, c, d = plant.b[:, None], plant.c[None, :], np.zeros((1, 1))
    a_d, b_d, *_ = cont2discrete((plant.a, b, c, d), time, method="zoh")
    np.testing.assert_allclose(ours.a, a_d, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(ours.b, b_d[:, 0], rtol=1e-10, atol=1e-12)


def long_series(plant: StateSpace, time: float) -> list[list[Decimal]]:
    """exp([[a, b], [0, 0]] time), its power series summed in 150-digit arithmetic."""
    n = plant.order
    zero, h = Decimal(0), Decimal(time)
    matrix = [[Decimal(float(plant.a[i, j])) * h for j in range(n)] for i in range(n)]
    for i in range(n):
        matrix[i].append(Decimal(float(plant.b[i])) * h)
    matrix.append([zero] * (n + 1))
    total = [[Decimal(int(i == j)) for j in range(n + 1)] for i in range(n + 1)]
    term = total
    for power in range(1, 400):
        term = [
            [sum((row[k] * matrix[k][j] for k in range(n + 1)), zero) / power for j in range(n + 1)]
            for row in term
        ]
        total = [
            [x + y for x, y in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)
        ]
    return total


@pytest.mark.parametrize(("w", "time"), [(45.0, 0.03), (2250.0, 2e-4), (2250.0, 0.03)])
def test_hold_against_a_long_series(w: float, time: float) -> None:
    """Units seven powers of ten apart cost no digits.

    Each entry is compared in units of its row and column (metres, metres times w, ...).
    """
    plant = servo(w, 0.7)
    with localcontext(prec=150):
        exact = long_series(plant, time)
    ours = discretise(plant, time)
    units = (1.0, w, w**2, 1.0)
    for i in range(3):
        for j in range(4):
            got = ours.a[i, j] if j < 3 else ours.b[i]
            error = abs(float(exact[i][j] - Decimal(float(got)))) * units[j] / units[i]
            assert error < 2e-15 * max(1.0, w * time)


def test_two_half_steps_make_one() -> None:
    plant = servo(45.0, 0.7)
    half, full = discretise(plant, 0.015), discretise(plant, 0.03)
    np.testing.assert_allclose(half.a @ half.a, full.a, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(half.a @ half.b + half.b, full.b, rtol=1e-12)


def test_integrator_without_motion_is_held_exactly() -> None:
    held = discretise(StateSpace(np.zeros((1, 1)), np.array([2.0]), np.array([1.0])), 0.25)
    assert held.a[0, 0] == 1.0
    assert held.b[0] == pytest.approx(0.5, rel=1e-15)


def test_arrays_cannot_be_written_and_are_copies() -> None:
    a = np.diag([-1.0, -2.0])
    plant = StateSpace(a, np.ones(2), np.ones(2))
    a[0, 0] = 5.0
    assert plant.a[0, 0] == -1.0
    held = discretise(plant, 0.1)
    for array in (plant.a, plant.b, plant.c, held.a, held.b, held.c):
        assert array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_properties_of_the_servo() -> None:
    plant = servo(45.0, 0.7)
    assert plant.is_stable
    assert plant.dc_gain == pytest.approx(1.0, rel=1e-14)
    damped = 45.0 * np.sqrt(1 - 0.49)
    expected = np.sort_complex([-45.0, -31.5 + 1j * damped, -31.5 - 1j * damped])
    np.testing.assert_allclose(plant.poles, expected, rtol=1e-10)
    assert abs(plant.response(plant.bandwidth_3db)) == pytest.approx(np.sqrt(0.5), rel=1e-9)
    assert plant.bandwidth_3db == pytest.approx(33.529794, rel=1e-6)


def test_first_order_bandwidth_is_its_pole() -> None:
    plant = StateSpace(np.array([[-7.0]]), np.array([7.0]), np.array([1.0]))
    assert plant.bandwidth_3db == pytest.approx(7.0, rel=1e-9)


@pytest.mark.parametrize(
    "a", [np.zeros((2, 2)), np.array([[0.0, 1.0], [0.0, 0.0]]), np.diag([-1.0, 1e-9])]
)
def test_on_or_beyond_the_axis_is_not_stable(a: np.ndarray) -> None:
    assert not StateSpace(a, np.ones(2), np.ones(2)).is_stable


def test_double_integrator_turned_by_a_transform_is_not_stable() -> None:
    turn = scipy.linalg.expm(np.array([[0.3, 0.7], [-0.2, 0.1]]))
    a = turn @ np.array([[0.0, 1.0], [0.0, 0.0]]) @ np.linalg.inv(turn)
    assert not StateSpace(a, np.ones(2), np.ones(2)).is_stable


def test_integrator_has_no_dc_gain() -> None:
    assert StateSpace(np.zeros((1, 1)), np.ones(1), np.ones(1)).dc_gain == np.inf


@pytest.mark.parametrize(
    ("a", "b", "c", "key"),
    [
        (np.zeros((2, 3)), np.ones(2), np.ones(2), "a"),
        (np.zeros((0, 0)), np.ones(0), np.ones(0), "a"),
        (np.eye(2), np.ones(3), np.ones(2), "b"),
        (np.eye(2), np.ones(2), np.ones((1, 2)), "c"),
        (np.eye(2) * np.nan, np.ones(2), np.ones(2), "a"),
        (np.eye(2), np.array([1.0, np.inf]), np.ones(2), "b"),
    ],
)
def test_bad_matrices(a: np.ndarray, b: np.ndarray, c: np.ndarray, key: str) -> None:
    with pytest.raises(PlantError) as caught:
        StateSpace(a, b, c)
    assert caught.value.key == key


@pytest.mark.parametrize("time", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_sample_time(time: float) -> None:
    with pytest.raises(PlantError, match="sample_time_s"):
        discretise(servo(45.0, 0.7), time)
