"""The corrected recursion (11)-(13) as it stands, dense: what every faster form is held against.

Signs and indices are those of the derivation, not of the print: the law and the preview's end carry
a minus, (12) subtracts, g_j comes from g_{j+1}, and the closed loop (17) is A - B K with the A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.controllers.errors import DesignError
from servogen.plants.statespace import Discrete
from servogen.precision import FloatArray

# scipy's solution satisfies (16) to 1e-12 of itself on models like the paper's; one that is off by
# more than this comes from a pencil whose eigenvalues it could not tell apart.
RICCATI_RESIDUAL = 1e-6


@dataclass(frozen=True)
class Machine:
    """All axes together: a (n, n), b (n, p), c (p, n), block-diagonal."""

    a: FloatArray
    b: FloatArray
    c: FloatArray

    @staticmethod
    def of(axes: Sequence[Discrete]) -> Machine:
        """Axes side by side, each of its own order."""
        return Machine(
            np.asarray(scipy.linalg.block_diag(*(axis.a for axis in axes))),
            np.asarray(scipy.linalg.block_diag(*(axis.b[:, None] for axis in axes))),
            np.asarray(scipy.linalg.block_diag(*(axis.c[None, :] for axis in axes))),
        )


def stationary(axis: Discrete, output_weight: float, control_weight: float) -> FloatArray:
    """(n, n) H_s of (16) of one axis: Q_max is a multiple of I, so every axis has its own.

    Raises:
        DesignError: an axis that is not stabilisable or not detectable.
    """
    # in units of the output's weight and of the input's gain: only their ratio matters, and the
    # solver's tests are absolute
    gain = float(np.max(np.abs(axis.b)))
    if not gain > 0.0:
        raise DesignError("b", 0.0, "an input that moves the axis")
    b, weight = axis.b[:, None] / gain, control_weight / (output_weight * gain**2)
    seen, price = np.outer(axis.c, axis.c), np.array([[weight]])
    try:
        with np.errstate(all="ignore"):
            found = scipy.linalg.solve_discrete_are(axis.a, b, seen, price)
    except (np.linalg.LinAlgError, ValueError):
        raise DesignError("a", None, "a stabilisable and detectable axis") from None
    k = np.linalg.solve(b.T @ found @ b + price, b.T @ found @ axis.a)
    residual = axis.a.T @ found @ (axis.a - b @ k) + seen - found
    if not np.max(np.abs(residual)) <= RICCATI_RESIDUAL * np.max(np.abs(found)):
        raise DesignError("a", None, "an axis whose Riccati equation can be solved accurately")
    if not np.max(np.abs(np.linalg.eigvals(axis.a - b @ k))) < 1.0:
        raise DesignError("a", None, "a stabilisable and detectable axis")
    result: FloatArray = 0.5 * output_weight * (found + found.T)
    return result


def end_weight(
    axes: Sequence[Discrete], weights: ContourWeights, terminal: Terminal, last: FloatArray
) -> FloatArray:
    """(n, n) H at the end of the preview; ``last`` (p, p) is Q of its last point."""
    if terminal is Terminal.OUTPUT:
        c = Machine.of(axes).c
        result: FloatArray = c.T @ last @ c
        return result
    blocks = (stationary(axis, weights.largest, weights.control) for axis in axes)
    return np.asarray(scipy.linalg.block_diag(*blocks))


def feedback(machine: Machine, h: FloatArray, control_weight: float) -> FloatArray:
    """(p, n) [B'HB + R]^-1 B'HA."""
    price = machine.b.T @ h @ machine.b + control_weight * np.eye(machine.b.shape[1])
    return np.linalg.solve(price, machine.b.T @ h @ machine.a)


def step_back(machine: Machine, h: FloatArray, q: FloatArray, control_weight: float) -> FloatArray:
    """(n, n) H_j from H_{j+1} and Q_j (12)."""
    k = feedback(machine, h, control_weight)
    before = machine.a.T @ h @ (machine.a - machine.b @ k) + machine.c.T @ q @ machine.c
    result: FloatArray = 0.5 * (before + before.T)
    return result


def first_input(
    machine: Machine,
    control_weight: float,
    q: FloatArray,
    end: tuple[FloatArray, FloatArray],
    state: FloatArray,
    wanted: FloatArray,
) -> FloatArray:
    """(p,) u(k) of (11).

    Args:
        q: (N, p, p) Q_1, ..., Q_N; that of the last point is in ``end`` already.
        end: H_N (n, n) and g_N (n,): -C'Q_N y_d(N), or -H_s x_d(N).
        state: (n,). wanted: (N, p) y_d(k+1), ..., y_d(k+N).
    """
    h, g = end
    for j in range(len(q) - 1, 0, -1):
        closed = machine.a - machine.b @ feedback(machine, h, control_weight)
        g = closed.T @ g - machine.c.T @ (q[j - 1] @ wanted[j - 1])
        h = step_back(machine, h, q[j - 1], control_weight)
    price = machine.b.T @ h @ machine.b + control_weight * np.eye(machine.b.shape[1])
    return -np.linalg.solve(price, machine.b.T @ (h @ (machine.a @ state) + g))
