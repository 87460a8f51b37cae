"""Facets of regions in their own planes: balls in them, parts of them, rows held against them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.explicit.cover import Facet
from servogen.explicit.regions import Region
from servogen.explicit.restated import Restated
from servogen.explicit.small_lp import Ball, BoolArray, greatest_many, inner_ball, inner_balls
from servogen.explicit.tolerances import FAR, FLAT, REDUNDANT, SAME_PLANE
from servogen.plants.statespace import FloatArray
from servogen.sets.errors import SetError

# By how much rows are loosened where numbers give out, one after the other, which makes no ball
# smaller; all are less than what counts as flat.
_LOOSENED = (0.0, 0.1 * FLAT, 0.3 * FLAT)
# Rows of a facet in its own plane that are one: left as they are they cost digits, and a pair that
# is further apart is no harm.
SAME_ROW = 1e-12


def region_balls(own: Restated, regions: Sequence[Region]) -> list[Ball]:
    """A region counts for nothing where it is not shown to be full."""
    rows, bounds = own.domain_rows, own.domain_bounds
    sets = [(np.vstack([r.h, rows]), np.concatenate([r.k, bounds])) for r in regions]
    return padded_balls(sets, shown=True)


def facet_on(region: Region, own: Restated, row: int) -> Facet:
    """The facet on a row, the domain included, from the point of its plane next to the origin: from
    one far out its bounds would lose the digits that tell it from its neighbour."""
    normal = region.h[row]
    foot = normal * region.k[row]
    basis = np.linalg.svd(normal[None, :])[2][1:].T
    others = np.arange(region.k.size) != row
    h = np.vstack([region.h[others], own.domain_rows])
    k = np.concatenate([region.k[others], own.domain_bounds])
    return Facet(normal, foot, basis, h @ basis, k - h @ foot)


def facet_balls(facets: list[Facet]) -> list[Ball]:
    """Of each facet, in the coordinates of its plane and within ``FAR``."""
    size = facets[0].basis.shape[1] if facets else 0
    if size == 0:
        return [Ball(np.zeros(0), 1.0)] * len(facets)
    balls = padded_balls([(facet.rows, facet.bounds) for facet in facets])
    box = np.vstack([np.eye(size), -np.eye(size)])
    for i, (facet, ball) in enumerate(zip(facets, balls, strict=True)):
        reach = FAR + float(np.linalg.norm(facet.foot))
        if np.max(np.abs(ball.centre)) > reach:
            rows, bounds = np.vstack([facet.rows, box]), np.full(2 * size, reach)
            balls[i] = _one_ball(rows, np.append(facet.bounds, bounds))
    return balls


def padded_balls(sets: list[tuple[FloatArray, FloatArray]], shown: bool = False) -> list[Ball]:
    """Of sets {h x <= k} that differ in their rows. What a linear program leaves unsettled counts
    as wide, or, where a ball has to be shown, as nothing."""
    if not sets:
        return []
    most = max(1, max(k.size for _, k in sets))
    h, k = np.zeros((len(sets), most, sets[0][0].shape[1])), np.ones((len(sets), most))
    for i, (rows, bounds) in enumerate(sets):
        h[i, : bounds.size], k[i, : bounds.size] = rows, bounds  # rows 0 x <= 1 fill up
    try:
        return inner_balls(h, k)
    except SetError:
        return [_one_ball(rows, bounds, shown) for rows, bounds in sets]


def _one_ball(h: FloatArray, k: FloatArray, shown: bool = False) -> Ball:
    for loosened in (0.0,) if shown else _LOOSENED:
        try:
            return inner_ball(h, k + loosened)
        except SetError:
            continue
    return Ball(np.zeros(h.shape[1]), 0.0 if shown else 1.0)


def ball_of(piece: Facet) -> Ball:
    return facet_balls([piece])[0]


def without(piece: Facet, region: Region) -> tuple[list[Facet], float]:
    """Parts of a piece outside a region behind it, and the radii of those that are flat in sum."""
    if piece.basis.shape[1] == 0:  # a point, and a region behind it
        return [], 0.0
    rows, bounds = trace(piece, region)
    parts = [
        common_part(
            piece, np.vstack([rows[:i], -rows[i : i + 1]]), np.append(bounds[:i], -bounds[i])
        )
        for i in range(bounds.size)
    ]
    common = common_part(piece, rows, bounds)
    *outside, inside = [ball.radius for ball in facet_balls([*parts, common])]
    if inside <= FLAT:
        return [piece], 0.0  # they have nothing in common: no reason to cut
    flat = sum(max(radius, 0.0) for radius in outside if radius <= FLAT)
    return [part for part, radius in zip(parts, outside, strict=True) if radius > FLAT], flat


def common_part(piece: Facet, rows: FloatArray, bounds: FloatArray) -> Facet:
    """The part of a piece within more rows; of equal rows the tighter one."""
    h, k = np.vstack([piece.rows, rows]), np.append(piece.bounds, bounds)
    apart = np.max(np.abs(h[:, None] - h[None]), axis=2)
    index = np.arange(k.size)
    tighter = (k[None] < k[:, None]) | ((k[None] == k[:, None]) & (index[None] < index[:, None]))
    kept = ~np.any((apart <= SAME_ROW) & tighter, axis=1)
    return Facet(piece.normal, piece.foot, piece.basis, h[kept], k[kept])


def trace(facet: Facet, region: Region) -> tuple[FloatArray, FloatArray]:
    """The rows of a region on a facet's plane, unit length; those along the plane left out."""
    along, bounds = region.h @ facet.basis, region.k - region.h @ facet.foot
    lengths = np.linalg.norm(along, axis=1)
    across = lengths > SAME_PLANE
    return along[across] / lengths[across, None], bounds[across] / lengths[across]


def gap_behind(facet: Facet, behind: Sequence[Region]) -> tuple[float, float]:
    """What lies between a facet and the regions behind it, within ``FAR``: the width of the slab
    that their rows along the plane leave, and of its sides as segments see them, in sum.

    On the plane such a row, which ``trace`` leaves out, is exceeded by no more than its length
    there times ``FAR``. The slab over the whole facet has a side on each of the facet's own rows,
    as high as it is wide; its far end is cut short where a region recedes from the plane.
    """
    slab, sides = 0.0, float(facet.bounds.size)
    for region in behind:
        along, bounds = region.h @ facet.basis, region.k - region.h @ facet.foot
        lengths = np.linalg.norm(along, axis=1)
        across = lengths > SAME_PLANE
        slab = max(slab, float(np.max(lengths[~across] * FAR - bounds[~across], initial=0.0)))
        receding = np.maximum(region.h[across] @ facet.normal, 0.0) / lengths[across]
        sides += float(np.sum(receding))
    return slab, slab * sides


def same_rows(facet: Facet, rows: FloatArray, bounds: FloatArray) -> tuple[BoolArray, float]:
    """(rows,) which are rows of the facet itself, so that nothing is to be shown, and by how much
    those let the facet reach beyond them within ``FAR``, in sum."""
    lengths = np.linalg.norm(facet.rows, axis=1)
    across = lengths > SAME_PLANE
    own = facet.rows[across] / lengths[across, None]
    limits = facet.bounds[across] / lengths[across]
    if not rows.size or not limits.size:
        return np.zeros(bounds.size, dtype=bool), 0.0
    apart = np.max(np.abs(rows[:, None] - own[None]), axis=2)
    looser = np.maximum(limits[None] - bounds[:, None], 0.0)
    chosen = np.argmin(np.where(apart <= REDUNDANT, looser, np.inf), axis=1)
    at = np.arange(bounds.size)
    same = (apart[at, chosen] <= REDUNDANT) & (looser[at, chosen] <= REDUNDANT)
    turned = FAR * np.linalg.norm(rows - own[chosen], axis=1)
    return same, float(np.sum((looser[at, chosen] + turned)[same]))


def facet_tops(facets: list[Facet], work: list[tuple[int, FloatArray, float]]) -> FloatArray:
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
