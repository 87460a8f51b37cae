"""Critical regions: where one active set is optimal, and the affine optimum that it gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.image import Canonical
from servogen.explicit.small_lp import Ball, BoolArray, IntArray, greatest_many, inner_balls
from servogen.explicit.tolerances import (
    CONSTANT_ROW,
    FLAT,
    INDEPENDENCE,
    REDUNDANT,
    SAME_PLANE,
)
from servogen.plants.statespace import FloatArray

MULTIPLIER, SLACK = 0, 1
# Linear programs of different regions that are solved together.
_CHUNK = 256
# Regions behind a row whose middles a ray goes to, before a linear program is asked.
_NEAREST = 6


@dataclass(frozen=True)
class Candidate:
    """What an active set implies, whether or not a region comes of it.

    Attributes:
        active: places of the active rows in ``Canonical``, ascending.
        h, k: (rows, r), (rows,): unit rows of the set where it is optimal, the domain left out.
        kinds, places: (rows,) what each row says: a multiplier of an active row not negative
            (``MULTIPLIER``), or a slack of an inactive one (``SLACK``), and of which row.
        slope, offset: (n, r), (n,): the optimum s = slope eta + offset.
        weakly_active: rows that hold with equality all over without being needed.
    """

    active: tuple[int, ...]
    h: FloatArray
    k: FloatArray
    kinds: IntArray
    places: IntArray
    slope: FloatArray
    offset: FloatArray
    weakly_active: tuple[int, ...]


@dataclass(frozen=True)
class Region:
    """A full-dimensional critical region {h eta <= k} within the domain.

    Attributes:
        active: numbers of the active constraints, ascending (see ``ParametricQP``).
        h, k: (facets, r), (facets,): unit rows, none redundant, the domain's own facets left out.
        slope, offset: (n, r), (n,): the optimum s = slope eta + offset of ``Canonical``.
        centre, radius: (r,) a ball inside, of radius at most 1.
        law: index of its first-move law.
        weakly_active: numbers of constraints that hold with equality without being needed.
    """

    active: tuple[int, ...]
    h: FloatArray
    k: FloatArray
    slope: FloatArray
    offset: FloatArray
    centre: FloatArray
    radius: float
    law: int
    weakly_active: tuple[int, ...]


def is_independent(program: Canonical, active: tuple[int, ...]) -> bool:
    """Whether the active rows are linearly independent (LICQ)."""
    if len(active) > program.g.shape[1]:
        return False
    if not active:
        return True
    values = np.linalg.svd(program.g[list(active)], compute_uv=False)
    return bool(values[-1] > INDEPENDENCE)


def candidate(program: Canonical, active: tuple[int, ...]) -> Candidate | None:
    """The optimum and the region of an independent active set; None where a constant row fails.

    With the active rows a: s = g_a' N (w_a + e_a eta), multipliers -N (w_a + e_a eta),
    N = (g_a g_a')^-1.
    """
    a = list(active)
    inactive = np.ones(program.w.size, dtype=bool)
    inactive[a] = False
    rest = np.flatnonzero(inactive)
    g_a = program.g[a]
    solved = np.linalg.solve(g_a @ g_a.T, np.column_stack([program.e[a], program.w[a]]))
    both = g_a.T @ solved
    slope, offset = both[:, :-1].astype(np.float64), both[:, -1].astype(np.float64)
    h = np.vstack([solved[:, :-1], program.g[rest] @ slope - program.e[rest]])
    k = np.concatenate([-solved[:, -1], program.w[rest] - program.g[rest] @ offset])
    lengths = np.linalg.norm(h, axis=1)
    terms = np.concatenate([
        np.linalg.norm(solved[:, :-1], axis=1),
        np.linalg.norm(slope) + np.linalg.norm(program.e[rest], axis=1),
    ])  # fmt: skip
    constant = lengths <= CONSTANT_ROW * np.maximum(terms, 1e-300)
    sizes = 1.0 + np.abs(np.concatenate([solved[:, -1], program.w[rest]]))
    if np.any(constant & (k < -CONSTANT_ROW * sizes)):
        return None
    places = np.concatenate([a, rest]).astype(np.int64)
    touching = constant & (np.abs(k) <= CONSTANT_ROW * sizes)
    touching[: len(a)] = False
    kept = ~constant
    kinds = np.where(np.arange(places.size) < len(a), MULTIPLIER, SLACK)
    return Candidate(
        active,
        h[kept] / lengths[kept, None],
        k[kept] / lengths[kept],
        kinds[kept],
        places[kept],
        slope,
        offset,
        tuple(int(i) for i in places[touching]),
    )


def exchanges(program: Canonical, active: tuple[int, ...], entering: int) -> list[tuple[int, ...]]:
    """Active sets beyond a facet where a row that depends on the active ones is reached.

    With g_entering = sum c_i g_i, the multiplier of the entering row can rise until that of an i
    with c_i > 0 vanishes: that row leaves. Which one differs along the facet, so each is named.
    Without any c_i > 0 the rows contradict each other beyond (Farkas): no set, nothing feasible.
    """
    if not active:
        return []
    rows = program.g[list(active)]
    share = np.linalg.lstsq(rows.T, program.g[entering], rcond=None)[0]
    found = []
    for i, c in zip(active, share, strict=True):
        beyond = tuple(sorted((*(j for j in active if j != i), entering)))
        if c > INDEPENDENCE and is_independent(program, beyond):
            found.append(beyond)
    return found


def balls_of(
    program: Canonical, made: list[Candidate], near: FloatArray | None = None
) -> list[Ball]:
    """Balls in the candidates' regions and the domain; flat or empty if the radius says so.

    Args:
        near: (made, r) a point that each may be near to: the numbers stay small.
    """
    if not made:
        return []
    most, size = max(each.k.size for each in made), program.image.size
    h = np.zeros((len(made), most, size))
    k = np.ones((len(made), most))  # rows 0 eta <= 1 fill up
    for i, each in enumerate(made):
        h[i, : each.k.size], k[i, : each.k.size] = each.h, each.k
    limits = np.broadcast_to(program.domain_bounds, (len(made), program.domain_bounds.size))
    if not most + program.domain_bounds.size:
        return [Ball(np.zeros(size), 1.0) for _ in made]
    bounds = np.concatenate([k, limits], axis=1)
    shared = program.domain_rows if program.domain_bounds.size else None
    return inner_balls(h, bounds, shared=shared, near=near)


def facets(
    program: Canonical, made: list[Candidate], centres: list[FloatArray]
) -> list[list[list[int]]]:
    """Of each candidate, the rows that are facets within the domain, with the rows equal to them.

    Rays from an interior point, along the rows and to the middle of other regions behind them,
    settle most rows: the one that a ray meets first, well before any other, is a facet. The others
    cost a linear program each; all are solved together. Of a full-dimensional set without equal
    rows, those that are no facets may go together.
    """
    groups = [_equal_rows(each.h, each.k) for each in made]
    leaders = [[group[0] for group in mine] for mine in groups]
    domain_h, domain_k = program.domain_rows, program.domain_bounds
    most = max((len(mine) for mine in leaders), default=0)
    is_facet = np.zeros((len(made), most), dtype=bool)
    h = np.zeros((len(made), most, program.image.size))
    k = np.ones((len(made), most + domain_k.size))  # rows 0 eta <= 1 fill up
    pending: list[tuple[int, int]] = []
    for i, (each, rows, centre) in enumerate(zip(made, leaders, centres, strict=True)):
        count = len(rows)
        # heights above the centre, which may be far from the origin
        h[i, :count], k[i, :count] = each.h[rows], each.k[rows] - each.h[rows] @ centre
        k[i, most:] = domain_k - domain_h @ centre
        all_rows = np.vstack([h[i], domain_h])
        known = _met_first(all_rows, k[i], each.h[rows])[:count]
        if not np.all(known) and len(made) > 1:
            rays = _across(h[i, :count][~known], k[i, :count][~known], np.array(centres) - centre)
            known |= _met_first(all_rows, k[i], rays)[:count]
        is_facet[i, :count] = known
        pending += [(i, j) for j in range(count) if not is_facet[i, j]]
    for start in range(0, len(pending), _CHUNK):
        chunk = np.array(pending[start : start + _CHUNK])
        at, row = chunk[:, 0], chunk[:, 1]
        loosened = k[at]
        loosened[np.arange(at.size), row] += 1.0
        shared = domain_h if domain_k.size else None
        floors = k[at, row] + 0.5 * REDUNDANT
        tops = greatest_many(h[at], loosened, h[at, row], shared, floors)
        is_facet[at, row] = tops > k[at, row] + REDUNDANT
    return [
        [group for group, facet in zip(mine, is_facet[i], strict=False) if facet]
        for i, mine in enumerate(groups)
    ]


def _across(h: FloatArray, slack: FloatArray, others: FloatArray) -> FloatArray:
    """(rays, r) to the nearest of other points behind each row, all seen from one point."""
    near = np.argsort(np.einsum("ij,ij->i", others, others), kind="stable")
    behind = others[near] @ h.T > slack
    ranks = np.cumsum(behind, axis=0)
    rays: FloatArray = others[near][np.any(behind & (ranks <= _NEAREST), axis=1)]
    return rays


def _equal_rows(h: FloatArray, k: FloatArray) -> list[list[int]]:
    """Rows gathered with their equals; of parallel rows only those with the least bound stay."""
    apart = np.max(np.abs(h[:, None] - h[None]), axis=2) if k.size else np.zeros((0, 0))
    if np.count_nonzero(apart <= SAME_PLANE) == k.size:  # each is like itself alone
        return [[i] for i in range(k.size)]
    groups: list[list[int]] = []
    for i in range(k.size):
        for group in groups:
            j = group[0]
            if apart[i, j] <= SAME_PLANE:
                if abs(k[i] - k[j]) <= SAME_PLANE * (1.0 + abs(k[i])):
                    group.append(i)
                elif k[i] < k[j]:
                    group[:] = [i]
                break
        else:
            groups.append([i])
    return groups


def _met_first(h: FloatArray, slack: FloatArray, rays: FloatArray) -> BoolArray:
    """(rows,) whether some ray from a point with these slacks leaves through that row alone."""
    known = np.zeros(slack.size, dtype=bool)
    if slack.size < 2 or np.any(slack <= 0.0):
        return known
    speed = h @ rays.T
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.where(speed > 1e-9, slack[:, None] / speed, np.inf)
    first = np.argmin(times, axis=0)
    at = np.arange(rays.shape[0])
    nearest = times[first, at].copy()
    times[first, at] = np.inf
    clear = np.isfinite(nearest)
    clear[clear] = times.min(axis=0)[clear] > nearest[clear] * (1.0 + 1e-6) + 10.0 * REDUNDANT
    known[first[clear]] = True
    return known


def is_full(ball: Ball) -> bool:
    """Whether a set with this ball counts as full-dimensional."""
    return ball.radius > FLAT
