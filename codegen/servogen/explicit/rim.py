"""The rows that tell a feasible parameter, proved both ways: no region, no search is used.

Rows hold for every feasible parameter if a linear program over the program's variables and its
parameters says so of each. The other way round, a polyhedron is the hull of its vertices and its
directions to infinity (Minkowski and Weyl); if the program has a solution at each vertex, and a
direction to go along with each direction, it has one everywhere inside, being convex. Both are one
linear program in the variables for each generator of the cone over the polyhedron.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.cones import cone_of
from servogen.explicit.restated import Restated
from servogen.plants.statespace import FloatArray
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise


@dataclass(frozen=True)
class Rim:
    """What was found of rows theta <= bounds.

    Attributes:
        loose: (rows,) how far each bound is beyond the greatest value that a feasible parameter
            gives its row, negative where it cuts one off; -inf where there is no greatest value.
        generators: vertices, directions and lines of what the rows describe.
        missing: greatest violation that the program's rows cannot be rid of at one of these, rows of
            unit length, generators with their homogeneous coordinate too; inf without a generator.
        unseen: see ``Restated.seen``.
    """

    loose: FloatArray
    generators: int
    missing: float
    unseen: float


def prove_rim(own: Restated, rows: FloatArray, bounds: FloatArray) -> Rim:
    """Whether {rows theta <= bounds} is the set of the program's feasible parameters.

    Args:
        rows: (q, p); bounds: (q,). Their lengths are those of eta's units.
    """
    over, unseen = own.row_over_eta(rows, bounds)
    a, b, c, unseen_rows = own.feasible_rows()
    n, limits = a.shape[1], own.domain_bounds
    wide = np.zeros((limits.size, n))
    both = np.vstack([np.hstack([a, -c]), np.hstack([wide, own.domain_rows])])
    loose = np.array([
        -_top(both, np.append(b, limits), np.concatenate([np.zeros(n), row])) - constant
        for row, constant in zip(over.slope, over.offset, strict=True)
    ])  # fmt: skip
    lengths = np.linalg.norm(over.slope, axis=1)
    cone = cone_of(over.slope / lengths[:, None], -over.offset / lengths)
    directions = np.vstack([cone.rays, cone.lines, -cone.lines])
    missing = -np.inf
    for direction in directions:
        eta, t = direction[:-1], float(direction[-1])
        missing = max(missing, _missing(a, b * t + c @ eta))
        if limits.size:
            missing = max(missing, float(np.max(own.domain_rows @ eta - limits * t)))
    if not len(directions):
        missing = np.inf  # no point at all: nothing is told feasible
    return Rim(loose, len(directions), missing, max(unseen, unseen_rows))


def _top(rows: FloatArray, bounds: FloatArray, objective: FloatArray) -> float:
    try:
        return maximise(rows, bounds, objective).value
    except SetError:
        return float("-inf")


def _missing(a: FloatArray, bounds: FloatArray) -> float:
    """The least s such that a y <= bounds + s has a solution, not below zero."""
    if not bounds.size or np.min(bounds) >= 0.0:
        return 0.0
    rows = np.vstack([np.column_stack([a, -np.ones(len(a))]), np.append(np.zeros(a.shape[1]), -1.0)])
    objective = np.append(np.zeros(a.shape[1]), -1.0)
    return -_top(rows, np.append(bounds, 0.0), objective)
