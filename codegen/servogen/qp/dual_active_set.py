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
what the cap is for. A call that ended at the cap can be gone on with by the next one, if that is of
the same program: from the state of the iteration, with the same steps as without the cap. Of
another one this is a beginning like any other: multipliers that are not negative, and rows that are
measured before any point is an answer.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.active_set_factor import WorkingSet, append, back, forward, remove
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.qp.ordered import matvec


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
    resume: bool = False,
) -> ActiveSetResult:
    """The optimum from the unconstrained one, ``free`` (N,), with ``low``, ``high`` (m,).

    All in the tables' precision; ``work`` is the last call's and is left for the next one.

    Args:
        start: state (n,) in which the plant behind the rows starts; None: at rest.
        resume: go on from where the last call ended at its cap.
    """
    method = _Method(tables, work, free, low, high, start)
    kept = work.size >= tables.keep
    if not kept and method.worst(method.free_rows) is None:
        work.size = 0
        return ActiveSetResult(free, True, False, 0)
    if resume:
        method.resume()
    else:
        method.begin(kept)
    return method.run(kept and not resume, resume)


class _Method:
    """One call."""

    def __init__(
        self, tables: ActiveSetTables, work: WorkingSet, free: FloatArray, low: FloatArray,
        high: FloatArray, start: FloatArray | None,
    ) -> None:  # fmt: skip
        self.tables, self.work, self.start = tables, work, start
        self.free, self.low, self.high = free, low, high
        self.free_rows = tables.rows.product(free, start)
        self.z, self.rows = free, self.free_rows
        self.real = tables.inverse.dtype.type
        self.zero, self.one = self.real(0.0), self.real(1.0)
        self.missed = work.missed

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
                    append(self.tables, work, moved, side)
        work.dual[: work.size] = self.zero
        self.missed[:] = self.zero
        self.measure(self.free_rows)

    def resume(self) -> None:
        """The point of the last call's multipliers; a refinement begins with what is missed there,
        as it would have."""
        self.z = self.less(self.free, self.work.dual)
        self.rows = self.tables.rows.product(self.z, self.start)
        if self.work.refining:
            self.measure(self.rows)

    def run(self, kept: bool, resume: bool) -> ActiveSetResult:
        """Iterate until the optimum, a row that nothing makes room for, or the cap."""
        work, z, rows = self.work, self.z, self.rows
        entering: tuple[int, int] | None = None
        raised = excess = self.zero
        refining = forced = stalled = False
        if resume:
            refining, forced, stalled = work.refining, work.forced, work.stalled
            if work.pending:
                q = work.size
                entering = (work.row[q], work.side[q])
                raised, excess = work.dual[q], self.missed[q]
        work.refining = work.forced = work.stalled = work.pending = False
        for iteration in range(1, self.tables.cap + 1):
            if entering is None:
                step = self.step()
                star = work.dual[: work.size] + step
                if self.blocked(star):
                    # a set that was kept is not the right one: perhaps none is needed
                    if kept and self.worst(self.free_rows) is None:
                        work.size = 0
                        return ActiveSetResult(self.free, True, False, iteration)
                    kept = refining = stalled = False
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
                        refining = stalled = True
                        continue
                    active = tuple(work.row[: work.size])
                    return ActiveSetResult(z, True, False, iteration, active)
                self.missed[:] = self.zero
                if entering[0] in work.row[: work.size]:
                    if self.low[entering[0]] > self.high[entering[0]]:
                        work.forget()
                        return ActiveSetResult(z, False, True, iteration)
                    self.measure(rows)  # what rounding left: the next step takes it away
                    entering, refining, stalled = None, not refining, True
                    continue
                refining = stalled = False
                raised, excess = self.zero, self.excess(rows, *entering)
            appended = append(self.tables, work, *entering, forced)
            if appended.done:
                work.dual[work.size - 1] = raised
                self.missed[work.size - 1] = excess
                entering, forced = None, False
                continue
            gained = self.make_room(appended.square)
            if gained is None:
                if work.size < z.size and appended.left > self.tables.rounding * appended.square:
                    forced = True
                    continue
                beyond = self.no_point(excess, appended.left, rows)
                work.forget()  # rows that contradict are no beginning for another program
                return ActiveSetResult(z, False, beyond, iteration)
            raised = self.from_zero(raised + gained)
        if self.tables.resumes:
            self.leave(entering, raised, excess)
            work.refining, work.forced, work.stalled = refining, forced, stalled
        elif stalled:  # nor are rows that rounding does not let hold
            work.forget()
        return ActiveSetResult(z, False, False, self.tables.cap)

    def leave(
        self, entering: tuple[int, int] | None, raised: np.floating, excess: np.floating
    ) -> None:
        """The row that is to enter, to the place after the set's, which is not full: a row has made
        room, or there was some."""
        work, q = self.work, self.work.size
        work.pending = entering is not None
        if entering is not None:
            work.row[q], work.side[q] = entering
            work.dual[q], self.missed[q] = raised, excess

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
        step = self.missed[:q].copy()
        forward(self.tables, work, step)
        step = step * work.pivots[:q]
        back(self.tables, work, step)
        return step

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

    def make_room(self, square: np.floating) -> np.floating | None:
        """Raise the multiplier of the dependent row until one of the set vanishes and leaves; by
        how much, or None where none falls."""
        work, q = self.work, self.work.size
        share = work.factor[q, :q].copy()
        own = (self.tables.falls * self.tables.falls) * square
        back(self.tables, work, share)
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

    def no_point(self, excess: np.floating, left: np.floating, rows: FloatArray) -> bool:
        """Whether a row that cannot be kept is beyond doubt.

        What the set leaves of it is rounding, or counts as that: points that keep all rows are at
        least excess / sqrt(left) away, in the metric of H. That is far where it is more than the
        reach many times over: of the rows at z, and of the moves V lambda, of which z is what
        rounding has left; z_unc is no farther than all of these together. What has come near
        ``large`` may have met it, and leaves doubt.
        """
        work, large = self.work, self.tables.large
        greatest = min(np.max(np.abs(rows)), large)
        reach = greatest * greatest
        for dual, square in zip(work.dual[: work.size], work.square, strict=False):
            greatest = max(greatest, dual)
            reach = max(reach, (dual * dual) * square)
        reach = self.tables.doubt * min(reach, large * large)
        most = min(max(excess, self.zero), large)
        return bool(greatest < self.real(0.5) * large and most * most > reach * left)

    def drop(self, p: int) -> None:
        """Take row p out of the set, and what it misses."""
        q = self.work.size
        self.missed[p : q - 1] = self.missed[p + 1 : q].copy()
        remove(self.tables, self.work, p)

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
