"""Linear programs of a few variables by a dual simplex method, checked, with HiGHS behind it.

A region of three parameters asks for hundreds of programs of three or four variables. Calling
HiGHS costs two milliseconds each, nearly all of it set-up; the method here costs a tenth. Each
vertex it returns passed a test of optimality (feasible, multipliers not negative, stationary) on a
basis solved afresh; what fails the test goes to ``servogen.sets.polyhedron``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.tolerances import LP_RESIDUAL
from servogen.plants.statespace import FloatArray
from servogen.sets.polyhedron import maximise

# Walls |x_i| <= wall that give the method its first vertex; they are not part of the program. A
# vertex held by a wall is no answer: the next wall is tried, then HiGHS.
_WALLS = (1e2, 1e5)
_MAX_PIVOTS = 200


@dataclass(frozen=True)
class Vertex:
    """``point`` (n,), the rows that hold it and whether one of the walls is among those."""

    point: FloatArray
    value: float
    walled: bool


def greatest(h: FloatArray, k: FloatArray, objective: FloatArray) -> float:
    """Greatest ``objective`` . x over {h x <= k}: inf if unbounded, -inf if the set is empty.

    Args:
        h: (rows, n), rows of about unit size; k: (rows,); objective: (n,).
    """
    for wall in _WALLS:
        found = _simplex(h, k, objective, wall)
        if found is not None and not found.walled:
            return found.value
    try:
        return maximise(h, k, objective).value
    except ValueError:
        return float("-inf")


@dataclass(frozen=True)
class Ball:
    """``centre`` (n,) and ``radius`` of a ball inside; negative if none, not above the cap."""

    centre: FloatArray
    radius: float


def inner_ball(h: FloatArray, k: FloatArray, cap: float = 1.0) -> Ball:
    """The largest ball of radius at most ``cap`` in {h x <= k}, rows of any length.

    Where the set leaves a choice, the centre lies near the origin rather than far from it. A
    negative radius is by how far the rows must be loosened for the set to have a point.
    """
    n = h.shape[1]
    rows = np.zeros((h.shape[0] + 1, n + 1))
    rows[:-1, :n], rows[:-1, n], rows[-1, n] = h, np.sqrt(np.sum(h * h, axis=1)), 1.0
    bounds, objective = np.append(k, cap), np.append(np.zeros(n), 1.0)
    for wall in _WALLS:
        found = _simplex(rows, bounds, objective, wall)
        # a ball of good size is inside the set; a small one may be the walls' doing
        if found is not None and (not found.walled or found.value > 1e-3 * cap):
            return Ball(found.point[:n], found.value)
    best = maximise(rows, bounds, objective)
    assert best.point is not None  # the cap bounds it and a negative radius is always feasible
    return Ball(best.point[:n], best.value)


def _simplex(h: FloatArray, k: FloatArray, objective: FloatArray, wall: float) -> Vertex | None:
    """Dual simplex from the walls' corner; None if it does not settle within its tolerances."""
    n = objective.size
    signs = np.where(objective >= 0.0, 1.0, -1.0)
    basis = list(range(-n, 0))  # negative: a wall
    inverse = np.diag(signs)  # of the basic rows
    duals = np.abs(objective)
    held = np.full(n, wall)
    for _ in range(_MAX_PIVOTS):
        point = inverse @ held
        excess = h @ point - k
        worst = int(np.argmax(excess)) if excess.size else 0
        if not excess.size or excess[worst] <= 0.1 * LP_RESIDUAL:
            return _verified(h, k, objective, signs, basis, wall)
        # the entering row in terms of the basic ones; its multiplier rises, theirs must stay >= 0
        share = h[worst] @ inverse
        falling = np.flatnonzero(share > 1e-11)
        if not falling.size:
            return None  # no point within the walls: not ours to say that there is none without
        ratios = duals[falling] / share[falling]
        least = float(np.min(ratios))
        # of equal ratios the largest pivot: the basis stays as well conditioned as it can
        ties = falling[ratios <= least + 1e-14]
        out = int(ties[np.argmax(share[ties])])
        duals -= least * share
        duals[out] = least
        np.maximum(duals, 0.0, out=duals)
        pivot = inverse[:, out] / share[out]
        inverse -= np.outer(pivot, share)
        inverse[:, out] = pivot
        basis[out], held[out] = worst, k[worst]
    return None


def _verified(
    h: FloatArray, k: FloatArray, objective: FloatArray, signs: FloatArray, basis: list[int],
    wall: float,
) -> Vertex | None:  # fmt: skip
    """The vertex of ``basis``, solved afresh, if it is optimal."""
    n = objective.size
    rows, held = np.empty((n, n)), np.empty(n)
    for i, row in enumerate(basis):
        if row < 0:
            rows[i], held[i] = 0.0, wall
            rows[i, row + n] = signs[row + n]
        else:
            rows[i], held[i] = h[row], k[row]
    try:
        point: FloatArray = np.linalg.solve(rows, held).astype(np.float64)
        duals = np.linalg.solve(rows.T, objective)
    except np.linalg.LinAlgError:
        return None
    size = 1.0 + float(np.max(np.abs(duals)))
    if np.min(duals) < -LP_RESIDUAL * size:
        return None
    # one wall beyond the origin is one unit of a bound here; far out, the rows lose those digits
    slack = LP_RESIDUAL * (1.0 + 1e-3 * float(np.max(np.abs(point))))
    if h.size and float(np.max(h @ point - k)) > slack:
        return None
    walled = any(row < 0 and duals[i] > 1e-12 * size for i, row in enumerate(basis))
    return Vertex(point, float(objective @ point), walled)
