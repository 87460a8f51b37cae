"""That regions leave nothing of the feasible parameters out: facet by facet.

Let every facet of every region either bound the feasible set, or be covered from beyond by other
regions. Join a ball of a region with a ball of feasible parameters that are in none by parallel
segments. All of them run in the feasible set, which is convex, and each leaves the regions for the
last time: through a facet, at a point that no region covers from beyond. If that is impossible for
all points of facets but a few strips, those have to catch every segment; so the smaller ball has no
larger cross-section than the strips, and what is missing is known to be small (``hole``). Nothing of
the way the regions were found is used; that they do not overlap neither, the optimum being unique.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import gamma, pi, sqrt

import numpy as np

from servogen.explicit.cover import Facet
from servogen.explicit.regions import Region
from servogen.explicit.restated import Restated
from servogen.explicit.small_lp import Ball, BoolArray, greatest_many, inner_ball, inner_balls
from servogen.explicit.tolerances import FLAT, REDUNDANT, SAME_PLANE, SLIVER
from servogen.plants.statespace import FloatArray
from servogen.progress import Task
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise

# Linear programs of different facets that are solved together.
_CHUNK = 256
# By how much rows are loosened where numbers give out, one after the other; all are less than what
# counts as flat.
_LOOSENED = (0.0, 0.1 * FLAT, 0.3 * FLAT)
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


class _Proof:
    def __init__(self, own: Restated, regions: Sequence[Region]) -> None:
        self.own, self.regions = own, regions
        self.balls = _balls(own, regions)
        self.full = np.array([ball.radius > FLAT for ball in self.balls])
        self.h = np.vstack([region.h for region in regions])
        self.k = np.concatenate([region.k for region in regions])
        self.region_of = np.repeat(np.arange(len(regions)), [r.k.size for r in regions])
        self.limits = own.feasible_rows()
        self.ends: dict[tuple[float, ...], bool] = {}
        self.pending: list[tuple[Facet, int, FloatArray, FloatArray]] = []
        self.count = self.shared = self.ended = 0
        self.open: list[float] = []
        self.slivers: list[float] = []
        self.passed_over = 0.0
        self.where = ""

    def look_at(self, chosen: Sequence[int]) -> None:
        """All facets of some regions: to be settled by one neighbour's rows, or cut by several. A
        flat region is none: nothing is covered by it, nothing leaves through it."""
        places = [(i, row) for i in chosen if self.full[i] for row in range(self.regions[i].k.size)]
        facets = [_facet(self.regions[i], self.own, j, self.balls[i].centre) for i, j in places]
        for (i, row), facet, ball in zip(places, facets, _facet_balls(facets), strict=True):
            if ball.radius <= FLAT:  # the row touches less than a facet
                self.passed_over += FLAT
                continue
            self.count += 1
            behind = self._behind(i, row)
            if len(behind) == 1:
                self.pending.append((facet, behind[0], *_trace(facet, self.regions[behind[0]])))
            else:
                self._cut(facet, behind)

    def settle(self) -> None:
        """Facets with a single neighbour: whether each row of that one keeps the whole facet."""
        work: list[tuple[int, FloatArray, float]] = []
        fails: dict[int, bool] = {}
        for i, (facet, _, rows, bounds) in enumerate(self.pending):
            same, looser = _same_rows(facet, rows, bounds)
            self.passed_over += looser
            work += [(i, rows[j], float(bounds[j])) for j in np.flatnonzero(~same)]
        for start in range(0, len(work), _CHUNK):
            chunk = work[start : start + _CHUNK]
            tops = _tops([self.pending[i][0] for i, _, _ in chunk], chunk)
            for (i, _, bound), top in zip(chunk, tops, strict=True):
                fails[i] = fails.get(i, False) or top > bound + REDUNDANT
                self.passed_over += max(0.0, min(top - bound, REDUNDANT))
        for i, (facet, neighbour, _, _) in enumerate(self.pending):
            if fails.get(i, False):
                self._cut(facet, [neighbour])
            else:
                self.shared += 1

    def result(self) -> Cover:
        d = self.own.coordinates - 1
        width = self.passed_over + sum(self.slivers)
        # a convex set without a ball of radius a lies between planes 2 a sqrt(d + 2) apart
        # (Steinhagen); so does its shadow, which covers that much of a ball's cross-section
        hole = 2.0 * sqrt(d + 2.0) * width * _ball(d - 1) / _ball(d) if d else width
        hole += SAME_PLANE  # between a facet and its neighbour's
        largest = max(ball.radius for ball in self.balls)
        if self.open or largest <= max(hole, FLAT):
            hole = float("inf")
        return Cover(
            self.count, self.shared, self.ended, tuple(self.open), tuple(self.slivers), hole,
            max(largest, 0.0), self.where,
        )  # fmt: skip

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
        left = self._less([facet], neighbours)
        if left and not self._is_end(facet):
            left = self._less(left, self._crossing(facet, neighbours))
        if not left:
            self.shared += 1
        elif self._is_end(facet):
            self.ended += 1
        else:
            self._tell(left)

    def _less(self, pieces: list[Facet], neighbours: list[int]) -> list[Facet]:
        """The pieces of a facet without what lies in regions behind it."""
        for i in neighbours:
            left = []
            for piece in pieces:
                parts, flat = _without(piece, self.regions[i])
                self.passed_over += flat
                left += parts
            pieces = left
        return pieces

    def _crossing(self, facet: Facet, known: list[int]) -> list[int]:
        """Regions that a facet's plane runs through: they overlap with its own, where dependent
        rows let several active sets be optimal."""
        height = float(facet.normal @ facet.foot)
        signed = np.array([ball.centre @ facet.normal - height for ball in self.balls])
        found = []
        for i, region in enumerate(self.regions):
            if i in known or not self.full[i] or signed[i] <= 0.0:
                continue
            rows = np.vstack([region.h, facet.normal, -facet.normal])
            least = np.concatenate([region.k, [height + FLAT, -height + FLAT]])
            beyond = np.concatenate([region.k, [height + 1.0, -height]])
            try:
                reaches = inner_ball(rows, beyond).radius > FLAT
                reaches = reaches and inner_ball(rows, least).radius > 0.0
            except SetError:
                continue  # nothing is shown: what it may cover counts as open
            if reaches:
                found.append(i)
        return found

    def _is_end(self, facet: Facet) -> bool:
        """Whether no feasible parameter lies beyond a facet's plane: one linear program in the
        program's variables and eta, for each plane once."""
        height = float(facet.normal @ facet.foot)
        key = (*np.round(facet.normal, 8), round(height, 8))
        if key not in self.ends:
            a, b, c, _ = self.limits
            wide = np.zeros((self.own.domain_bounds.size, a.shape[1]))
            rows = np.vstack([np.hstack([a, -c]), np.hstack([wide, self.own.domain_rows])])
            objective = np.concatenate([np.zeros(a.shape[1]), facet.normal])
            try:
                top = maximise(rows, np.append(b, self.own.domain_bounds), objective).value
            except SetError:
                top = np.inf  # a feasible set without a point ends nowhere
            self.ends[key] = top <= height + FLAT
        return self.ends[key]

    def _tell(self, pieces: list[Facet]) -> None:
        for piece in pieces:
            ball = _ball_of(piece)
            if ball.radius <= SLIVER:
                self.slivers.append(max(ball.radius, 0.0))
                continue
            self.open.append(ball.radius)
            if not self.where:
                point = piece.foot + piece.basis @ ball.centre
                self.where = np.array2string(point, precision=4)


def _balls(own: Restated, regions: Sequence[Region]) -> list[Ball]:
    most = max(max((region.k.size for region in regions), default=0), 1)
    h = np.zeros((len(regions), most, own.coordinates))
    k = np.ones((len(regions), most))  # rows 0 eta <= 1 fill up
    for i, region in enumerate(regions):
        h[i, : region.k.size], k[i, : region.k.size] = region.h, region.k
    limits = np.broadcast_to(own.domain_bounds, (len(regions), own.domain_bounds.size))
    shared = own.domain_rows if own.domain_bounds.size else None
    k = np.concatenate([k, limits], axis=1)
    try:
        return inner_balls(h, k, shared=shared)
    except SetError:
        if shared is not None:
            h = np.concatenate([h, np.broadcast_to(shared, (len(h), *shared.shape))], axis=1)
        return [_region_ball(h[i], k[i]) for i in range(len(regions))]


def _region_ball(h: FloatArray, k: FloatArray) -> Ball:
    """A region counts for nothing where it is not shown to be full."""
    try:
        return inner_ball(h, k)
    except SetError:
        return Ball(np.zeros(h.shape[1]), 0.0)


def _facet(region: Region, own: Restated, row: int, centre: FloatArray) -> Facet:
    """The facet on a row, the domain included."""
    normal = region.h[row]
    foot = centre + normal * (region.k[row] - normal @ centre)
    basis = np.linalg.svd(normal[None, :])[2][1:].T
    others = np.arange(region.k.size) != row
    h = np.vstack([region.h[others], own.domain_rows])
    k = np.concatenate([region.k[others], own.domain_bounds])
    return Facet(normal, foot, basis, h @ basis, k - h @ foot)


def _facet_balls(facets: list[Facet]) -> list[Ball]:
    """Of each facet, in the coordinates of its plane. Where the linear program is settled by nobody
    the rows are loosened a little, which makes no ball smaller; if that does not help, the facet
    counts as wide."""
    size = facets[0].basis.shape[1] if facets else 0
    if size == 0:
        return [Ball(np.zeros(0), 1.0)] * len(facets)
    most = max(max(facet.bounds.size for facet in facets), 1)
    h, k = np.zeros((len(facets), most, size)), np.ones((len(facets), most))
    for i, facet in enumerate(facets):
        h[i, : facet.bounds.size], k[i, : facet.bounds.size] = facet.rows, facet.bounds
    try:
        return inner_balls(h, k)
    except SetError:
        return [_one_ball(h[i], k[i]) for i in range(len(facets))]


def _one_ball(h: FloatArray, k: FloatArray) -> Ball:
    for loosened in _LOOSENED:
        try:
            return inner_ball(h, k + loosened)
        except SetError:
            continue
    return Ball(np.zeros(h.shape[1]), 1.0)


def _ball_of(piece: Facet) -> Ball:
    return _facet_balls([piece])[0]


def _without(piece: Facet, region: Region) -> tuple[list[Facet], float]:
    """Parts of a piece outside a region behind it, and the radii of those that are flat in sum."""
    if piece.basis.shape[1] == 0:  # a point, and a region behind it
        return [], 0.0
    rows, bounds = _trace(piece, region)
    parts = [
        Facet(
            piece.normal, piece.foot, piece.basis,
            np.vstack([piece.rows, rows[:i], -rows[i : i + 1]]),
            np.concatenate([piece.bounds, bounds[:i], -bounds[i : i + 1]]),
        )
        for i in range(bounds.size)
    ]  # fmt: skip
    common = Facet(
        piece.normal, piece.foot, piece.basis,
        np.vstack([piece.rows, rows]), np.append(piece.bounds, bounds),
    )  # fmt: skip
    *outside, inside = [ball.radius for ball in _facet_balls([*parts, common])]
    if inside <= FLAT:
        return [piece], 0.0  # they have nothing in common: no reason to cut
    flat = sum(max(radius, 0.0) for radius in outside if radius <= FLAT)
    return [part for part, radius in zip(parts, outside, strict=True) if radius > FLAT], flat


def _trace(facet: Facet, region: Region) -> tuple[FloatArray, FloatArray]:
    """The rows of a region on a facet's plane, unit length; those along the plane left out."""
    along, bounds = region.h @ facet.basis, region.k - region.h @ facet.foot
    lengths = np.linalg.norm(along, axis=1)
    across = lengths > SAME_PLANE
    return along[across] / lengths[across, None], bounds[across] / lengths[across]


def _same_rows(facet: Facet, rows: FloatArray, bounds: FloatArray) -> tuple[BoolArray, float]:
    """(rows,) which are rows of the facet itself, so that nothing is to be shown, and by how much
    those let the facet reach beyond them in sum."""
    lengths = np.linalg.norm(facet.rows, axis=1)
    across = lengths > SAME_PLANE
    own = facet.rows[across] / lengths[across, None]
    limits = facet.bounds[across] / lengths[across]
    if not rows.size or not limits.size:
        return np.zeros(bounds.size, dtype=bool), 0.0
    apart = np.max(np.abs(rows[:, None] - own[None]), axis=2)
    looser = np.where(apart <= REDUNDANT, limits[None] - bounds[:, None], np.inf)
    least = np.maximum(np.min(looser, axis=1), 0.0)
    same = least <= REDUNDANT
    return same, float(np.sum(least[same]))


def _tops(facets: list[Facet], work: list[tuple[int, FloatArray, float]]) -> FloatArray:
    """Greatest value of each row over its facet, up to one above its bound."""
    most = max(facet.bounds.size for facet in facets) + 1
    size = facets[0].basis.shape[1]
    h = np.zeros((len(facets), most, size))
    k = np.ones((len(facets), most))  # rows 0 y <= 1 fill up
    for at, (facet, (_, row, bound)) in enumerate(zip(facets, work, strict=True)):
        count = facet.bounds.size
        h[at, :count], k[at, :count] = facet.rows, facet.bounds
        h[at, most - 1], k[at, most - 1] = row, bound + 1.0
    tops = greatest_many(h, k, np.array([row for _, row, _ in work]))
    tops[np.isneginf(tops)] = np.inf  # no answer: nothing is shown
    return tops


def _ball(dimension: int) -> float:
    """Volume of the unit ball."""
    return pi ** (0.5 * dimension) / gamma(0.5 * dimension + 1.0)
