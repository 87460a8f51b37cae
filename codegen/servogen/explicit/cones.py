"""Polyhedra, bounded or not, as cones of generators that a hyperplane can be held against and cut.

{x : h x <= k} is the slice t = 1 of the cone {(x, t) : h x <= k t, t >= 0}. Its rays are the
vertices and the directions to infinity alike, so nothing has to be boxed in. A hyperplane is cut
in by the double description method (Motzkin and others 1953; Fukuda and Prodon 1996), which keeps
for each ray the planes that it lies on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.explicit.small_lp import BoolArray, IntArray
from servogen.explicit.tolerances import TOUCHES_CONE
from servogen.plants.statespace import FloatArray

Words = npt.NDArray[np.uint64]
_BITS = 64
_ONE = np.uint64(1)


@dataclass(frozen=True)
class Cone:
    """``rays`` (g, n) of unit length, ``lines`` (l, n).

    ``tight`` (g, words): on which of the ``cuts`` planes that were cut in each ray lies, a bit for
    each plane.
    """

    rays: FloatArray
    lines: FloatArray
    tight: Words
    cuts: int


def homogeneous(h: FloatArray, k: FloatArray) -> FloatArray:
    """(rows, r + 1) unit normals of h x <= k as h x - k t <= 0."""
    rows = np.column_stack([h, -k])
    unit: FloatArray = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return unit


def cone_of(h: FloatArray, k: FloatArray) -> Cone:
    """The cone over {x : h x <= k}."""
    n = h.shape[1] + 1
    cone = Cone(np.zeros((0, n)), np.eye(n), np.zeros((0, 1), dtype=np.uint64), 0)
    cone = cut(cone, -np.eye(n)[-1])
    for normal in homogeneous(h, k):
        cone = cut(cone, normal)
    return cone


def sides(cone: Cone, normals: FloatArray) -> tuple[BoolArray, BoolArray]:
    """(planes,) each: whether points lie strictly below and strictly above each plane."""
    heights = cone.rays @ normals.T
    below = np.min(heights, axis=0, initial=0.0) < -TOUCHES_CONE
    above = np.max(heights, axis=0, initial=0.0) > TOUCHES_CONE
    if cone.lines.shape[0]:
        crossed = np.max(np.abs(cone.lines @ normals.T), axis=0) > TOUCHES_CONE
        return below | crossed, above | crossed
    return below, above


def cut(cone: Cone, normal: FloatArray) -> Cone:
    """The part of ``cone`` where normal . x <= 0."""
    return halves(cone, normal)[0]


def halves(cone: Cone, normal: FloatArray) -> tuple[Cone, Cone]:
    """The parts of ``cone`` where normal . x <= 0 and where normal . x >= 0."""
    along = cone.lines @ normal
    if along.size and float(np.max(np.abs(along))) > TOUCHES_CONE:
        return _across_line(cone, normal, along)
    heights = cone.rays @ normal
    above, below = heights > TOUCHES_CONE, heights < -TOUCHES_CONE
    tight = _marked(cone, ~(above | below))
    ups, downs = np.flatnonzero(above), np.flatnonzero(below)
    rays, planes = _new_rays(cone, heights, ups, downs)
    parts = []
    for kept in (~above, ~below):
        parts.append(
            Cone(
                np.concatenate([cone.rays[kept], rays]),
                cone.lines,
                np.concatenate([tight[kept], planes]),
                cone.cuts + 1,
            )
        )
    return parts[0], parts[1]


def _across_line(cone: Cone, normal: FloatArray, along: FloatArray) -> tuple[Cone, Cone]:
    """A line that crosses the plane becomes a ray; everything else slides along it onto it."""
    j = int(np.argmax(np.abs(along)))
    line, slope = cone.lines[j], along[j]
    others = np.delete(cone.lines, j, axis=0)
    lines = _unit(others - np.outer(np.delete(along, j) / slope, line))
    slid = cone.rays - np.outer(cone.rays @ normal / slope, line)
    tight = _marked(cone, np.ones(len(slid), dtype=bool))
    fresh = np.zeros(tight.shape[1], dtype=np.uint64)
    for plane in range(cone.cuts):  # the line lies on all of them
        fresh[plane // _BITS] |= _ONE << np.uint64(plane % _BITS)
    tight = np.vstack([tight, fresh])
    parts = []
    for sign in (-np.sign(slope), np.sign(slope)):
        parts.append(Cone(_unit(np.vstack([slid, sign * line])), lines, tight, cone.cuts + 1))
    return parts[0], parts[1]


def _marked(cone: Cone, on_plane: BoolArray) -> Words:
    """``tight`` with one plane more, which the rays of ``on_plane`` lie on."""
    word, bit = divmod(cone.cuts, _BITS)
    tight = cone.tight.copy()
    if word == tight.shape[1]:
        tight = np.column_stack([tight, np.zeros(tight.shape[0], dtype=np.uint64)])
    tight[on_plane, word] |= _ONE << np.uint64(bit)
    return tight


def _new_rays(
    cone: Cone, heights: FloatArray, above: IntArray, below: IntArray
) -> tuple[FloatArray, Words]:
    """Where the edges between rays above and below meet the plane, and on which planes that is.

    Two rays span an edge if no third one lies on all planes that they share.
    """
    shared = cone.tight[above][:, None] & cone.tight[below][None]
    # an edge lies on so many planes at least
    least = cone.rays.shape[1] - cone.lines.shape[0] - 2
    first, second = np.nonzero(np.bitwise_count(shared).sum(axis=2) >= least)
    shared = shared[first, second]
    missing = shared[:, None, 0] & ~cone.tight[None, :, 0]
    for word in range(1, shared.shape[1]):
        missing |= shared[:, None, word] & ~cone.tight[None, :, word]
    edge = np.count_nonzero(missing == 0, axis=1) == 2
    up, down, shared = above[first[edge]], below[second[edge]], shared[edge]
    rays = heights[up, None] * cone.rays[down] - heights[down, None] * cone.rays[up]
    word, bit = divmod(cone.cuts, _BITS)
    if word == shared.shape[1]:
        shared = np.column_stack([shared, np.zeros(shared.shape[0], dtype=np.uint64)])
    shared[:, word] |= _ONE << np.uint64(bit)
    return _unit(rays), shared


def _unit(rows: FloatArray) -> FloatArray:
    if not rows.size:
        return rows
    unit: FloatArray = rows / np.sqrt(np.einsum("ij,ij->i", rows, rows))[:, None]
    return unit
