"""What the dual active-set method decides, as affine functions of a program's parameter.

From a cold start the multipliers move along e(theta) times a constant vector c, e being what the
row that entered misses; the first of them to vanish is the one with the least lambda_j / |c_j|,
after which e' = e - lambda_p / |c_p|. With the rows of the last call's set the multipliers begin at
zero, so that the first negative one is dropped and no step is made. A row that depends on the set
moves the multipliers along a constant vector of its own. So every multiplier, every row at z and
every comparison of ``qp.dual_active_set`` is affine in theta, and the parameters for which the
method goes one way are a polyhedron.

A row and its side are one number here: 2 i for the upper side of row i, 2 i + 1 for the lower one,
which is also the order in which equal violations are taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from servogen.explicit.iteration_conditions import Conditions, comparisons, snapped
from servogen.explicit.iteration_program import IterationProgram
from servogen.explicit.tolerances import CANCELLED, NOT_EMPTY, VIOLATION_SEEN
from servogen.plants.statespace import FloatArray

Sides = tuple[int, ...]
Ending = Literal["optimal", "infeasible", "unending"]


@dataclass(frozen=True)
class Start:
    """What a call begins with: the rows of its set, in order, and whether they were kept with
    their factor rather than shifted by one sample."""

    sides: Sides = ()
    kept: bool = False


@dataclass(frozen=True)
class Place:
    """Where the method stands within a call; affine functions are on (t, 1), (p + 1,) each.

    Attributes:
        stage: what it does next: ``warm`` and ``step`` compute lambda*, of the last call's rows or
            after a row has entered; ``look`` finds the most violated row; ``enter`` appends
            ``entering``; ``room`` drops a row where that depends on the set; ``end``.
        sides: the working set.
        dual: (q, p + 1) its multipliers. size: (q,) of the terms that they are sums of.
        excess: what the row misses that entered last, or ``entering``. raised: its multiplier.
        iterations: so far.
        kept: a kept set's first iteration. violated: some row is, at the optimum without rows.
        forced: ``entering`` is appended though it depends nearly. ending: how the call ended.
    """

    stage: Literal["warm", "step", "look", "enter", "room", "end"]
    sides: Sides
    dual: FloatArray
    size: FloatArray
    excess: FloatArray
    raised: FloatArray
    iterations: int = 0
    entering: int = -1
    kept: bool = False
    violated: bool = False
    forced: bool = False
    ending: Ending = "optimal"

    @staticmethod
    def nowhere() -> Place:
        """Before a call."""
        nothing = np.zeros(0)
        return Place("end", (), nothing, nothing, nothing, nothing)


@dataclass(frozen=True)
class Way:
    """One way on: ``rows`` (r, p) t <= ``bounds`` (r,), rows of unit length, and where it leads."""

    place: Place
    rows: FloatArray
    bounds: FloatArray


class Paths:
    """The method on a program, in parameters t of a unit box: theta = middle + half t."""

    def __init__(self, program: IterationProgram) -> None:
        low, high = program.box()
        self.middle, self.half = 0.5 * (low + high), 0.5 * (high - low)
        self.tables, self._rows = program.tables, program.tables.rows
        rows, inverse = program.rows(), program.tables.inverse.astype(np.float64)
        products = rows @ inverse @ rows.T
        products = 0.5 * (products + products.T)
        sign = np.tile([1.0, -1.0], rows.shape[0])
        self._products = np.repeat(np.repeat(products, 2, axis=0), 2, axis=1)
        self._products = self._products * np.outer(sign, sign)
        self._norm = np.repeat(program.tables.norm.astype(np.float64), 2)
        self._variables = rows.shape[1]
        at_free, m = program.rows_at_free(), rows.shape[0]
        finite = np.zeros(2 * m, dtype=bool)
        self.excess = np.zeros((2 * m, program.parameters + 1))
        for side, bound in ((0, program.high), (1, program.low)):
            there = np.isfinite(bound[:, -1])
            finite[side::2] = there
            difference = sign[side] * (at_free - np.where(there[:, None], bound, 0.0))
            self.excess[side::2] = self._scaled(difference)
        self.sides = np.flatnonzero(finite)
        self._size = np.max(np.abs(self._scaled(np.repeat(at_free, 2, axis=0))), axis=1)
        self._size = np.maximum(self._size, np.max(np.abs(self.excess), axis=1))
        self._zero = np.zeros(program.parameters + 1)
        self._solved: dict[Sides, FloatArray] = {}
        normal = program.domain_rows * self.half
        length = np.sqrt(np.sum(normal**2, axis=1))
        length = np.where(length > 0.0, length, 1.0)
        self.domain = normal / length[:, None]
        self.domain_bounds = (
            program.domain_bounds - program.domain_rows @ self.middle
        ) / length  # fmt: skip

    def _scaled(self, on_theta: FloatArray) -> FloatArray:
        """On (t, 1) what was on (theta, 1)."""
        constant = on_theta[:, :-1] @ self.middle + on_theta[:, -1]
        return np.column_stack([on_theta[:, :-1] * self.half, constant])

    def theta(self, t: FloatArray) -> FloatArray:
        """(p,) in the program's own units."""
        return np.asarray(self.middle + self.half * t)

    def least_accept(self) -> float:
        """The least ``accept`` that the pieces can tell from nothing: a violation by it is so far
        in the unit box, for the row that moves fastest there."""
        slope = np.sqrt(np.sum(self.excess[self.sides, :-1] ** 2, axis=1))
        return float(VIOLATION_SEEN * NOT_EMPTY * slope.max(initial=0.0))

    def next_start(self, sides: Sides) -> Start:
        """What the next call begins with after one that left this set."""
        if len(sides) >= self.tables.keep:
            return Start(sides, kept=True)
        moved: Sides = ()
        for side in sides:
            row = self._rows.shifted(side // 2)
            if row >= 0 and self._split(moved, 2 * row + side % 2)[1]:
                moved = (*moved, 2 * row + side % 2)
        return Start(moved)

    def begin(self, start: Start) -> list[Way]:
        """The ways into a call: none needed at all, where that is asked first, and the method."""
        violated = not start.kept
        place = self._place("warm", start.sides, start.kept, violated)
        everywhere = Way(place, np.zeros((0, self._zero.size - 1)), np.zeros(0))
        return [everywhere] if start.kept else [everywhere, *self._none_needed(0, Conditions())]

    def violations(self) -> tuple[FloatArray, FloatArray]:
        """Rows (2m, p) and bounds of what it is that a side is violated at the optimum without
        rows, one polyhedron each; a row of zeros is a side that is violated everywhere."""
        excess = self.excess[self.sides]
        length = np.sqrt(np.sum(excess[:, :-1] ** 2, axis=1))
        beyond = excess[:, -1] - float(self.tables.accept)
        there = length > CANCELLED * self._size[self.sides]
        always = ~there & (beyond > 0.0)
        length[always] = 1.0
        rows = np.where(always[:, None], 0.0, -excess[:, :-1])[there | always]
        length, beyond = length[there | always], beyond[there | always]
        return rows / length[:, None], beyond / length

    def onward(self, place: Place) -> list[Way]:
        """Every way on from a place, whether or not any parameter of its piece takes it."""
        match place.stage:
            case "warm":
                return self._warm(place)
            case "step":
                return self._step(place)
            case "look":
                return self._look(place)
            case "room":
                return self._make_room(place)
        return []

    def _place(
        self, stage: Literal["warm", "look"], sides: Sides, kept: bool, violated: bool
    ) -> Place:
        q, zero = len(sides), self._zero
        place = Place(stage, sides, np.zeros((q, zero.size)), np.zeros(q), zero, zero)
        return _with(place, kept=kept, violated=violated)

    def _warm(self, place: Place) -> list[Way]:
        """With multipliers of zero the first negative lambda* is dropped; nothing moves."""
        sides, q, count = list(place.sides), len(place.sides), place.iterations + 1
        missed = self.excess[sides]
        inverse = self._inverse(place.sides)
        star = inverse @ missed
        size = np.abs(inverse) @ self._size[sides]
        ways: list[Way] = []
        for p in range(q):
            conditions = Conditions()
            conditions.add(star[p : p + 1], size[p : p + 1], True)
            conditions.add(-star[:p], size[:p], False)
            rest = place.sides[:p] + place.sides[p + 1 :]
            if place.kept:
                ways += self._none_needed(count, conditions)
            after = self._place("warm", rest, False, place.violated or place.kept)
            ways += _way(_with(after, iterations=count), conditions)
        conditions = Conditions()
        conditions.add(-star, size, False)
        after = _with(place, stage="look", dual=star, size=size, iterations=count, kept=False)
        return ways + _way(after, conditions)

    def _none_needed(self, count: int, also: Conditions) -> list[Way]:
        """The optimum without rows keeps them all."""
        conditions = Conditions(list(also.functions), list(also.sizes), list(also.strict))
        excess = self.excess[self.sides].copy()
        excess[:, -1] -= float(self.tables.accept)
        conditions.add(excess, self._size[self.sides], False)
        place = _with(self._place("look", (), False, False), stage="end", iterations=count)
        return _way(place, conditions)

    def _step(self, place: Place) -> list[Way]:
        """Towards lambda* after a row has entered, up to the first multiplier that vanishes."""
        q, count = len(place.sides), place.iterations + 1
        c = self._inverse(place.sides)[:, q - 1]
        falling = np.flatnonzero(c[: q - 1] < 0.0)
        ratio = place.dual[falling] / -c[falling, None]
        size = place.size[falling] / -c[falling]
        excess_size = np.abs(place.excess).max(initial=0.0)
        ways: list[Way] = []
        for i, p in enumerate(falling):
            conditions = Conditions()
            conditions.add((ratio[i] - place.excess)[None], np.array([size[i] + excess_size]), True)
            others = np.arange(falling.size) != i
            conditions.add(ratio[i] - ratio[others], size[i] + size[others], falling[others] < p)
            moved = place.dual + c[:, None] * ratio[i]
            grown = np.maximum(place.size, np.abs(c) * size[i])
            excess = snapped((place.excess - ratio[i])[None], np.array([excess_size + size[i]]))[0]
            after = self._without(place, int(p), moved, grown)
            ways += _way(_with(after, excess=excess, iterations=count), conditions)
        conditions = Conditions()
        whole = place.dual + c[:, None] * place.excess
        grown = np.maximum(place.size, np.abs(c) * excess_size)
        conditions.add(place.excess - ratio, size + excess_size, False)
        conditions.add(-place.excess[None], np.array([excess_size]), False)
        dual = snapped(whole, grown)
        after = _with(place, stage="look", dual=dual, size=grown, iterations=count)
        return ways + _way(after, conditions)

    def _look(self, place: Place) -> list[Way]:
        """The most violated row, or none."""
        sides = list(place.sides)
        accept = float(self.tables.accept)
        on_dual = self._products[:, sides]
        excess = self.excess - on_dual @ place.dual
        size = self._size + np.abs(on_dual) @ place.size
        others = np.setdiff1d(self.sides, sides)
        beyond = excess[others].copy()
        beyond[:, -1] -= accept
        ways: list[Way] = []
        if sides or not place.violated:
            conditions = Conditions()
            conditions.add(beyond, size[others], False)
            ways += _way(_with(place, stage="end"), conditions)
        rows, bounds, constant, possible = comparisons(excess[others], beyond, size[others])
        for i in np.flatnonzero(possible):
            side, whole = int(others[i]), ~constant[i]
            after = _with(place, stage="enter", entering=side, excess=excess[side])
            if any(other // 2 == side // 2 for other in sides):
                # its bounds have changed places: no z keeps both
                after = _with(place, stage="end", ending="infeasible")
            ways.append(Way(after, rows[i, whole], bounds[i, whole]))
        return ways

    def entered(self, place: Place) -> Place:
        """Append the entering row, or see that it depends on the set; elsewhere nothing."""
        if place.stage != "enter":
            return place
        if not self._split(place.sides, place.entering, place.forced)[1]:
            return _with(place, stage="room")
        size = np.append(place.size, np.abs(place.raised).max(initial=0.0))
        dual = np.vstack([place.dual, place.raised])
        sides = (*place.sides, place.entering)
        return _with(
            place, stage="step", sides=sides, dual=dual, size=size, entering=-1, raised=self._zero,
            forced=False,
        )  # fmt: skip

    def _make_room(self, place: Place) -> list[Way]:
        """Along the combination of the set's rows that the entering one is."""
        share = self._split(place.sides, place.entering)[0]
        own = float(self.tables.falls) * self._norm[place.entering]
        falling = np.flatnonzero(share * self._norm[list(place.sides)] > own)
        if not falling.size:
            nothing = np.zeros((0, self._zero.size - 1))
            after = _with(place, stage="end", ending="infeasible")
            if self._split(place.sides, place.entering, True)[1]:
                after = _with(place, stage="enter", forced=True, iterations=place.iterations + 1)
            return [Way(after, nothing, np.zeros(0))]
        ratio = place.dual[falling] / share[falling, None]
        size = place.size[falling] / share[falling]
        ways: list[Way] = []
        for i, p in enumerate(falling):
            others = np.arange(falling.size) != i
            conditions = Conditions()
            conditions.add(np.zeros((1, self._zero.size)), np.ones(1), False)
            conditions.add(ratio[i] - ratio[others], size[i] + size[others], falling[others] < p)
            moved = place.dual - share[:, None] * ratio[i]
            grown = np.maximum(place.size, np.abs(share) * size[i])
            after = self._without(place, int(p), moved, grown)
            raised = place.raised + ratio[i]  # the next iteration tries again
            count = place.iterations + 1
            again = _with(after, stage="enter", raised=raised, iterations=count)
            ways += _way(again, conditions)
        return ways

    def _without(self, place: Place, p: int, dual: FloatArray, size: FloatArray) -> Place:
        dual = snapped(np.delete(dual, p, axis=0), np.delete(size, p))
        sides = place.sides[:p] + place.sides[p + 1 :]
        return _with(place, sides=sides, dual=dual, size=np.delete(size, p))

    def _inverse(self, sides: Sides) -> FloatArray:
        """(q, q) of the products of the set's rows."""
        found = self._solved.get(sides)
        if found is None:
            if len(self._solved) > 20_000:
                self._solved.clear()
            own = list(sides)
            found = np.asarray(np.linalg.inv(self._products[np.ix_(own, own)]), dtype=np.float64)
            self._solved[sides] = found
        return found

    def _split(self, sides: Sides, side: int, forced: bool = False) -> tuple[FloatArray, bool]:
        """A row as a combination of the set's, (q,), and whether enough of it is left over."""
        own = list(sides)
        with_set = self._products[own, side]
        share: FloatArray = self._inverse(sides) @ with_set
        pivot = self._products[side, side] - float(share @ with_set)
        least = float(self.tables.rounding if forced else self.tables.dependent)
        least *= self._norm[side] ** 2
        return share, len(sides) < self._variables and pivot > least


def _with(place: Place, **changes: object) -> Place:
    """``dataclasses.replace`` without its detours: there are millions of places."""
    made = object.__new__(Place)
    made.__dict__.update(place.__dict__)
    made.__dict__.update(changes)
    return made


def _way(place: Place, conditions: Conditions) -> list[Way]:
    found = conditions.polyhedron()
    return [] if found is None else [Way(place, *found)]
