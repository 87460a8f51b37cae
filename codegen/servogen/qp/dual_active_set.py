"""A dual active-set method with a factor that is kept up to date: the reference of the emitted one.

For min 1/2 z'Hz + f'z subject to low <= A z <= high. With W the working set, a_i its rows with the
sign of the side at which they hold, S = A_W H^-1 A_W' = L D L' and V = H^-1 A_W',

    z = z_unc - V lambda,    S (lambda* - lambda) = A_W z - b_W.

The multipliers lambda* at which the rows of W hold are found from what they miss at present: the
row appended last, and all of them where rounding has left more than ``accept``. One iteration is
one of three things, and every one of them raises the dual cost or shortens W:

  * some of lambda* are negative: go towards them until the first one vanishes and drop its row;
  * otherwise z and its rows: none violated, that is the optimum; else append the most violated one;
    the step is taken again, from z, as long as rounding leaves a row of W inside its bound by more
    than ``accept``, so that the rows of an optimum are met on both sides;
  * a row that depends on those of W cannot be appended: its multiplier rises, the others follow
    along S r = c, until one of them vanishes and leaves. If none falls, a row that depends only
    nearly is appended after all; otherwise no z keeps all rows, or rounding hides one
    (``no_point``).

A row is appended only if it is violated by more than ``accept``, so the full step that follows
raises the dual cost by at least accept^2 / (2 a'H^-1 a), and between two full steps rows are only
dropped: without rounding no working set comes back, whatever set the method began with. Rounding is
what the cap is for.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from servogen.precision import FloatArray, Precision
from servogen.qp.ordered import dot, matvec
from servogen.qp.row_tables import RowTables
from servogen.qp.tolerances import DEPENDENT, DOUBT, FALLS, LARGE, ROUNDING


@dataclass(frozen=True)
class ActiveSetTables:
    """Tables in the target precision.

    Attributes:
        inverse: (N, N) H^-1.
        rows: A.
        norm: (m,) square root of a'H^-1 a of every row, for who judges the method from outside;
            it computes the squares of the rows that it meets.
        dependent: share of a'H^-1 a at or below which what the working set leaves of a row is
            taken for rounding.
        rounding: the same where there is no other way than to append it.
        falls: share of its norm by which a row must hold another one to fall with it.
        large, small: what the factor and the multipliers are kept within, and from what on is
            divided by: bounds for the proof of the emitted C.
        doubt: points whose squared distance is so many times the squared reach are taken for none.
        accept: violation of a bound that is accepted.
        cap: iterations.
        stores: whether H^-1 a of the rows of the set is kept: N^2 numbers, worth it where more than
            N rows do not bound single variables. Else z is one product with H^-1 away from the
            multipliers.
        triangle: whether the emitted C keeps one triangle of H^-1 only, where fewer than N rows do
            not bound single variables; a product with it costs about twice as much.
        keep: a working set of at least so many rows stays as it is at the next call, factor and
            all; a smaller one is shifted by one sample and factored anew.
    """

    inverse: FloatArray
    rows: RowTables
    norm: FloatArray
    dependent: np.floating
    rounding: np.floating
    falls: np.floating
    doubt: np.floating
    large: np.floating
    small: np.floating
    accept: np.floating
    cap: int
    stores: bool
    triangle: bool
    keep: int


def active_set_tables(
    hessian: FloatArray, written: FloatArray, rows: RowTables, accept: float, cap: int,
    precision: Precision,
) -> ActiveSetTables:  # fmt: skip
    """Tables of H (N, N) and A, ``written`` (m, N) out and as ``rows``; rounded once.

    A set is kept from half the variables on: to factor one anew costs its size times an iteration,
    and one that large belongs to a machine that stays at its limits, where the same rows hold at
    the next sample; a small one moves towards the present with the horizon.
    """
    # with a unit diagonal: a variable in metres beside one in nanometres costs no digits
    unit = 1.0 / np.sqrt(np.diag(hessian))
    inverse = np.linalg.inv(hessian * np.outer(unit, unit))
    inverse = 0.5 * (inverse + inverse.T) * np.outer(unit, unit)
    norm = np.sqrt(np.einsum("ij,jk,ik->i", written, inverse, written))
    real = precision.dtype.type

    def rounded(values: FloatArray) -> FloatArray:
        array = np.ascontiguousarray(values, dtype=real)
        array.flags.writeable = False
        return array

    return ActiveSetTables(
        inverse=rounded(inverse),
        rows=rows,
        norm=rounded(norm),
        dependent=real(DEPENDENT[precision.name]),
        rounding=real(ROUNDING[precision.name]),
        falls=real(FALLS[precision.name]),
        doubt=real(DOUBT),
        large=real(LARGE[precision.name]),
        small=real(1.0 / LARGE[precision.name]),
        accept=real(accept),
        cap=cap,
        stores=rows.count - rows.alone > rows.variables,
        triangle=rows.count - rows.alone < rows.variables,
        keep=max(1, rows.variables // 2),
    )


@dataclass
class WorkingSet:
    """What one call leaves to the next: the working set, its factor and its vectors.

    Attributes:
        size: q, rows in the set. row, side: (N,) which, and 1 for the upper side, -1 the lower.
        factor: (N + 1, N) L below its diagonal of ones, and a row for the one that enters.
        pivots: (N,) 1 / D. square: (N,) a'H^-1 a.
        vectors: (N, N) H^-1 a, without the sign, in the order of ``slot``.
        slot: (N,) where a row of the set has its vector; the rest are free.
        dual: (N,) multipliers.
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


def empty_set(tables: ActiveSetTables) -> WorkingSet:
    """No row, for a first call."""
    n, real = tables.rows.variables, tables.inverse.dtype
    return WorkingSet(
        0, [0] * n, [1] * n, list(range(n)),
        np.zeros((n + 1, n), real), np.zeros(n, real), np.zeros(n, real), np.zeros((n, n), real),
        np.zeros(n, real),
    )  # fmt: skip


@dataclass(frozen=True)
class ActiveSetResult:
    """``z`` (N,), the optimum if ``optimal``; ``infeasible``: a row that none of the others can
    make room for was met, or one whose bounds have changed places; neither: the cap.
    ``iterations``: at most the cap; 0 where the unconstrained optimum keeps all rows."""

    z: FloatArray
    optimal: bool
    infeasible: bool
    iterations: int
    active: tuple[int, ...] = field(default=())


def solve(
    tables: ActiveSetTables,
    work: WorkingSet,
    free: FloatArray,
    low: FloatArray,
    high: FloatArray,
    start: FloatArray | None = None,
) -> ActiveSetResult:
    """The optimum from the unconstrained one, ``free`` (N,), with ``low``, ``high`` (m,).

    All in the tables' precision; ``work`` is the last call's and is left for the next one.

    Args:
        start: state (n,) in which the plant behind the rows starts; None: at rest.
    """
    method = _Method(tables, work, free, low, high, start)
    kept = work.size >= tables.keep
    if not kept and method.worst(method.free_rows) is None:
        work.size = 0
        return ActiveSetResult(free, True, False, 0)
    method.begin(kept)
    return method.run(kept)


class _Method:
    """One call."""

    def __init__(
        self, tables: ActiveSetTables, work: WorkingSet, free: FloatArray, low: FloatArray,
        high: FloatArray, start: FloatArray | None,
    ) -> None:  # fmt: skip
        self.tables, self.work, self.start = tables, work, start
        self.free, self.low, self.high = free, low, high
        self.free_rows = tables.rows.product(free, start)
        self.real = tables.inverse.dtype.type
        self.zero, self.one = self.real(0.0), self.real(1.0)
        self.missed = np.zeros(tables.rows.variables, dtype=tables.inverse.dtype)
        # of the row that ``append`` was asked for last: a'H^-1 a, and what the set leaves of it
        self.square = self.left = self.zero

    def worst(self, rows: FloatArray) -> tuple[int, int] | None:
        """Row and side of the largest violation beyond ``accept``; of equal ones the first row,
        its upper side before its lower."""
        above, below = rows - self.high, self.low - rows
        excess = np.maximum(above, below)
        i = int(np.argmax(excess))
        if not excess[i] > self.tables.accept:
            return None
        return i, 1 if above[i] >= below[i] else -1

    def begin(self, kept: bool) -> None:
        """The last call's working set, as it is or one sample on."""
        work = self.work
        if not kept:
            old = [(work.row[j], work.side[j]) for j in range(work.size)]
            work.size = 0
            for row, side in old:
                moved = self.tables.rows.shifted(row)
                if moved >= 0:
                    self.append(moved, side)
        work.dual[: work.size] = self.zero
        self.measure(self.free_rows)

    def run(self, kept: bool) -> ActiveSetResult:
        """Iterate until the optimum, a row that nothing makes room for, or the cap."""
        work, z, rows = self.work, self.free, self.free_rows
        entering: tuple[int, int] | None = None
        raised = excess = self.zero
        refining = forced = False
        for iteration in range(1, self.tables.cap + 1):
            if entering is None:
                step = self.step()
                star = work.dual[: work.size] + step
                if self.blocked(star):
                    # a set that was kept is not the right one: perhaps none is needed
                    if kept and self.worst(self.free_rows) is None:
                        work.size = 0
                        return ActiveSetResult(self.free, True, False, iteration)
                    kept = refining = False
                    continue
                kept = False
                work.dual[: work.size] = self.from_zero(star)
                # from z, so that what is left is as small as the step: z_unc and V lambda may be
                # large and their difference no better than their rounding. Every other time anew:
                # where no z keeps all rows, lambda may be huge and z far from what it stands for
                z = self.refined(z, step) if refining else self.less(self.free, work.dual)
                rows = self.tables.rows.product(z, self.start)
                entering = self.worst(rows)
                if entering is None:
                    self.measure(rows)
                    if np.any(self.missed[: work.size] < -self.tables.accept):
                        refining = True
                        continue
                    active = tuple(work.row[: work.size])
                    return ActiveSetResult(z, True, False, iteration, active)
                self.missed[:] = self.zero
                if entering[0] in work.row[: work.size]:
                    if self.low[entering[0]] > self.high[entering[0]]:
                        work.size = 0
                        return ActiveSetResult(z, False, True, iteration)
                    self.measure(rows)  # what rounding left: the next step takes it away
                    entering, refining = None, not refining
                    continue
                refining = False
                raised, excess = self.zero, self.excess(rows, *entering)
            if self.append(*entering, forced):
                work.dual[work.size - 1] = raised
                self.missed[work.size - 1] = excess
                entering, forced = None, False
                continue
            gained = self.make_room()
            if gained is None:
                if work.size < z.size and self.left > self.tables.rounding * self.square:
                    forced = True
                    continue
                beyond = self.no_point(excess, rows)
                work.size = 0  # rows that contradict are no beginning for another program
                return ActiveSetResult(z, False, beyond, iteration)
            raised = self.from_zero(raised + gained)
        return ActiveSetResult(z, False, False, self.tables.cap)

    def within(self, x: np.floating) -> np.floating:
        """Kept within plus and minus ``large``, which only the proof of the C needs."""
        return min(max(x, -self.tables.large), self.tables.large)

    def from_zero(self, x: Any) -> Any:
        """Numbers kept within zero and ``large``."""
        return np.minimum(np.maximum(x, self.zero), self.tables.large)

    def excess(self, rows: FloatArray, row: int, side: int) -> np.floating:
        """By how much a row is beyond its bound; negative inside."""
        value: np.floating = rows[row] - self.high[row] if side > 0 else self.low[row] - rows[row]
        return value

    def measure(self, rows: FloatArray) -> None:
        """What the rows of the set miss at a point with these ``rows``."""
        work = self.work
        for j in range(work.size):
            self.missed[j] = self.excess(rows, work.row[j], work.side[j])

    def step(self) -> FloatArray:
        """lambda* - lambda (q,)."""
        work, q = self.work, self.work.size
        step = np.zeros(q, dtype=work.dual.dtype)
        for j in range(q):
            total = self.missed[j]
            for k in range(j):
                total = total - work.factor[j, k] * step[k]
            step[j] = self.within(total)
        step = step * work.pivots[:q]
        self.back(step)
        return step

    def back(self, x: FloatArray) -> None:
        """x becomes L^-T x, from the last entry to the first."""
        for j in range(x.size - 1, -1, -1):
            x[j] = self.within(x[j])
            x[:j] = x[:j] - self.work.factor[j, :j] * x[j]

    def blocked(self, star: FloatArray) -> bool:
        """Whether some multiplier would turn negative: then go to where the first one vanishes and
        drop its row; of several the one with the lowest place."""
        work, q = self.work, self.work.size
        share, place = self.one, -1
        for j in range(q):
            if star[j] < self.zero:
                here = work.dual[j] / max(work.dual[j] - star[j], self.tables.small)
                if place < 0 or here < share:
                    share, place = here, j
        if place < 0:
            return False
        share = min(max(share, self.zero), self.one)
        work.dual[:q] = self.from_zero(work.dual[:q] + share * (star - work.dual[:q]))
        left = self.missed[:q] - share * self.missed[:q]
        self.missed[:q] = np.minimum(np.maximum(left, -self.tables.large), self.tables.large)
        self.drop(place)
        return True

    def make_room(self) -> np.floating | None:
        """Raise the multiplier of the dependent row until one of the set vanishes and leaves; by
        how much, or None where none falls."""
        work, q = self.work, self.work.size
        share = work.factor[q, :q].copy()
        own = (self.tables.falls * self.tables.falls) * self.square
        self.back(share)
        length, place = self.zero, -1
        for j in range(q):
            falling = min(max(share[j], self.zero), self.tables.large)
            if (falling * falling) * work.square[j] > own:
                here = work.dual[j] / max(falling, self.tables.small)
                if place < 0 or here < length:
                    length, place = here, j
        if place < 0:
            return None
        length = min(max(length, self.zero), self.tables.large)
        work.dual[:q] = self.from_zero(work.dual[:q] - length * share)
        self.drop(place)
        return length

    def no_point(self, excess: np.floating, rows: FloatArray) -> bool:
        """Whether a row that cannot be kept is beyond doubt.

        What the set leaves of it is rounding, or counts as that: points that keep all rows are at
        least excess / sqrt(left) away, in the metric of H. That is far where it is more than the
        reach many times over: of the rows at z and at the unconstrained optimum, and of the moves
        V lambda, of which z is what rounding has left. What has come near ``large`` may
        have met it, and leaves doubt.
        """
        work, large = self.work, self.tables.large
        greatest = max(np.max(np.abs(rows)), np.max(np.abs(self.free_rows)))
        greatest = min(greatest, large)
        reach = greatest * greatest
        for dual, square in zip(work.dual[: work.size], work.square, strict=False):
            greatest = max(greatest, dual)
            reach = max(reach, (dual * dual) * square)
        reach = self.tables.doubt * min(reach, large * large)
        most = min(max(excess, self.zero), large)
        return bool(greatest < self.real(0.5) * large and most * most > reach * self.left)

    def drop(self, p: int) -> None:
        """Take row p out of the set, and what it misses."""
        q = self.work.size
        self.missed[p : q - 1] = self.missed[p + 1 : q].copy()
        self.remove(p)

    def refined(self, z: FloatArray, step: FloatArray) -> FloatArray:
        """z - V step (N,), kept within ``large``."""
        moved = self.less(z, step)
        result: FloatArray = np.minimum(np.maximum(moved, -self.tables.large), self.tables.large)
        return result

    def less(self, z: FloatArray, dual: FloatArray) -> FloatArray:
        """z - V dual (N,), summed in the order of the vectors' slots or, where there are none,
        of the set."""
        work = self.work
        if not self.tables.stores:
            pull = np.zeros_like(z)
            for j in range(work.size):
                own, begin = self.tables.rows.row(work.row[j]), self.tables.rows.begin(work.row[j])
                signed = dual[j] if work.side[j] > 0 else -dual[j]
                pull[begin : own.size] = pull[begin : own.size] + own[begin:] * signed
            return z - matvec(self.tables.inverse, pull)
        for j in sorted(range(work.size), key=lambda j: work.slot[j]):
            signed = dual[j] if work.side[j] > 0 else -dual[j]
            z = z - work.vectors[work.slot[j]] * signed
        return z

    def append(self, row: int, side: int, forced: bool = False) -> bool:
        """Extend the factor by a row; False, and the set as it was, where it depends on it.

        Row q of L then holds L^-1 times its products with the others, over D.
        """
        work, q, rows = self.work, self.work.size, self.tables.rows
        own = rows.row(row)
        part = slice(rows.begin(row), own.size)
        vector = matvec(self.tables.inverse[part], own[part])
        pivot = self.square = dot(own[part], vector[part])
        under = work.factor[q]
        for j in range(q):
            product = rows.dot(work.row[j], vector)
            total = product if side == work.side[j] else -product
            for k in range(j):
                total = total - work.factor[j, k] * under[k]
            under[j] = self.within(total)
        for j in range(q):
            scaled = self.within(under[j] * work.pivots[j])
            pivot = pivot - scaled * under[j]
            under[j] = scaled
        self.left = min(max(pivot, self.tables.rounding * self.square), self.tables.large)
        least = self.tables.rounding if forced else self.tables.dependent
        if q == self.free.size or not pivot > least * self.square:
            return False
        real = self.tables.inverse.dtype.type
        work.pivots[q] = real(1.0) / min(max(pivot, self.tables.small), self.tables.large)
        work.square[q] = self.square
        work.vectors[work.slot[q]] = vector
        work.row[q], work.side[q], work.dual[q] = row, side, self.zero
        work.size = q + 1
        return True

    def remove(self, p: int) -> None:
        """Take row p out: L D L' of the rest by a rank-one update of what stood below it."""
        work, q = self.work, self.work.size
        real = self.tables.inverse.dtype.type
        below = work.factor[:, p].copy()
        weight = real(1.0) / max(work.pivots[p], self.tables.small)
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
            old = real(1.0) / max(work.pivots[j + 1], self.tables.small)
            mine = self.within(below[j])
            part = weight * mine
            new = min(max(old + part * mine, self.tables.small), self.tables.large)
            inverse = real(1.0) / new
            share = self.within(part * inverse)
            weight = self.from_zero((old * weight) * inverse)
            work.pivots[j] = inverse
            for i in range(j + 1, q - 1):
                below[i] = below[i] - mine * work.factor[i, j]
                work.factor[i, j] = self.within(work.factor[i, j] + share * below[i])
        work.size = q - 1
