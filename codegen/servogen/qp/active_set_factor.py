"""The working set and the factor S = A_W H^-1 A_W' = L D L' of it: rows that enter and leave.

Every sum is taken in the order of the emitted C (``templates/active_set_factor.jinja``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.qp.ordered import dot, matvec


@dataclass
class WorkingSet:
    """What one call leaves to the next: the working set, its factor and its vectors.

    Attributes:
        size: q, rows in the set. row, side: (N,) which, and 1 for the upper side, -1 the lower.
        factor: (N + 1, N) L below its diagonal of ones, and a row for the one that enters.
        pivots: (N,) 1 / D. square: (N,) a'H^-1 a; one where all rows have that length.
        vectors: (N, N) H^-1 a, without the sign, in the order of ``slot``.
        slot: (N,) where a row of the set has its vector; the rest are free.
        dual: (N,) multipliers. missed: (N,) what its rows miss of their bounds.
        pending: whether the row after them was to enter at the cap; its multiplier and excess are
            in their place. refining, forced, stalled: as they were there.
    """

    size: int
    row: list[int]
    side: list[int]
    slot: list[int]
    factor: FloatArray
    pivots: FloatArray
    square: FloatArray
    vectors: FloatArray
    dual: FloatArray
    missed: FloatArray
    pending: bool = False
    refining: bool = False
    forced: bool = False
    stalled: bool = False

    def forget(self) -> None:
        """Be as a first call finds it: the order of the slots is one of sums too."""
        self.size = 0
        self.pending = self.refining = self.forced = self.stalled = False
        self.slot[:] = range(len(self.slot))


def empty_set(tables: ActiveSetTables) -> WorkingSet:
    """No row, for a first call."""
    n, real = tables.rows.variables, tables.inverse.dtype
    return WorkingSet(
        0, [0] * n, [1] * n, list(range(n)),
        np.zeros((n + 1, n), real), np.zeros(n, real), np.zeros(n, real), np.zeros((n, n), real),
        np.zeros(n, real), np.zeros(n, real),
    )  # fmt: skip


class Appended(NamedTuple):
    """Whether a row was appended, its ``square`` a'H^-1 a, and what the set leaves of it."""

    done: bool
    square: np.floating
    left: np.floating


def within(tables: ActiveSetTables, x: np.floating) -> np.floating:
    """Kept within plus and minus ``large``, which only the proof of the C needs."""
    return min(max(x, -tables.large), tables.large)


def forward(tables: ActiveSetTables, work: WorkingSet, x: FloatArray) -> None:
    """x (q,) becomes L^-1 x, from the first entry to the last."""
    for j in range(x.size):
        total = x[j]
        for k in range(j):
            total = total - work.factor[j, k] * x[k]
        x[j] = within(tables, total)


def back(tables: ActiveSetTables, work: WorkingSet, x: FloatArray) -> None:
    """x (q,) becomes L^-T x, from the last entry to the first."""
    for j in range(x.size - 1, -1, -1):
        x[j] = within(tables, x[j])
        x[:j] = x[:j] - work.factor[j, :j] * x[j]


def append(
    tables: ActiveSetTables, work: WorkingSet, row: int, side: int, forced: bool = False
) -> Appended:
    """Extend the factor by a row; not ``done``, and the set as it was, where it depends on it.

    Row q of L then holds L^-1 times its products with the others, over D.

    Args:
        forced: down to what is rounding indeed.
    """
    q, rows = work.size, tables.rows
    own = rows.row(row)
    part = slice(rows.begin(row), own.size)
    vector = matvec(tables.inverse[part], own[part])
    pivot = square = dot(own[part], vector[part])
    under = work.factor[q]
    for j in range(q):
        product = rows.dot(work.row[j], vector)
        under[j] = product if side == work.side[j] else -product
    forward(tables, work, under[:q])
    for j in range(q):
        scaled = within(tables, under[j] * work.pivots[j])
        pivot = pivot - scaled * under[j]
        under[j] = scaled
    left = min(max(pivot, tables.rounding * square), tables.large)
    least = tables.rounding if forced else tables.dependent
    if q == rows.variables or not pivot > least * square:
        return Appended(False, square, left)
    real = tables.inverse.dtype.type
    work.pivots[q] = real(1.0) / min(max(pivot, tables.small), tables.large)
    work.square[q] = real(1.0) if tables.unit else square
    work.vectors[work.slot[q]] = vector
    work.row[q], work.side[q], work.dual[q] = row, side, real(0.0)
    work.size = q + 1
    return Appended(True, square, left)


def remove(tables: ActiveSetTables, work: WorkingSet, p: int) -> None:
    """Take row p out: L D L' of the rest by a rank-one update of what stood below it."""
    q = work.size
    real = tables.inverse.dtype.type
    below = work.factor[:, p].copy()
    weight = real(1.0) / max(work.pivots[p], tables.small)
    freed = work.slot[p]
    for j in range(p, q - 1):
        work.row[j], work.side[j] = work.row[j + 1], work.side[j + 1]
        work.slot[j], work.dual[j] = work.slot[j + 1], work.dual[j + 1]
        work.square[j] = work.square[j + 1]
        work.factor[j, :p] = work.factor[j + 1, :p]
        work.factor[j, p:j] = work.factor[j + 1, p + 1 : j + 1]
        below[j] = below[j + 1]
    work.slot[q - 1] = freed
    for j in range(p, q - 1):
        old = real(1.0) / max(work.pivots[j + 1], tables.small)
        mine = within(tables, below[j])
        part = weight * mine
        new = min(max(old + part * mine, tables.small), tables.large)
        inverse = real(1.0) / new
        share = within(tables, part * inverse)
        weight = min(max((old * weight) * inverse, real(0.0)), tables.large)
        work.pivots[j] = inverse
        for i in range(j + 1, q - 1):
            below[i] = below[i] - mine * work.factor[i, j]
            work.factor[i, j] = within(tables, work.factor[i, j] + share * below[i])
    work.size = q - 1
