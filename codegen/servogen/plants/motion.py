"""The coordinates everything above works in: position, velocity, acceleration (and further)."""

from __future__ import annotations

import numpy as np

from servogen.plants.errors import PlantError
from servogen.plants.statespace import FloatArray, StateSpace

# Markov parameters below this share of the largest one count as zero; in normalised time they are
# all of the size of the gain.
RELATIVE_DEGREE_TOLERANCE = 1e-9
# So do those that are rounding: this share of the sum of the absolute products they are made of,
# which is large where the user's coordinates mix metres with 1e10 m/s^3.
ROUNDING = 1e-13
# Beyond this the transform to motion states has fewer than four good digits.
LARGEST_CONDITION = 1e12


def motion_form(characteristic: FloatArray, markov: FloatArray) -> StateSpace:
    """The state space with states p, v, a and, for order > 3, further ones that vanish at rest.

    The observability form has the output and its derivatives as states, each less the share of
    the command that reaches it at once. At rest the further ones would stand at a multiple of the
    command; the same multiple of the position is taken off, so that (p, 0, 0, 0, ...) is rest
    whatever p, and a move of the whole axis is a move of the first state alone.

    Args:
        characteristic: (n,) a_0 .. a_(n-1) of s^n + a_(n-1) s^(n-1) + ... + a_0.
        markov: (n,) c b, c a b, ..., c a^(n-1) b of the system in any coordinates; the first two
            are zero.
    """
    n = characteristic.size
    a = np.eye(n, k=1)
    a[-1] = -characteristic
    b = markov.copy()
    gain_times_a0 = markov[-1] + characteristic[1:] @ markov[:-1]
    if n > 3 and characteristic[0] != 0.0 and gain_times_a0 != 0.0:
        share = np.zeros(n)  # further states at rest, per metre of position
        share[3:] = -markov[2:-1] * characteristic[0] / gain_times_a0
        a[:, 0] += a[:, 3:] @ share[3:]
        a -= np.outer(share, a[0])  # they lose share * dp/dt
        b -= share * b[0]
    return StateSpace(a, b, np.eye(n)[0])


def to_motion_states(sys: StateSpace) -> StateSpace:
    """The same system with states p, v, a (m, m/s, m/s^2) and, for order > 3, further derivatives.

    The transform is T = [c; c a; c a^2; ...], taken in time units of the fastest pole so that its
    rows are of one size; ``motion_form`` says what the further states are.

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
    check_relative_degree(markov, _rounding(a, b, sys.c))
    markov[:2] = 0.0
    return motion_form(characteristic * rate**n / powers, markov * rate * powers)


def _rounding(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """(2,) what c b and c a b can be by rounding alone."""
    once = float(np.abs(c) @ np.abs(b))
    twice = float(np.abs(c) @ np.abs(a) @ np.abs(b))
    size = ROUNDING * a.shape[0]
    return np.array([size * once, size * twice])


def check_relative_degree(markov: FloatArray, rounding: FloatArray | None = None) -> None:
    """Refuse a command that reaches velocity or acceleration at once.

    Args:
        markov: (n,) Markov parameters c b, c a b, ... in a time unit near the fastest pole.
        rounding: (2,) sizes below which c b and c a b say nothing; none by default.

    Raises:
        PlantError: relative degree 1 or 2.
    """
    largest = float(np.max(np.abs(markov)))
    if largest == 0.0:
        raise PlantError("model", None, "a model that the command moves")
    floor = np.zeros(2) if rounding is None else rounding
    for degree in (1, 2):
        if abs(markov[degree - 1]) > RELATIVE_DEGREE_TOLERANCE * largest + floor[degree - 1]:
            what = "velocity" if degree == 1 else "acceleration"
            raise PlantError(
                "relative_degree", degree, f"at least 3: the command reaches the {what} at once"
            )
