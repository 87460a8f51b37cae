"""The rows that tell a feasible parameter, proved both ways: no region, no search is used.

The greatest value that a feasible parameter gives a row is one linear program in the program's
variables and parameters: the row's bound has to be that. The other way round, a polyhedron is the
hull of its vertices and its directions to infinity (Minkowski and Weyl); if the program has a
solution at each vertex, and a direction to go along with each direction, it has one everywhere
inside, being convex. That is one small linear program for each generator of the cone over it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.cones import cone_of
from servogen.explicit.image import Image, canonical
from servogen.explicit.restated import Restated, restate
from servogen.explicit.small_lp import greatest_many
from servogen.explicit.tolerances import END_SHARE
from servogen.plants.statespace import FloatArray
from servogen.qp.parametric import ParametricQP
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise


@dataclass(frozen=True)
class Rim:
    """What was found of rows of parameters.

    Attributes:
        tops: (rows,) greatest rows theta over the feasible parameters of the domain; inf where
            there is none, -inf where no parameter is feasible.
        generators: vertices, directions and lines (both ways) of {rows theta <= tops}.
        missing: greatest violation that the program's rows cannot be rid of at one of these, unit
            rows, generators of unit length with their homogeneous coordinate; inf without any.
        unseen: see ``Restated.seen``.
        room: how far off ``tops`` may be, where the program's bounds are so large that a vertex is
            found no better (``END_SHARE``).
    """

    tops: FloatArray
    generators: int
    missing: float
    unseen: float
    room: float = 0.0


def prove_rim(problem: ParametricQP, rows: FloatArray) -> Rim:
    """Whether {rows theta <= tops} is the set of feasible parameters; ``rows`` (q, p)."""
    own = in_own_coordinates(problem)
    over, unseen = own.seen(rows / own.columns, np.zeros(len(rows)))
    a, b, c, unseen_rows = own.feasible_rows()
    wide = np.zeros((own.domain_bounds.size, a.shape[1]))
    both = np.vstack([np.hstack([a, -c]), np.hstack([wide, own.domain_rows])])
    limits = np.append(b, own.domain_bounds)
    objectives = np.hstack([np.zeros((len(rows), a.shape[1])), over.slope])
    heights = np.array([_top(both, limits, objective) for objective in objectives])
    tops = heights + over.offset
    unseen = max(unseen, unseen_rows)
    if not np.all(np.isfinite(heights)):
        return Rim(tops, 0, np.inf, unseen)
    lengths = np.linalg.norm(over.slope, axis=1)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    cone = cone_of(over.slope / lengths[:, None], heights / lengths)
    found = np.vstack([cone.rays, cone.lines, -cone.lines])
    if not np.any(found[:, -1] > 0.0):
        return Rim(tops, len(found), np.inf, unseen)  # directions alone: no parameter is in it
    bounds = found @ np.column_stack([c, b]).T
    missing = _missing(a, bounds)
    beyond = found @ np.column_stack([own.domain_rows, -own.domain_bounds]).T
    missing = max(missing, float(np.max(beyond, initial=0.0)))
    room = END_SHARE * float(np.max(np.abs(limits), initial=0.0))
    return Rim(tops, len(found), missing, unseen, room)


def in_own_coordinates(problem: ParametricQP) -> Restated:
    """The program over coordinates in which its domain can be said exactly: those of its regions,
    or all its parameters, as shares of what the domain allows each."""
    program = canonical(problem)
    rows, bounds = problem.domain_rows, problem.domain_bounds
    if not bounds.size or program.image.size == problem.parameters:
        return restate(problem, program.image, program.domain_rows, program.domain_bounds)
    sizes = np.where(np.abs(bounds) > 0.0, np.abs(bounds), 1.0)
    steepest = np.max(np.abs(rows) / sizes[:, None], axis=0)
    steepest = np.where(steepest > 0.0, steepest, 1.0)
    over = rows / steepest
    lengths = np.linalg.norm(over, axis=1)
    image = Image(np.diag(steepest), np.zeros(problem.parameters))
    return restate(problem, image, over / lengths[:, None], bounds / lengths)


def _top(rows: FloatArray, bounds: FloatArray, objective: FloatArray) -> float:
    try:
        return maximise(rows, bounds, objective).value
    except SetError:
        return float("-inf")


def _missing(a: FloatArray, bounds: FloatArray) -> float:
    """The greatest, over (N, m) bounds, of the least s >= 0 such that a y <= bounds + s has a y."""
    asked = bounds[np.min(bounds, axis=1, initial=0.0) < 0.0]
    if not len(asked):
        return 0.0
    least = np.append(np.zeros(a.shape[1]), -1.0)
    rows = np.vstack([np.column_stack([a, -np.ones(len(a))]), least])
    limits = np.column_stack([asked, np.zeros(len(asked))])
    tops = greatest_many(rows, limits, np.tile(least, (len(asked), 1)))
    tops[np.isposinf(tops)] = -np.inf  # no answer: nothing is shown
    return float(np.max(-tops))
