"""Auxiliary dynamics: shift registers, Laguerre sequences, none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.sets.auxiliary import AuxiliaryDynamics, laguerre, no_auxiliary, shift_register
from servogen.sets.errors import SetError


def test_shift_register_gives_its_entries_and_then_nothing() -> None:
    register = shift_register(4)
    np.testing.assert_array_equal(register.outputs(6), np.eye(6, 4))
    assert register.settled == 4


@settings(max_examples=25, deadline=None, derandomize=True)
@given(order=st.integers(1, 8), pole=st.floats(0.0, 0.9))
def test_laguerre_sequences_are_orthonormal(order: int, pole: float) -> None:
    """sum v^2 = x'x; each has the z-transform sqrt(1 - a^2) (z^-1 - a)^i / (1 - a z^-1)^(i+1)."""
    sequences = laguerre(order, pole)
    outputs = sequences.outputs(600)
    np.testing.assert_allclose(outputs.T @ outputs, np.eye(order), atol=1e-9)
    impulse = np.zeros(600)
    impulse[0] = 1.0
    wanted = np.sqrt(1.0 - pole**2) * _filtered(impulse, 1.0, 0.0, pole)
    for i in range(order):
        np.testing.assert_allclose(np.abs(outputs[:, i]), np.abs(wanted), atol=1e-9)
        wanted = _filtered(wanted, -pole, 1.0, pole)


def _filtered(u: np.ndarray, now: float, before: float, pole: float) -> np.ndarray:
    """y = (now + before z^-1) / (1 - pole z^-1) u, by hand."""
    y = np.zeros_like(u)
    for k in range(u.size):
        y[k] = now * u[k] + (before * u[k - 1] + pole * y[k - 1] if k else 0.0)
    return y


def test_laguerre_with_pole_zero_is_the_shift_register() -> None:
    np.testing.assert_array_equal(laguerre(5, 0.0).outputs(8), shift_register(5).outputs(8))


def test_weights_that_never_grow() -> None:
    assert shift_register(3).never_grows(np.eye(3))
    assert shift_register(3).never_grows(np.diag([1.0, 2.0, 3.0]))
    assert not shift_register(3).never_grows(np.diag([3.0, 2.0, 1.0]))
    assert not shift_register(3).never_grows(np.zeros((3, 3)))
    assert laguerre(4, 0.7).never_grows(np.eye(4))
    assert not laguerre(4, 0.7).never_grows(np.diag([9.0, 1.0, 1.0, 1.0]))
    assert no_auxiliary().never_grows(np.zeros((0, 0)))


def test_bad_dynamics() -> None:
    with pytest.raises(SetError, match="at least one"):
        shift_register(0)
    with pytest.raises(SetError, match="at least one"):
        laguerre(0, 0.5)
    for pole in (-0.1, 1.0, float("nan")):
        with pytest.raises(SetError, match="pole"):
            laguerre(3, pole)
    with pytest.raises(SetError, match="not stable"):
        AuxiliaryDynamics(np.eye(2), np.ones(2), "integrators")
    with pytest.raises(SetError, match="of shape"):
        AuxiliaryDynamics(np.eye(2), np.ones(3), "of two sizes")
