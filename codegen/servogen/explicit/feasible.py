"""The parameters for which a program has a solution, as a polyhedron in the parameters themselves.

Regions cover the feasible set, which is convex. So each of its facets consists of facets of
regions, and a region's facet is one of its if no feasible parameter lies beyond: one linear program
for each that no other region is seen behind. What is left are the limits of the domain. These are
taken as they were stated: of what moves theta and not eta, the image of the domain knows nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.cover import bounds_feasible_set
from servogen.explicit.image import Image
from servogen.explicit.small_lp import greatest
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import FLAT, RANK, REDUNDANT, SAME_PLANE
from servogen.plants.statespace import FloatArray, read_only
from servogen.qp.parametric import ParametricQP


@dataclass(frozen=True)
class FeasibleSet:
    """{rows theta <= bounds}: (q, p), (q,), none redundant; no row where every theta is feasible.

    A row is scaled so that its height is a length in ``Canonical``'s coordinates, in which one is a
    bound of the program; the domain's rows, where these coordinates are fewer than the parameters,
    so that it is a share of what the domain allows each parameter.
    """

    rows: FloatArray
    bounds: FloatArray


def always_feasible(problem: ParametricQP) -> bool:
    """Whether it shows without a solution that every theta is: bounds on single variables alone."""
    return problem.rows.shape[0] == 0 and problem.domain_bounds.size == 0


def feasible_set(solution: ExplicitSolution) -> FeasibleSet:
    """The feasible parameters of a solved program within its domain."""
    problem, program, image = solution.problem, solution.program, solution.image
    rows, bounds = _outer_facets(solution)
    if image.size == problem.parameters:
        rows = np.vstack([rows, program.domain_rows])
        bounds = np.concatenate([bounds, program.domain_bounds])
        kept = _needed(rows, bounds)
        rows, bounds = _over_theta(rows, image)[kept], (bounds - rows @ image.offset)[kept]
    else:
        rows, bounds = _with_domain(problem, _over_theta(rows, image), bounds - rows @ image.offset)
    return FeasibleSet(read_only(rows), read_only(bounds))


def _over_theta(rows: FloatArray, image: Image) -> FloatArray:
    """Rows over eta as rows over theta. What cancels to rounding is nothing: a parameter that the
    set does not limit would else be limited to 1e20 times its size."""
    over, terms = rows @ image.matrix, np.abs(rows) @ np.abs(image.matrix)
    result: FloatArray = np.where(np.abs(over) > RANK * terms, over, 0.0)
    return result


def _with_domain(
    problem: ParametricQP, rows: FloatArray, bounds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What is needed of rows theta <= bounds and of the domain, whose rows are scaled anew."""
    extent = _extents(problem)
    lengths = np.linalg.norm(rows * extent, axis=1)
    own = np.linalg.norm(problem.domain_rows * extent, axis=1)
    rows = np.vstack([rows, problem.domain_rows / own[:, None]])
    bounds = np.concatenate([bounds, problem.domain_bounds / own])
    lengths = np.concatenate([lengths, np.ones(own.size)])
    kept = _needed(rows * extent / lengths[:, None], bounds / lengths)
    return rows[kept], bounds[kept]


def _extents(problem: ParametricQP) -> FloatArray:
    """(p,) how far a row of the domain lets each parameter go, for its scale; 1 where none does."""
    rows, sizes = np.abs(problem.domain_rows), np.abs(problem.domain_bounds)
    told = sizes > 0.0
    steepest = np.max(rows[told] / sizes[told, None], axis=0, initial=0.0)
    extents: FloatArray = 1.0 / np.where(steepest > 0.0, steepest, 1.0)
    return extents


def _needed(rows: FloatArray, bounds: FloatArray) -> list[int]:
    """Rows, of about unit length, that are not redundant."""
    kept = list(range(bounds.size))
    for i in range(bounds.size):
        others = [j for j in kept if j != i]
        if greatest(rows[others], bounds[others], rows[i]) <= bounds[i] + REDUNDANT:
            kept = others
    return kept


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
