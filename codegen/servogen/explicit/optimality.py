"""That an active set is optimal all over its region, and that the region's law is its first move.

Sufficient and necessary for the optimum of a strictly convex program are stationarity, the active
rows held with equality, multipliers that are not negative and slacks that are not. The first two
are equations: they are solved here, in the program's own matrices. The others are linear in the
parameters: over a region each is proved by being one of its rows, or by a linear program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servogen.explicit.regions import Region
from servogen.explicit.restated import Affine, Restated
from servogen.explicit.small_lp import IntArray, greatest_many
from servogen.explicit.solution import Laws
from servogen.explicit.tolerances import CONSTANT_ROW, LEAST_LAW, SAME_LAW, SEEN
from servogen.plants.statespace import FloatArray
from servogen.progress import Task

# Linear programs of different regions that are solved together.
_CHUNK = 256


@dataclass(frozen=True)
class Optimal:
    """What was found of all regions.

    Attributes:
        law_error: greatest difference between a coefficient of a law and of the optimum's first
            move, relative to the law's largest coefficient of that move (``LEAST_LAW``).
        reach: greatest distance by which a region reaches beyond a plane where a multiplier or a
            slack turns negative; inf where the equations have no solution.
        unseen: see ``Restated.seen``.
        rows: multipliers and slacks proved; programs: linear programs that took.
        where: the active set with the greatest ``reach`` or, where that is small, ``law_error``.
    """

    law_error: float
    reach: float
    unseen: float
    rows: int
    programs: int
    where: str


@dataclass(frozen=True)
class _Signs:
    """What must not be negative over a region: h eta <= k, unit rows, and ``unseen``."""

    h: FloatArray
    k: FloatArray
    moves: Affine
    unseen: float
    broken: float


def prove_optimal(
    own: Restated, regions: Sequence[Region], law_of: IntArray, laws: Laws, task: Task
) -> Optimal:
    """Every region against the program: its active set's signs, and its law.

    Args:
        regions: their active sets and rows are what is proved; nothing else of them is used.
        law_of: (regions,) index of each one's law.
    """
    if len(law_of) != len(regions):
        return Optimal(np.inf, np.inf, 0.0, 0, 0, "regions and laws differ in number")
    law_error, reach, unseen, rows = 0.0, -np.inf, 0.0, 0
    where, sizes = "", _law_sizes(laws)
    pending: list[tuple[int, FloatArray, float]] = []
    for i, region in enumerate(regions):
        task.advance()
        signs = _signs(own, region.active)
        if signs is None:
            return Optimal(np.inf, np.inf, unseen, rows, 0, f"{region.active}: dependent rows")
        off = _law_difference(signs.moves, laws, int(law_of[i]), sizes)
        if off > law_error:
            law_error, where = off, str(region.active)
        unseen = max(unseen, signs.unseen)
        reach = max(reach, signs.broken)
        rows += signs.k.size
        kept = _restated_rows(region, signs.h, signs.k)
        known = np.isfinite(kept)
        reach = max(reach, float(np.max(kept[known], initial=-np.inf)))
        pending += [(i, signs.h[j], float(signs.k[j])) for j in np.flatnonzero(~known)]
    tops = _tops(own, regions, pending)
    if tops.size and float(np.max(tops)) > reach:
        reach = float(np.max(tops))
        where = str(regions[pending[int(np.argmax(tops))][0]].active)
    return Optimal(law_error, max(reach, 0.0), unseen, rows, len(pending), where)


def _signs(own: Restated, active: tuple[int, ...]) -> _Signs | None:
    """From the equations of an active set; None where its rows depend on each other."""
    n, p = own.linear.shape
    held = [own.places[number] for number in active if number in own.places]
    if len(held) != len(active) or len(held) > n:
        return None
    g_a = own.g[held]
    matrix = np.zeros((n + len(held), n + len(held)))
    matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = own.hessian, g_a.T, g_a
    right = np.zeros((n + len(held), p + 1))
    right[:n, :p], right[:n, p] = -own.linear, -own.constant
    right[n:, :p], right[n:, p] = own.s[held], own.w[held]
    try:
        solved = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return None
    left = np.max(np.abs(matrix @ solved - right), axis=0)
    if np.any(left > SEEN * (1e-300 + np.max(np.abs(right)))):
        return None
    rest = np.setdiff1d(np.arange(own.w.size), held)
    z, multipliers = solved[:n], solved[n:]
    slack = np.column_stack([own.s, own.w])[rest] - own.g[rest] @ z
    terms, own_terms = _terms(own, rest, z[:, :p], multipliers[:, :p])
    sizes = np.abs(own.w[rest]) + np.abs(own.g[rest]) @ np.abs(z[:, p])
    functions = np.vstack([multipliers, slack])
    over, unseen = own.seen(functions[:, :p], functions[:, p], np.append(own_terms, terms))
    nu = own.problem.first_move
    first = z[:nu] * own.sizes[:nu, None]
    move_terms = own.sizes[:nu] * np.linalg.norm(own.free[:nu], axis=1)
    moves, unseen_moves = own.seen(
        first[:, :p], first[:, p], np.maximum(np.linalg.norm(first[:, :p], axis=1), move_terms)
    )
    lengths = np.linalg.norm(over.slope, axis=1)
    constant = lengths <= CONSTANT_ROW * np.maximum(over.terms, 1e-300)
    # a constant that must not be negative, as a share of what it is the difference of
    shares = over.offset / (1.0 + np.append(np.abs(multipliers[:, p]), sizes))
    broken = float(np.max(-shares[constant], initial=-np.inf))
    kept = ~constant
    h, k = -over.slope[kept] / lengths[kept, None], over.offset[kept] / lengths[kept]
    return _Signs(h, k, moves, max(unseen, unseen_moves), broken)


def _terms(
    own: Restated, rest: IntArray, z: FloatArray, multipliers: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Lengths of what slacks and multipliers are sums of: what cancels in them is what the optimum
    without constraints and the cost are made of, if their own terms have not more."""
    sizes = np.maximum(np.abs(z), np.abs(own.free))
    slack = np.linalg.norm(np.abs(own.s[rest]) + np.abs(own.g[rest]) @ sizes, axis=1)
    least = np.max(np.linalg.norm(own.linear, axis=1))
    return slack, np.maximum(np.linalg.norm(multipliers, axis=1), least)


def _law_sizes(laws: Laws) -> FloatArray:
    tables = np.concatenate([laws.gains, laws.offsets[:, :, None]], axis=2)
    sizes: FloatArray = np.max(np.abs(tables), axis=2)
    sizes = np.maximum(sizes, LEAST_LAW * np.max(sizes, axis=0, initial=0.0))
    return np.where(sizes > 0.0, sizes, 1.0)


def _law_difference(moves: Affine, laws: Laws, law: int, sizes: FloatArray) -> float:
    if not 0 <= law < laws.count:
        return float("inf")
    apart = np.column_stack([
        laws.gains[law] - moves.slope, laws.offsets[law] - moves.offset,
    ])  # fmt: skip
    return float(np.max(np.abs(apart) / sizes[law][:, None]))


def _restated_rows(region: Region, h: FloatArray, k: FloatArray) -> FloatArray:
    """(rows,) by how much the region's own row of the same normal is looser; inf where it has none
    or one that alone does not show it."""
    if not region.k.size or not k.size:
        return np.full(k.size, np.inf)
    apart = np.max(np.abs(h[:, None] - region.h[None]), axis=2)
    looser = region.k[None] - k[:, None]
    looser = np.where(apart <= SAME_LAW, np.maximum(looser, apart), np.inf)
    least: FloatArray = np.min(looser, axis=1)
    return np.where(least <= SAME_LAW * (1.0 + np.abs(k)), least, np.inf)


def _tops(
    own: Restated, regions: Sequence[Region], pending: list[tuple[int, FloatArray, float]]
) -> FloatArray:
    """Of each row over its region: the greatest excess, up to one, by a linear program."""
    found = []
    for start in range(0, len(pending), _CHUNK):
        chunk = pending[start : start + _CHUNK]
        most = max(regions[i].k.size for i, _, _ in chunk) + 1
        h = np.zeros((len(chunk), most, own.coordinates))
        k = np.ones((len(chunk), most + own.domain_bounds.size))  # rows 0 eta <= 1 fill up
        k[:, most:] = own.domain_bounds
        for at, (i, row, bound) in enumerate(chunk):
            region = regions[i]
            h[at, : region.k.size], k[at, : region.k.size] = region.h, region.k
            # the row itself, loosened, keeps the program bounded
            h[at, most - 1], k[at, most - 1] = row, bound + 1.0
        rows = np.array([row for _, row, _ in chunk])
        shared = own.domain_rows if own.domain_bounds.size else None
        tops = greatest_many(h, k, rows, shared)
        tops[np.isneginf(tops)] = np.inf  # no point, or no answer: nothing is proved
        found.append(tops - np.array([bound for _, _, bound in chunk]))
    return np.concatenate(found) if found else np.zeros(0)
