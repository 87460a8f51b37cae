"""The coordinates everything above works in: position, velocity, acceleration (and further)."""

from __future__ import annotations

import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.statespace import FloatArray, StateSpace

# Markov parameters below this share of the largest one count as zero: in normalised time they are
# of the size of the gain, and a similarity transform leaves about 1e-13 where zero should be.
RELATIVE_DEGREE_TOLERANCE = 1e-9
# Beyond this the transform to motion states has fewer than four good digits.
LARGEST_CONDITION = 1e12


def observability_form(characteristic: FloatArray, markov: FloatArray) -> StateSpace:
    """The state space whose states are the output and its derivatives.

    Args:
        characteristic: (n,) a_0 .. a_(n-1) of s^n + a_(n-1) s^(n-1) + ... + a_0.
        markov: (n,) c b, c a b, ..., c a^(n-1) b of the system in any coordinates.
    """
    n = characteristic.size
    a = np.eye(n, k=1)
    a[-1] = -characteristic
    return StateSpace(a, markov, np.eye(n)[0])


def to_motion_states(sys: StateSpace) -> StateSpace:
    """The same system with states p, v, a (m, m/s, m/s^2) and further derivatives for order > 3.

    The transform is T = [c; c a; c a^2; ...], taken in time units of the fastest pole so that its
    rows are of one size. Where the relative degree r is less than the order, states from the
    (r+1)th on are the derivatives less the share of the input.

    Raises:
        PlantError: order below three, not observable from the position, or a command that reaches
            velocity or acceleration without delay (c b or c a b not zero).
    """
    n = sys.order
    if n < 3:
        raise PlantError("order", n, "at least 3, to have position, velocity and acceleration")
    rate = float(np.max(np.abs(sys.poles)))
    rate = 2.0 ** round(float(np.log2(rate))) if rate > 0.0 else 1.0
    a, b = sys.a / rate, sys.b / rate
    rows = [sys.c]
    for _ in range(n):
        rows.append(rows[-1] @ a)
    transform = np.array(rows[:n])
    # columns scaled: the user's own units must not decide whether the position shows every state
    columns = np.max(np.abs(transform), axis=0)
    if np.any(columns == 0.0) or np.linalg.cond(transform / columns) > LARGEST_CONDITION:
        raise PlantError("model", None, "a model of which the position shows every state")
    characteristic = -np.linalg.solve(transform.T, rows[n])
    powers = rate ** np.arange(n)
    markov = transform @ b
    check_relative_degree(markov)
    markov[:2] = 0.0
    return observability_form(characteristic * rate**n / powers, markov * rate * powers)


def check_relative_degree(markov: FloatArray) -> None:
    """Refuse a command that reaches velocity or acceleration at once.

    Args:
        markov: (n,) Markov parameters c b, c a b, ... in a time unit near the fastest pole.

    Raises:
        PlantError: relative degree 1 or 2.
    """
    largest = float(np.max(np.abs(markov)))
    if largest == 0.0:
        raise PlantError("model", None, "a model that the command moves")
    for degree in (1, 2):
        if abs(markov[degree - 1]) > RELATIVE_DEGREE_TOLERANCE * largest:
            what = "velocity" if degree == 1 else "acceleration"
            raise PlantError(
                "relative_degree", degree, f"at least 3: the command reaches the {what} at once"
            )
