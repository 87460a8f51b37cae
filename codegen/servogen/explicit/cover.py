"""What lies across a facet: the steps where adjacency of active sets does not tell.

A facet is cut into the parts that found regions share, by subtracting each region's trace on the
facet's hyperplane, until nothing full-dimensional is left. That is the proof of coverage too: if
every facet is shared or bounds the feasible set, a generic segment from any region to any feasible
point never meets uncovered ground, since the feasible parameters are convex.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from servogen.explicit.errors import ExplicitError
from servogen.explicit.image import Canonical
from servogen.explicit.regions import Region
from servogen.explicit.small_lp import greatest, inner_ball
from servogen.explicit.tolerances import (
    END_SHARE,
    FLAT,
    QP_DEPENDENT,
    QP_VIOLATION,
    SAME_PLANE,
    STEPS_ACROSS,
    TOUCHES,
)
from servogen.plants.statespace import FloatArray
from servogen.qp.errors import NotSolved
from servogen.qp.nearest import nearest
from servogen.qp.tolerances import DualMethodTolerances

ActiveSet = tuple[int, ...]
_TOLERANCES = DualMethodTolerances(dependent=QP_DEPENDENT)


@dataclass(frozen=True)
class Facet:
    """A piece of {h eta <= k} on one of its rows: points ``foot + basis y``, ``rows y <= bounds``.

    ``normal`` (r,) points out of the region; basis (r, r - 1); rows (q, r - 1).
    """

    normal: FloatArray
    foot: FloatArray
    basis: FloatArray
    rows: FloatArray
    bounds: FloatArray


def facet_of(region: Region, program: Canonical, row: int) -> Facet:
    """The whole facet on row ``row`` of ``region``, domain included."""
    normal = region.h[row]
    foot = region.centre + normal * (region.k[row] - normal @ region.centre)
    basis = np.linalg.svd(normal[None, :])[2][1:].T
    others = np.arange(region.k.size) != row
    h = np.vstack([region.h[others], program.domain_rows])
    k = np.concatenate([region.k[others], program.domain_bounds])
    return Facet(normal, foot, basis, h @ basis, k - h @ foot)


def generic_point(piece: Facet) -> tuple[FloatArray, float] | None:
    """A point off the middle of a piece, and its distance to the rim; None if the piece is flat.

    The middle of a symmetric program's facet may lie on further facets' continuations, so the point
    is moved by a third of the radius in a fixed direction of no particular meaning.
    """
    size = piece.basis.shape[1]
    if size == 0:
        return piece.foot, 1.0
    ball = inner_ball(piece.rows, piece.bounds) if piece.bounds.size else None
    radius = 1.0 if ball is None else ball.radius
    if radius <= FLAT:
        return None
    centre = np.zeros(size) if ball is None else ball.centre
    odd = np.cos(1.0 + 2.3 * np.arange(size))
    return piece.foot + piece.basis @ (centre + radius / 3.0 * odd / np.linalg.norm(odd)), radius


def subtract(piece: Facet, region: Region) -> Iterator[Facet]:
    """Parts of ``piece`` outside ``region``, which touches its hyperplane from the other side."""
    rows, bounds = piece.rows, piece.bounds
    for h, k in zip(region.h, region.k, strict=True):
        along = h @ piece.basis
        length = float(np.linalg.norm(along))
        if length <= SAME_PLANE:  # the facet's own hyperplane, or one parallel to it
            continue
        along, bound = along / length, float(k - h @ piece.foot) / length
        part = Facet(
            piece.normal, piece.foot, piece.basis,
            np.vstack([rows, -along]), np.append(bounds, -bound),
        )  # fmt: skip
        if inner_ball(part.rows, part.bounds).radius > FLAT:
            yield part
        rows, bounds = np.vstack([rows, along]), np.append(bounds, bound)


def bounds_feasible_set(program: Canonical, normal: FloatArray, height: float) -> bool:
    """Whether no feasible parameter lies beyond normal eta = height: one linear program."""
    rows = np.hstack([program.g, -program.e])
    wide = np.hstack([np.zeros((program.domain_bounds.size, program.g.shape[1])),
                      program.domain_rows])  # fmt: skip
    objective = np.concatenate([np.zeros(program.g.shape[1]), normal])
    bounds = np.concatenate([program.w, program.domain_bounds])
    room = max(FLAT, END_SHARE * float(np.max(np.abs(bounds), initial=0.0)))
    return greatest(np.vstack([rows, wide]), bounds, objective) <= height + room


def _shared(piece: Facet, region: Region) -> float:
    """Radius of what a piece and a region behind it have in common on the piece's hyperplane."""
    if not piece.basis.shape[1]:
        return 1.0
    along, bounds = region.h @ piece.basis, region.k - region.h @ piece.foot
    lengths = np.linalg.norm(along, axis=1)
    across = lengths > SAME_PLANE
    rows = np.vstack([piece.rows, along[across] / lengths[across, None]])
    limits = np.concatenate([piece.bounds, bounds[across] / lengths[across]])
    return inner_ball(rows, limits).radius if limits.size else 1.0


@dataclass(frozen=True)
class Behind:
    """What lies behind a piece of a facet: a region that shares a full-dimensional part of it, or
    none: the end of the feasible set unless there is a ``note`` of which active sets were met."""

    region: Region | None
    note: str


def optimal_set(program: Canonical, eta: FloatArray) -> ActiveSet | None:
    """The rows that are active at the optimum for one eta (r,); None if no s keeps all rows, rows
    at angles below 1e-7 (``QP_DEPENDENT``) taken for parallel.

    Raises:
        ExplicitError: the program's solution does not end, which rounding alone can cause.
    """
    bound, free = program.w + program.e @ eta, np.zeros(program.g.shape[1])
    try:
        found = nearest(program.g, bound, free, QP_VIOLATION, _TOLERANCES)
    except NotSolved as error:
        expected = "rows that its numbers tell apart (fewer constraints, a shorter horizon)"
        raise ExplicitError("active set", "not found", expected) from error
    return found.active if found.kept else None


def across(program: Canonical, piece: Facet, build: Callable[[ActiveSet], Region | None]) -> Behind:
    """What lies behind a generic point of a piece that is not flat."""
    found = generic_point(piece)
    assert found is not None
    point, radius = found
    met: list[ActiveSet] = []
    for step in STEPS_ACROSS:
        beyond = point + min(step, radius) * piece.normal
        active = optimal_set(program, beyond)
        if active is None:
            height = float(piece.normal @ piece.foot)
            if bounds_feasible_set(program, piece.normal, height):
                return Behind(None, "")
            continue
        met.append(active)
        region = build(active)
        if region is None:
            continue
        excess = np.max(region.h @ point - region.k) if region.k.size else -1.0
        if excess <= TOUCHES and _shared(piece, region) > FLAT:
            return Behind(region, "")
    where = np.array2string(point, precision=6)
    return Behind(None, f"behind a facet at {where}, radius {radius:.1e}: active sets {met}")
