"""Critical regions: where one active set is optimal, and the affine optimum that it gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.image import Canonical
from servogen.explicit.small_lp import Ball, greatest, inner_ball
from servogen.explicit.tolerances import (
    CONSTANT_ROW,
    FLAT,
    INDEPENDENCE,
    REDUNDANT,
    SAME_PLANE,
)
from servogen.plants.statespace import FloatArray

MULTIPLIER, SLACK = 0, 1


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
    kinds: FloatArray
    places: FloatArray
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
    rest = np.setdiff1d(np.arange(program.w.size), a)
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


def ball_of(program: Canonical, found: Candidate) -> Ball:
    """A ball in the candidate's region and the domain; flat or empty if its radius says so."""
    h = np.vstack([found.h, program.domain_rows])
    k = np.concatenate([found.k, program.domain_bounds])
    return inner_ball(h, k) if k.size else Ball(np.zeros(program.image.size), 1.0)


def facets(
    h: FloatArray, k: FloatArray, domain_h: FloatArray, domain_k: FloatArray, centre: FloatArray
) -> list[list[int]]:
    """Rows of {h x <= k} that are facets within the domain, each with the rows equal to it.

    Rays from the interior point ``centre`` settle most rows: the one that a ray meets first, well
    before any other, is a facet. The others each cost a linear program.
    """
    groups = _equal_rows(h, k)
    leaders = [group[0] for group in groups]
    rows, bounds = h[leaders], k[leaders]
    all_rows, all_bounds = np.vstack([rows, domain_h]), np.concatenate([bounds, domain_k])
    known = _met_first(all_rows, all_bounds, rows, centre)
    kept = list(range(all_bounds.size))
    result = []
    for i in range(len(leaders)):
        if not known[i]:
            others = [j for j in kept if j != i]
            loosened = np.append(all_bounds[others], all_bounds[i] + 1.0)
            top = greatest(np.vstack([all_rows[others], all_rows[i]]), loosened, all_rows[i])
            if top <= all_bounds[i] + REDUNDANT:
                kept = others
                continue
        result.append(groups[i])
    return result


def _equal_rows(h: FloatArray, k: FloatArray) -> list[list[int]]:
    """Rows gathered with their equals; of parallel rows only those with the least bound stay."""
    groups: list[list[int]] = []
    for i in range(k.size):
        for group in groups:
            j = group[0]
            if np.max(np.abs(h[i] - h[j])) <= SAME_PLANE:
                if abs(k[i] - k[j]) <= SAME_PLANE * (1.0 + abs(k[i])):
                    group.append(i)
                elif k[i] < k[j]:
                    group[:] = [i]
                break
        else:
            groups.append([i])
    return groups


def _met_first(h: FloatArray, k: FloatArray, rays: FloatArray, centre: FloatArray) -> FloatArray:
    """(rows,) whether some ray from ``centre`` leaves the set through that row alone."""
    known = np.zeros(k.size, dtype=bool)
    slack = k - h @ centre
    if np.any(slack <= 0.0) or not rays.size:
        return known
    speed = h @ rays.T
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.where(speed > 1e-9, slack[:, None] / speed, np.inf)
    order = np.argsort(times, axis=0)
    for j in range(rays.shape[0]):
        first = times[order[0, j], j]
        second = times[order[1, j], j] if k.size > 1 else np.inf
        if np.isfinite(first) and second > first * (1.0 + 1e-6) + REDUNDANT * 10.0:
            known[order[0, j]] = True
    return known


def is_full(ball: Ball) -> bool:
    """Whether a set with this ball counts as full-dimensional."""
    return ball.radius > FLAT
