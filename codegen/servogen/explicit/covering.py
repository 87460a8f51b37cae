"""That regions leave nothing of the feasible parameters out: facet by facet.

Let every facet of every region either bound the feasible set, or be covered from beyond by other
regions. Join a ball of a region with a ball of feasible parameters that are in none by parallel
segments. All of them run in the feasible set, which is convex, and each leaves the regions for the
last time: through a facet, at a point that no region covers from beyond. If that is impossible for
all points of facets but a few strips, those have to catch every segment; so the smaller ball has no
larger cross-section than the strips, and what is missing is known to be small (``hole``). All
this within ``FAR`` of the origin, beyond which the digits of rows no longer tell planes apart: how
far apart two planes are that are taken as one is measured there. Between them is a slab that no
region need cover, with sides that segments may leave through: they are added to the strips.
Nothing of the way the regions were found is used; that they do not overlap neither, the optimum
being unique.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import gamma, pi, sqrt

import numpy as np

from servogen.explicit.cover import Facet
from servogen.explicit.facet_parts import (
    ball_of,
    common_part,
    facet_balls,
    facet_on,
    facet_tops,
    gap_behind,
    padded_balls,
    region_balls,
    same_rows,
    trace,
    without,
)
from servogen.explicit.regions import Region
from servogen.explicit.restated import Restated
from servogen.explicit.tolerances import END_SHARE, FAR, FLAT, REDUNDANT, SAME_PLANE, SLIVER
from servogen.plants.statespace import FloatArray
from servogen.progress import Task
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise

# Linear programs of different facets that are solved together.
_CHUNK = 256
# Pieces of one facet: neighbours that fit leave two or three; beyond this nothing fits.
MOST_PIECES = 100
# Regions whose facets are set up together.
_REGIONS = 32


@dataclass(frozen=True)
class Cover:
    """What was found of all facets.

    Attributes:
        facets: looked at; shared: covered from beyond by regions; ends: bound the feasible set.
        open: radius of each piece beyond which there is neither, wider than ``SLIVER``.
        slivers: radii of the narrower ones.
        hole: radius of the largest ball that may be missing between the regions, by all that was
            passed over as too narrow; inf if there is an open piece.
        largest: radius of the largest ball in a region (at most one), 0 without a full region.
        where: middle of the first open piece.
    """

    facets: int
    shared: int
    ends: int
    open: tuple[float, ...]
    slivers: tuple[float, ...]
    hole: float
    largest: float
    where: str


def prove_cover(own: Restated, regions: Sequence[Region], task: Task) -> Cover:
    """Every facet of every region; their rows alone are used."""
    if not regions:
        return Cover(0, 0, 0, (np.inf,), (), np.inf, 0.0, "no region")
    proof = _Proof(own, regions)
    for start in range(0, len(regions), _REGIONS):
        chosen = range(start, min(start + _REGIONS, len(regions)))
        proof.look_at(chosen)
        task.advance(len(chosen))
    proof.settle()
    return proof.result()


@dataclass
class _End:
    """The greatest height of a feasible parameter along ``normal``, and by how much some of them
    may lie beyond the facets that were found to be there."""

    normal: FloatArray
    top: float
    beyond: float = 0.0

    def meet(self, facet: Facet) -> None:
        """One more such facet."""
        turned = float(np.linalg.norm(facet.normal - self.normal))
        height = float(facet.normal @ facet.foot)
        self.beyond = max(self.beyond, self.top - height + turned * FAR)


class _Proof:
    def __init__(self, own: Restated, regions: Sequence[Region]) -> None:
        self.own, self.regions = own, regions
        self.balls = region_balls(own, regions)
        self.full = np.array([ball.radius > FLAT for ball in self.balls])
        self.h = np.vstack([region.h for region in regions])
        self.k = np.concatenate([region.k for region in regions])
        self.region_of = np.repeat(np.arange(len(regions)), [r.k.size for r in regions])
        self.limits = own.feasible_rows()
        self.ends: dict[tuple[float, ...], _End] = {}
        self.pending: list[tuple[Facet, int, FloatArray, FloatArray]] = []
        self.count = self.shared = self.ended = 0
        self.open: list[float] = []
        self.slivers: list[float] = []
        self.passed_over = 0.0  # radii of flat pieces
        self.strips = self.slabs = 0.0  # widths
        self.used: list[Region] = []  # behind the facet that is being cut
        self.where = ""

    def look_at(self, chosen: Sequence[int]) -> None:
        """All facets of some regions: to be settled by one neighbour's rows, or cut by several. A
        flat region is none: nothing is covered by it, nothing leaves through it."""
        places = [(i, row) for i in chosen if self.full[i] for row in range(self.regions[i].k.size)]
        facets = [facet_on(self.regions[i], self.own, j) for i, j in places]
        for (i, row), facet, ball in zip(places, facets, facet_balls(facets), strict=True):
            if ball.radius <= FLAT:  # the row touches less than a facet
                self.passed_over += FLAT
                continue
            self.count += 1
            behind = self._behind(i, row)
            if len(behind) > 1:
                behind = self._touching([facet], behind)
            if len(behind) == 1:
                neighbour = self.regions[behind[0]]
                self.pending.append((facet, behind[0], *trace(facet, neighbour)))
                self._add_gap(facet, [neighbour])
            else:
                self._cut(facet, behind)

    def settle(self) -> None:
        """Facets with a single neighbour: whether each row of that one keeps the whole facet."""
        work: list[tuple[int, FloatArray, float]] = []
        fails: dict[int, bool] = {}
        for i, (facet, _, rows, bounds) in enumerate(self.pending):
            same, looser = same_rows(facet, rows, bounds)
            self.strips += looser
            work += [(i, rows[j], float(bounds[j])) for j in np.flatnonzero(~same)]
        for start in range(0, len(work), _CHUNK):
            chunk = work[start : start + _CHUNK]
            tops = facet_tops([self.pending[i][0] for i, _, _ in chunk], chunk)
            for (i, _, bound), top in zip(chunk, tops, strict=True):
                fails[i] = fails.get(i, False) or top > bound + REDUNDANT
                self.strips += max(0.0, min(top - bound, REDUNDANT))
        for i, (facet, neighbour, _, _) in enumerate(self.pending):
            if fails.get(i, False):
                self._cut(facet, [neighbour])
            else:
                self.shared += 1

    def result(self) -> Cover:
        d = self.own.coordinates - 1
        slabs = self.slabs + sum(end.beyond for end in self.ends.values())
        hole = largest_missed(d, self.passed_over + sum(self.slivers), self.strips, slabs)
        largest = max(ball.radius for ball in self.balls)
        if self.open or largest <= max(hole, FLAT):
            hole = float("inf")
        return Cover(
            self.count, self.shared, self.ended, tuple(self.open), tuple(self.slivers), hole,
            max(largest, 0.0), self.where,
        )  # fmt: skip

    def _add_gap(self, facet: Facet, behind: list[Region]) -> None:
        slab, sides = gap_behind(facet, behind)
        self.slabs += slab
        self.strips += sides

    def _behind(self, index: int, row: int) -> list[int]:
        """Regions with a facet on the same plane, seen from the other side."""
        normal, height = self.regions[index].h[row], float(self.regions[index].k[row])
        on_plane = np.abs(self.k + height) <= SAME_PLANE * (1.0 + abs(height))
        some = np.flatnonzero(on_plane)
        near = np.max(np.abs(self.h[some] + normal), axis=1, initial=0.0) <= SAME_PLANE
        found = np.unique(self.region_of[some[near]])
        return [int(i) for i in found if i != index and self.full[i]]

    def _cut(self, facet: Facet, neighbours: list[int]) -> None:
        """What ``neighbours`` leave of a facet, then what any other region does, must bound the
        feasible set or be a sliver."""
        self.used = []
        left = self._less([facet], neighbours)
        if left and not self._is_end(facet):
            left = self._less(left, self._crossing(facet, neighbours))
        self._add_gap(facet, self.used)
        if not left:
            self.shared += 1
        elif self._is_end(facet):
            self.ended += 1
            self.ends[_key(facet)].meet(facet)
        else:
            self._tell(left)

    def _less(self, pieces: list[Facet], neighbours: list[int]) -> list[Facet]:
        """The pieces of a facet without what lies in regions behind it."""
        for i in self._touching(pieces, neighbours):
            left, cut = [], False
            for piece in pieces:
                parts, flat = without(piece, self.regions[i])
                self.passed_over += flat
                left += parts
                cut |= len(parts) != 1 or parts[0] is not piece
            if cut:
                self.used.append(self.regions[i])
            pieces = left
            if len(pieces) > MOST_PIECES:
                break  # what is left counts as open
        return pieces

    def _touching(self, pieces: list[Facet], neighbours: list[int]) -> list[int]:
        """Those with more than a flat part of the pieces, the largest first."""
        if not pieces or not neighbours or not pieces[0].basis.shape[1]:
            return neighbours
        widest = np.zeros(len(neighbours))
        for piece in pieces:
            shared = [common_part(piece, *trace(piece, self.regions[i])) for i in neighbours]
            widest = np.maximum(widest, [ball.radius for ball in facet_balls(shared)])
        order = np.argsort(-widest, kind="stable")
        return [neighbours[i] for i in order if widest[i] > FLAT]

    def _crossing(self, facet: Facet, known: list[int]) -> list[int]:
        """Regions that a facet's plane runs through: they overlap with its own, where dependent
        rows let several active sets be optimal. They cover what they have of the plane, if part of
        them lies beyond."""
        height = float(facet.normal @ facet.foot)
        asked = [i for i in range(len(self.regions)) if self.full[i] and i not in known]
        sides = np.vstack([facet.normal, -facet.normal])
        found = asked
        # beyond the plane, then on it
        for bounds in ((height + 1.0, -height), (height + FLAT, -height + FLAT)):
            sets = [
                (np.vstack([self.regions[i].h, sides]), np.append(self.regions[i].k, bounds))
                for i in found
            ]
            balls = padded_balls(sets, shown=True)
            least = FLAT if bounds[0] > height + FLAT else 0.0
            found = [i for i, ball in zip(found, balls, strict=True) if ball.radius > least]
        return found

    def _is_end(self, facet: Facet) -> bool:
        """Whether no feasible parameter lies beyond a facet's plane: one linear program in the
        program's variables and eta, for each plane once."""
        height, key = float(facet.normal @ facet.foot), _key(facet)
        if key not in self.ends:
            a, b, c, _ = self.limits
            wide = np.zeros((self.own.domain_bounds.size, a.shape[1]))
            rows = np.vstack([np.hstack([a, -c]), np.hstack([wide, self.own.domain_rows])])
            objective = np.concatenate([np.zeros(a.shape[1]), facet.normal])
            try:
                top = maximise(rows, np.append(b, self.own.domain_bounds), objective).value
            except SetError:
                top = np.inf  # a feasible set without a point ends nowhere
            self.ends[key] = _End(facet.normal, top)
        b = np.abs(self.limits[1])
        return self.ends[key].top <= height + max(FLAT, END_SHARE * float(np.max(b, initial=0.0)))

    def _tell(self, pieces: list[Facet]) -> None:
        for piece in pieces:
            ball = ball_of(piece)
            if ball.radius <= SLIVER:
                self.slivers.append(max(ball.radius, 0.0))
                continue
            self.open.append(ball.radius)
            if not self.where:
                point = piece.foot + piece.basis @ ball.centre
                self.where = np.array2string(point, precision=4)


def largest_missed(dimension: int, radii: float, strips: float, slabs: float) -> float:
    """Radius of the largest ball that segments can miss.

    A convex set without a ball of radius a lies between planes 2 a sqrt(d + 2) apart (Steinhagen),
    and so does its shadow. Of a ball of radius r, the discs across the segments within r / 2 of its
    middle have at least the radius sqrt(3) r / 2; in one of them no more than the mean share of
    points is in slabs, and strips have to catch what leads to the others.

    Args:
        dimension: of facets.
        radii: of flat pieces of facets; strips, slabs: widths of others, and of gaps between
            planes; all in sum.
    """
    if not dimension:  # a segment runs along the line itself
        return radii + strips + slabs
    shadow = 2.0 * sqrt(dimension + 2.0) * radii + strips
    shares = _ball(dimension - 1) / _ball(dimension)
    narrower = 2.0 / sqrt(3.0)
    return narrower * shadow * shares + narrower**dimension * slabs


def _key(facet: Facet) -> tuple[float, ...]:
    """Of planes that one linear program is asked for."""
    return (*np.round(facet.normal, 8), round(float(facet.normal @ facet.foot), 8))


def _ball(dimension: int) -> float:
    """Volume of the unit ball."""
    return float(pi ** (0.5 * dimension) / gamma(0.5 * dimension + 1.0))
