"""The taut string through a tube, step by step in Python: the reference of ``c_runtime/sg_taut.h``.

The funnel of computational geometry, on points whose abscissae are their places 0, 1, 2, ...: two
chains lead from the apex, up to where the string is known, to the points that were looked at last.
The upper chain is the greatest convex line below the upper bounds, the lower chain the least
concave line above the lower bounds. A new bound takes from the end of its own chain what it makes
slack; if nothing of it is left and the bound lies beyond the other chain's first piece, the string
must bend there, and the apex moves on. A bound enters its chain once and leaves it once: O(n),
whatever the path.

Numerics. Slopes are compared crosswise, (b - a)(k - i) against (c - a)(j - i): a difference of two
floating-point numbers carries one rounding however far from zero both lie, places are exact, so
neither side is off by more than two roundings of itself and nothing is gained by shifting or
scaling the coordinates first. A comparison errs only between slopes that agree to three roundings
u = 2^-53; a chain of n points that are in one line but for rounding may then sag by 3 n u of its
rise, 3e-9 of it for 10^7 points, at the very worst. Whatever was decided, every point is put back
between its bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

Scalar = Any  # float, or numpy.float32: computes like the C type

START = -1  # place of the start: one point before the first


@dataclass(frozen=True)
class Knots:
    """Where the string may bend, straight between.

    Attributes:
        places: from ``START`` on, ascending; the last is not before the last point asked for.
        heights: the string there.
        seen: the point that had to be looked at before a knot was known; 0 for the start.
        decided: how many of ``places`` no further point can change, the start included.
    """

    places: list[int]
    heights: list[Scalar]
    seen: list[int]
    decided: int

    @property
    def look_ahead(self) -> int:
        """The most points ahead of a point that had to be seen to place it."""
        pairs = zip(self.places[:-1], self.seen[1:], strict=True)
        ahead = (seen - (before + 1) for before, seen in pairs)
        return max(ahead, default=0)


class _Funnel:
    """The two chains, upper first, and the knots found so far."""

    def __init__(self, lower: Sequence[Scalar], upper: Sequence[Scalar], start: Scalar) -> None:
        self.bounds = (upper, lower)
        self.chains: tuple[list[int], list[int]] = ([], [])
        self.heads = [0, 0]
        self.apex, self.height = START, start
        self.places, self.heights, self.seen = [START], [start], [0]

    def move(self, place: int, height: Scalar, seen: int) -> None:
        """Move the apex."""
        self.apex, self.height = place, height
        self.places.append(place)
        self.heights.append(height)
        self.seen.append(seen)

    def change(self, side: int, point: int) -> bool:
        """One change for a bound of a point; whether the bound has entered its chain with it."""
        own, other = self.bounds[side], self.bounds[1 - side]
        chain, across = self.chains[side], self.chains[1 - side]
        head, head_across = self.heads[side], self.heads[1 - side]
        if head < len(chain):
            last, base, origin = chain[-1], self.apex, self.height
            if len(chain) - head > 1:
                base = chain[-2]
                origin = own[base]
            to_last = (own[last] - origin) * (point - base)
            to_here = (own[point] - origin) * (last - base)
            if to_last <= to_here if side else to_last >= to_here:
                chain.pop()
                return False
        elif head_across < len(across):
            first = across[head_across]
            to_first = (other[first] - self.height) * (point - self.apex)
            to_here = (own[point] - self.height) * (first - self.apex)
            if to_first < to_here if side else to_first > to_here:
                self.heads[1 - side] += 1
                self.move(first, other[first], point)
                return False
        chain.append(point)
        return True

    def leads(self, side: int) -> bool:
        """Whether a chain leads from the apex away: down for the upper, up for the lower."""
        if self.heads[side] >= len(self.chains[side]):
            return False
        height = self.bounds[side][self.chains[side][self.heads[side]]]
        return bool(height > self.height if side else height < self.height)

    def close(self, last: int, seen: int) -> None:
        """The bounds end: along the chain that leads away until it turns back, then level."""
        side = next((side for side in (0, 1) if self.leads(side)), None)
        while side is not None and self.apex < last and self.leads(side):
            place = self.chains[side][self.heads[side]]
            self.heads[side] += 1
            self.move(place, self.bounds[side][place], seen)
        if self.apex < last:
            self.move(last, self.height, seen)


def taut_string(
    lower: Sequence[Scalar], upper: Sequence[Scalar], start: Scalar, needed: int | None = None
) -> Knots:
    """The taut string from ``start`` to a level end, as far as the first ``needed`` points.

    Args:
        lower, upper: bounds of every point, lower[k] <= upper[k], finite, all of one scalar type.
        start: the string one point before the first.
        needed: points to place; the rest is looked at no further than that takes. All by default.
    """
    size = len(lower)
    last = (size if needed is None else needed) - 1
    funnel = _Funnel(lower, upper, start)
    point, side = 0, 0
    while point < size and funnel.apex < last:
        if funnel.change(side, point):
            point, side = point + side, 1 - side
    decided = len(funnel.places)
    funnel.close(last, size - 1)
    return Knots(funnel.places, funnel.heights, funnel.seen, decided)


def heights_along(
    knots: Knots,
    lower: Sequence[Scalar],
    upper: Sequence[Scalar],
    needed: int,
    real: Callable[[Any], Scalar] = float,
) -> list[Scalar]:
    """The string at points 0 to needed - 1: straight between knots, never beyond the tube."""
    heights: list[Scalar] = []
    knot, slope = 0, real(0.0)
    for i in range(needed):
        if knot == 0 or i > knots.places[knot]:
            knot += 1
            begin, end = knots.heights[knot - 1], knots.heights[knot]
            slope = (end - begin) / real(knots.places[knot] - knots.places[knot - 1])
        between = knots.heights[knot - 1] + slope * real(i - knots.places[knot - 1])
        height = knots.heights[knot] if i == knots.places[knot] else between
        low, high = lower[i], upper[i]
        height = height if height > low else low
        heights.append(height if height < high else high)
    return heights
