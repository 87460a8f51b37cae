"""The slides of ``contour_tables``: one symmetric positive definite system of order S, in the order
of the C."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.precision import FloatArray


def solve_slides(
    stiffness: Sequence[FloatArray],
    along: FloatArray,
    price: FloatArray,
    errors: Sequence[FloatArray],
    least_pivot: np.floating,
    stiffest: np.floating,
    farthest: np.floating,
) -> FloatArray:
    """(S,) s of [price + sum_a T_a P_a T_a] s = sum_a T_a e_a with T_a = diag(along[:, a]).

    L D L' by columns; a pivot is never below the least price in exact arithmetic, so the bound by
    ``least_pivot`` changes none and there is no division by zero to be had. Nor is anything left of
    the matrix, or of the solution on its way, beyond the other two bounds, see ``slide_bounds``.

    Args:
        stiffness, errors: of each axis, (S, S) and (S,). along: (S, p). price: (S,).
    """

    def near(x: np.floating) -> np.floating:
        return min(max(x, -farthest), farthest)

    count = price.size
    matrix, s = _system(stiffness, along, errors)
    matrix[np.diag_indices(count)] += price
    inverse = np.empty_like(price)
    for k in range(count):
        inverse[k] = price.dtype.type(1.0) / max(matrix[k, k], least_pivot)
        column = np.minimum(np.maximum(matrix[k + 1 :, k], -stiffest), stiffest)
        factor = column * inverse[k]
        matrix[k + 1 :, k + 1 :] -= factor[:, None] * column[None, :]
        matrix[k + 1 :, k] = factor
        s[k] = near(s[k])
        s[k + 1 :] -= factor * s[k]
    s *= inverse
    for k in range(count - 1, -1, -1):
        s[k] = near(s[k])
        s[:k] -= matrix[k, :k] * s[k]
    return s


def _system(
    stiffness: Sequence[FloatArray], along: FloatArray, errors: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Only the lower triangle of the matrix is meant: the upper one differs by roundings."""
    matrix: FloatArray = (stiffness[0] * along[:, 0][:, None]) * along[:, 0][None, :]
    right: FloatArray = along[:, 0] * errors[0]
    for axis in range(1, along.shape[1]):
        t = along[:, axis]
        matrix = matrix + (stiffness[axis] * t[:, None]) * t[None, :]
        right = right + t * errors[axis]
    return matrix, right
