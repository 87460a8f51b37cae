"""The parameters for which a program has a solution, as a polyhedron in the parameters themselves.

Regions cover the feasible set, which is convex. So each of its facets consists of facets of
regions, and a region's facet is one of its if no feasible parameter lies beyond: one linear program
for each that no other region is seen behind. What is left are the limits of the domain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.cover import bounds_feasible_set
from servogen.explicit.small_lp import greatest
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import FLAT, REDUNDANT, SAME_PLANE
from servogen.plants.statespace import FloatArray, read_only
from servogen.qp.parametric import ParametricQP


@dataclass(frozen=True)
class FeasibleSet:
    """{rows theta <= bounds}: (q, p), (q,), none redundant; no row where every theta is feasible.

    A row is scaled so that its height is a length in ``Canonical``'s coordinates, in which one is a
    bound of the program.
    """

    rows: FloatArray
    bounds: FloatArray


def always_feasible(problem: ParametricQP) -> bool:
    """Whether it shows without a solution that every theta is: bounds on single variables alone."""
    return problem.rows.shape[0] == 0 and problem.domain_bounds.size == 0


def feasible_set(solution: ExplicitSolution) -> FeasibleSet:
    """The feasible parameters of a solved program within its domain."""
    program, image = solution.program, solution.image
    rows, bounds = _outer_facets(solution)
    rows = np.vstack([rows, program.domain_rows])
    bounds = np.concatenate([bounds, program.domain_bounds])
    kept = list(range(bounds.size))
    for i in range(bounds.size):
        others = [j for j in kept if j != i]
        if greatest(rows[others], bounds[others], rows[i]) <= bounds[i] + REDUNDANT:
            kept = others
    rows, bounds = rows[kept], bounds[kept]
    return FeasibleSet(read_only(rows @ image.matrix), read_only(bounds - rows @ image.offset))


def _outer_facets(solution: ExplicitSolution) -> tuple[FloatArray, FloatArray]:
    """Distinct facets of regions beyond which nothing is feasible."""
    size = solution.image.size
    centres = np.array([region.centre for region in solution.regions])
    found = np.zeros((0, size + 1))
    for region in solution.regions:
        behind = np.any(centres @ region.h.T > region.k + FLAT, axis=0)
        for i in np.flatnonzero(~behind):
            plane = np.append(region.h[i], region.k[i])
            scale = 1.0 + abs(float(region.k[i]))
            if np.any(np.max(np.abs(found - plane), axis=1) <= SAME_PLANE * scale):
                continue
            if bounds_feasible_set(solution.program, region.h[i], float(region.k[i])):
                found = np.vstack([found, plane])
    return found[:, :-1], found[:, -1]
