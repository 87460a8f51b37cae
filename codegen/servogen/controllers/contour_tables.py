"""The law (11)-(13) without its recursion: constant tables of each axis, and sliding references.

With Q_j = (alpha + beta) I - beta r_j r_j', completing a square gives the error across the contour
as the error to a reference that may slide along its tangent, at a price:

    e'Q_j e = min over s of (alpha + beta) |e - s r_j|^2 + (alpha + beta) (alpha / beta) s^2

For given slides every point carries the same weight in all directions: the axes fall apart, and
each of them is a time-invariant least-squares tracker whose first input, and whose errors e* that
the optimal inputs leave, are constant linear maps of its state and of its references. The N slides
alone couple the axes; with q = alpha + beta and P_a the constant map from a shift of the
references of axis a to the errors it leaves,

    [alpha I + beta sum_a D_a P_a D_a] s = -beta sum_a D_a e*_a,    D_a = diag(r_a1, ..., r_aN)

which is positive definite, with a condition of at most 1 + beta / alpha: what float32 needs. The
whole of it is exact; nothing of (12) is left but one factorisation of order N.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from servogen.controllers.contour_axis import AxisModel
from servogen.controllers.contour_estimate import wanted_state
from servogen.controllers.contour_recursion import stationary
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.controllers.errors import DesignError
from servogen.plants.statespace import FloatArray, read_only


@dataclass(frozen=True)
class AxisTables:
    """Of one axis, N points ahead of which S may slide, n states.

    The maps take (d_1, ..., d_N, y, xi): references less the position, the position (its
    coefficients are zero for an exact integrator) and the other states.

    Attributes:
        first: (N + n,) to the first input.
        error: (S, N + n) to -beta / q times the errors e*.
        slide: (S,) first input per shift of a reference.
        stiffness: (S, S) beta / q P_a, symmetric, eigenvalues between zero and beta / q.
        rounding: what the factorisation may have left wrong of P_a, whose norm is at most one.
    """

    first: FloatArray
    error: FloatArray
    slide: FloatArray
    stiffness: FloatArray
    rounding: float


def slides(terminal: Terminal, preview: int) -> int:
    """S: with H_s the last point is a state, which does not slide."""
    return preview if terminal is Terminal.OUTPUT else preview - 1


def axis_tables(
    model: AxisModel, weights: ContourWeights, terminal: Terminal, preview: int
) -> AxisTables:
    """From the least squares of one axis under Q_max, by an orthogonal factorisation.

    Raises:
        DesignError: a preview below one, or below two with H_s, which takes the velocity at the
            preview's end from its last two points.
    """
    least = 1 if terminal is Terminal.OUTPUT else 2
    if preview < least:
        raise DesignError(
            "preview", preview, f'at least {least} with terminal = "{terminal.value}"'
        )
    count = slides(terminal, preview)
    free, driven = _responses(model, preview)
    ahead = np.hstack([np.eye(preview)[:count], -free[1 : count + 1, 0]])
    root = np.sqrt(weights.largest)
    rows, wanted = [root * driven[1 : count + 1, 0]], [root * ahead]
    if terminal is Terminal.STATIONARY:
        factor, target = _end(model, weights, preview)
        rows.append(factor @ driven[preview])
        wanted.append(factor @ (target - np.pad(free[preview], ((0, 0), (preview, 0)))))
    rows.append(np.sqrt(weights.control) * np.eye(preview))
    wanted.append(np.zeros((preview, preview + model.order)))
    shift = np.zeros((sum(len(part) for part in rows), count))
    shift[:count] = root * np.eye(count)
    matrix = np.vstack(rows)
    solved = _least_squares(matrix, np.hstack([np.vstack(wanted), shift]))
    inputs, shifted = solved[:, :-count], solved[:, -count:]
    reached = driven[1 : count + 1, 0]
    share = weights.contour / weights.largest
    left = np.eye(count) - reached @ shifted
    return AxisTables(
        read_only(inputs[0]),
        read_only(-share * (ahead - reached @ inputs)),
        read_only(shifted[0]),
        read_only(share * 0.5 * (left + left.T)),
        float(np.finfo(np.float64).eps * np.linalg.cond(matrix)),
    )


def _responses(model: AxisModel, preview: int) -> tuple[FloatArray, FloatArray]:
    """(N+1, n, n) states after j samples per (y, xi), less the position itself, without input;
    (N+1, n, N) per input."""
    n = model.order
    free, driven = np.zeros((preview + 1, n, n)), np.zeros((preview + 1, n, preview))
    free[0, :, 1:] = np.eye(n)[:, 1:]
    for j in range(preview):
        free[j + 1] = model.a @ free[j]
        free[j + 1, :, 0] += model.drift
        driven[j + 1] = model.a @ driven[j]
        driven[j + 1, :, j] = model.b
    return free, driven


def _end(model: AxisModel, weights: ContourWeights, preview: int) -> tuple[FloatArray, FloatArray]:
    """A factor F of H_s = F'F, and x_d(N) (n, N + n) less the position."""
    h = stationary(model.plant, weights.largest, weights.control)
    values, vectors = np.linalg.eigh(model.to_state.T @ h @ model.to_state)
    factor = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    known = wanted_state(model.plant)
    position = model.from_state @ known.on_position
    advance = model.from_state @ known.on_advance
    target = np.zeros((model.order, preview + model.order))
    target[:, preview - 1] = position + advance
    target[:, preview - 2] = -advance
    target[:, preview] = position - np.eye(model.order)[0]
    return factor, target


def _least_squares(rows: FloatArray, wanted: FloatArray) -> FloatArray:
    """Columns of unknowns for columns of what is wanted; rho > 0 makes the rank full."""
    q, r = np.linalg.qr(rows)
    return np.asarray(scipy.linalg.solve_triangular(r, q.T @ wanted))
