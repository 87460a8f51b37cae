"""Polyhedra {z : h z <= k} by linear programs (HiGHS): support, emptiness, centre, redundancy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from servogen.plants.statespace import FloatArray
from servogen.sets.errors import EmptySetError, SetError

IntArray = npt.NDArray[np.int64]

# HiGHS's tightest setting. Rows are scaled to k = 1 or unit length before, so this is relative.
LP_TOLERANCE = 1e-10
# A row counts as redundant when the others let it exceed its bound by no more than this, relative
# to the bound: ten times what the LP resolves, a hundredth of the 1e-8 left to the proofs.
REDUNDANCY_TOLERANCE = 1e-9

_OPTIONS = {
    "primal_feasibility_tolerance": LP_TOLERANCE,
    "dual_feasibility_tolerance": LP_TOLERANCE,
}


@dataclass(frozen=True)
class Maximum:
    """Result of one LP: the greatest value (inf if unbounded) and where it is reached, (n,)."""

    value: float
    point: FloatArray | None


def maximise(h: FloatArray, k: FloatArray, objective: FloatArray) -> Maximum:
    """Greatest ``objective`` . z over {z : h z <= k}.

    Columns are scaled by powers of two, rows to unit largest entry.

    Args:
        h: (rows, n), k: (rows,), objective: (n,).

    Raises:
        EmptySetError: the set is empty.
        SetError: HiGHS gives up.
    """
    columns = _powers_of_two(np.max(np.abs(h), axis=0)) if h.size else np.ones(objective.size)
    scaled = h / columns
    rows = _powers_of_two(np.max(np.abs(scaled), axis=1))
    cost = objective / columns
    size = float(_powers_of_two(np.array([np.max(np.abs(cost))]))[0])
    result = _solve(-cost / size, scaled / rows[:, None], k / rows, presolve=True)
    if result.status == 4:  # presolve may stop at "unbounded or infeasible"; without it, it knows
        result = _solve(-cost / size, scaled / rows[:, None], k / rows, presolve=False)
    if result.status == 3:
        return Maximum(float("inf"), None)
    if result.status == 2:
        raise EmptySetError("constraints", None, "a set that is not empty")
    if result.status != 0:
        raise SetError("constraints", None, f"a linear program that solves ({result.message})")
    return Maximum(float(cost @ result.x), np.asarray(result.x / columns, dtype=np.float64))


def _solve(cost: FloatArray, h: FloatArray, k: FloatArray, presolve: bool) -> Any:
    options = {**_OPTIONS, "presolve": presolve}
    return linprog(cost, A_ub=h, b_ub=k, bounds=(None, None), method="highs", options=options)


def _powers_of_two(values: FloatArray) -> FloatArray:
    """The nearest power of two of each value, one for zero: scaling by it rounds nothing."""
    safe = np.where(values > 0.0, values, 1.0)
    return np.asarray(np.exp2(np.round(np.log2(safe))), dtype=np.float64)


def chebyshev_centre(h: FloatArray, k: FloatArray) -> tuple[FloatArray, float]:
    """Centre (n,) and radius of the greatest ball inside; the radius is negative if empty.

    A radius of inf means that the set contains balls of any size.
    """
    norms = np.linalg.norm(h, axis=1)
    extended = np.column_stack([h, norms])
    best = maximise(extended, k, np.append(np.zeros(h.shape[1]), 1.0))
    if best.point is None:
        return np.zeros(h.shape[1]), float("inf")
    return best.point[:-1], float(best.point[-1])


def is_empty(h: FloatArray, k: FloatArray) -> bool:
    """Whether no point satisfies h z <= k (a single point is not empty)."""
    return chebyshev_centre(h, k)[1] < -LP_TOLERANCE


def remove_redundant(
    h: FloatArray, k: FloatArray, tolerance: float = REDUNDANCY_TOLERANCE
) -> IntArray:
    """Indices, ascending, of rows that still describe {h z <= k} when the others are dropped.

    Rows are tried from the last to the first, so of two equal rows the first stays; the order is
    fixed and so is the result. A row is dropped when the rest holds it to its bound within
    ``tolerance`` times the larger of |k_i| and the largest entry of the row.

    Raises:
        SetError: the set is empty.
    """
    kept = list(range(h.shape[0]))
    for i in reversed(range(h.shape[0])):
        others = [j for j in kept if j != i]
        slack = tolerance * max(abs(float(k[i])), float(np.max(np.abs(h[i]))))
        if not others:
            continue
        if not np.any(h[i]):
            if k[i] < 0.0:
                raise EmptySetError("constraints", None, "a set that is not empty")
            kept = others
            continue
        # the row itself, loosened, keeps the LP bounded without changing the answer
        rows = np.vstack([h[others], h[i]])
        bounds = np.append(k[others], k[i] + abs(float(k[i])) + 1.0)
        if maximise(rows, bounds, h[i]).value <= float(k[i]) + slack:
            kept = others
    return np.array(kept, dtype=np.int64)


def remove_redundant_pairs(h: FloatArray, tolerance: float = REDUNDANCY_TOLERANCE) -> IntArray:
    """The same for {z : |h z| <= 1}, one LP per pair: indices of the pairs that stay."""
    kept = list(range(h.shape[0]))
    for i in reversed(range(h.shape[0])):
        others = [j for j in kept if j != i]
        if others and pair_is_redundant(h[others], h[i], tolerance):
            kept = others
    return np.array(kept, dtype=np.int64)


def pair_is_redundant(
    h: FloatArray, row: FloatArray, tolerance: float = REDUNDANCY_TOLERANCE
) -> bool:
    """Whether |h z| <= 1 implies |row z| <= 1 within ``tolerance``: one LP, by symmetry."""
    both = np.vstack([h, -h, row])  # the row itself, loosened, keeps the LP bounded
    bounds = np.append(np.ones(2 * h.shape[0]), 2.0)
    return maximise(both, bounds, row).value <= 1.0 + tolerance
