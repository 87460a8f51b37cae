"""Projection onto a polyhedron, min 1/2 |s|^2 subject to g s <= b, by the dual active-set method.

Goldfarb and Idnani (1983): from the unconstrained optimum, the most violated row is made active,
rows whose multiplier would turn negative are let go. Every strictly convex program takes this form
with s = L'(z - z_unc), H = L L'. The active rows it ends with are linearly independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import FloatArray

# Squared distance of a unit row from the span of the active ones below which it depends on them.
_DEPENDENT = 1e-14


@dataclass(frozen=True)
class Projection:
    """The optimum ``s`` (n,), the active rows in ascending order and their multipliers."""

    s: FloatArray
    active: tuple[int, ...]
    multipliers: FloatArray


def project(g: FloatArray, b: FloatArray, tolerance: float) -> Projection | None:
    """The point of {g s <= b} nearest to the origin; None if the set is empty.

    Args:
        g: (m, n), rows of unit length; b: (m,).
        tolerance: a row counts as kept up to this excess.

    Raises:
        ArithmeticError: it did not end, which rounding alone can cause.
    """
    s = np.zeros(g.shape[1])
    active: list[int] = []
    duals = np.zeros(0)
    for _ in range(20 * (g.shape[0] + 1)):
        excess = g @ s - b
        excess[active] = -np.inf
        entering = int(np.argmax(excess)) if excess.size else -1
        if entering < 0 or excess[entering] <= tolerance:
            order = np.argsort(active)
            return Projection(s, tuple(active[i] for i in order), duals[order])
        gained = 0.0
        while True:
            share, rest = _split(g, active, entering)
            distance = float(rest @ rest)
            full = float("inf")
            if distance > _DEPENDENT:
                full = float(g[entering] @ s - b[entering]) / distance
            falling = np.flatnonzero(share > 1e-12)
            drop, partial = -1, float("inf")
            if falling.size:
                ratios = duals[falling] / share[falling]
                drop, partial = int(falling[np.argmin(ratios)]), float(np.min(ratios))
            step = min(full, partial)
            if step == float("inf"):
                return None
            duals = duals - step * share
            gained += step
            if distance > _DEPENDENT:
                s = s - step * rest
            if full <= partial:
                active.append(entering)
                duals = np.append(np.maximum(duals, 0.0), gained)
                break
            del active[drop]
            duals = np.maximum(np.delete(duals, drop), 0.0)
    raise ArithmeticError("the active-set method did not end: the rows are too badly scaled")


def _split(g: FloatArray, active: list[int], row: int) -> tuple[FloatArray, FloatArray]:
    """Row ``row`` as a combination of the active ones, and what is left of it."""
    if not active:
        return np.zeros(0), g[row].copy()
    share = np.linalg.lstsq(g[active].T, g[row], rcond=None)[0]
    return share, g[row] - share @ g[active]
