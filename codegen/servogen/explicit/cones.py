"""Polyhedra, bounded or not, as cones of generators that a hyperplane can be held against and cut.

{x : h x <= k} is the slice t = 1 of the cone {(x, t) : h x <= k t, t >= 0}. Its rays are the
vertices and the directions to infinity alike, so nothing has to be boxed in. A hyperplane is cut
in by the double description method (Motzkin and others 1953; Fukuda and Prodon 1996), which keeps
for each ray the planes that it lies on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.explicit.small_lp import BoolArray, IntArray
from servogen.explicit.tolerances import TOUCHES_CONE
from servogen.plants.statespace import FloatArray

Words = npt.NDArray[np.uint64]
_BITS = 64
_ONE = np.uint64(1)
# Cones that are cut together, and pairs of rays that are looked at together, for the memory's sake.
_BATCH = 64
_PAIRS = 20_000


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


def sides(cones: Sequence[Cone], normals: FloatArray) -> BoolArray:
    """(cones, 2, planes): whether points lie strictly below, strictly above each plane."""
    heights = np.concatenate([cone.rays for cone in cones]) @ normals.T
    extremes = np.zeros((2, len(cones), len(normals)))
    end = 0
    for i, cone in enumerate(cones):  # faster than reduceat along this axis
        start, end = end, end + len(cone.rays)
        if end > start:
            np.minimum.reduce(heights[start:end], axis=0, out=extremes[0, i])
            np.maximum.reduce(heights[start:end], axis=0, out=extremes[1, i])
    found = np.stack([extremes[0] < -TOUCHES_CONE, extremes[1] > TOUCHES_CONE], axis=1)
    for i, cone in enumerate(cones):
        if len(cone.lines):
            found[i] |= np.any(np.abs(cone.lines @ normals.T) > TOUCHES_CONE, axis=0)
    return found


def cut(cone: Cone, normal: FloatArray) -> Cone:
    """The part of ``cone`` where normal . x <= 0."""
    return halves([cone], normal)[0][0]


def halves(cones: Sequence[Cone], normal: FloatArray) -> list[tuple[Cone, Cone]]:
    """The parts of each cone where normal . x <= 0 and where normal . x >= 0."""
    found: list[tuple[Cone, Cone] | None] = []
    for cone in cones:
        along = cone.lines @ normal
        crossed = along.size and float(np.max(np.abs(along))) > TOUCHES_CONE
        found.append(_across_line(cone, normal, along) if crossed else None)
    left = [i for i, pair in enumerate(found) if pair is None]
    for start in range(0, len(left), _BATCH):
        some = left[start : start + _BATCH]
        for i, pair in zip(some, _halves([cones[i] for i in some], normal), strict=True):
            found[i] = pair
    return [pair for pair in found if pair is not None]


def _halves(cones: Sequence[Cone], normal: FloatArray) -> list[tuple[Cone, Cone]]:
    """The same of cones without lines across the plane, all at once."""
    stack = _stacked(cones)
    heights = stack.rays @ normal
    above, below = heights > TOUCHES_CONE, heights < -TOUCHES_CONE
    first, second, shared = _edges(stack, above, below)
    rays = heights[first, None] * stack.rays[second] - heights[second, None] * stack.rays[first]
    rays = np.concatenate([stack.rays, _unit(rays)])
    tight = np.concatenate([stack.tight, shared])
    owner = np.concatenate([stack.owner, stack.owner[first]])
    fresh = np.ones(first.size, dtype=bool)
    on_plane = np.flatnonzero(np.concatenate([~(above | below), fresh]))
    cuts = stack.cuts[owner[on_plane]]
    tight[on_plane, cuts // _BITS] |= _ONE << (cuts % _BITS).astype(np.uint64)
    parts = []
    for kept in (~above, ~below):
        chosen = np.flatnonzero(np.concatenate([kept, fresh]))
        chosen = chosen[np.argsort(owner[chosen], kind="stable")]
        ends = np.cumsum(np.bincount(owner[chosen], minlength=len(cones))).tolist()
        own_rays, own_tight = rays[chosen], tight[chosen]
        parts.append(
            [
                Cone(own_rays[start:end], cone.lines, own_tight[start:end], cone.cuts + 1)
                for cone, start, end in zip(cones, [0, *ends[:-1]], ends, strict=True)
            ]
        )
    return list(zip(*parts, strict=True))


@dataclass(frozen=True)
class _Stack:
    """Cones one below the other: ``rays``, ``tight`` and ``owner`` of all rays; of each cone its
    ``cuts``, where its rays start, how many they are, on how many planes an edge lies at least."""

    rays: FloatArray
    tight: Words
    owner: IntArray
    cuts: IntArray
    start: IntArray
    count: IntArray
    least: IntArray


def _stacked(cones: Sequence[Cone]) -> _Stack:
    words = max(max(c.cuts // _BITS + 1, c.tight.shape[1]) for c in cones)  # one is to come
    count = np.array([len(cone.rays) for cone in cones])
    tight = np.zeros((int(np.sum(count)), words), dtype=np.uint64)
    end = 0
    for cone in cones:
        end += len(cone.rays)
        tight[end - len(cone.rays) : end, : cone.tight.shape[1]] = cone.tight
    return _Stack(
        np.concatenate([cone.rays for cone in cones]),
        tight,
        np.repeat(np.arange(len(cones)), count),
        np.array([cone.cuts for cone in cones]),
        np.cumsum(count) - count,
        count,
        np.array([cone.rays.shape[1] - cone.lines.shape[0] - 2 for cone in cones]),
    )


def _edges(stack: _Stack, above: BoolArray, below: BoolArray) -> tuple[IntArray, IntArray, Words]:
    """Pairs of a ray above and one below that span an edge of their cone, and the planes that both
    lie on: no third ray lies on all of them."""
    ups, downs = np.flatnonzero(above), np.flatnonzero(below)
    under = np.bincount(stack.owner[downs], minlength=stack.count.size)
    first, place = _each_with(ups, under[stack.owner[ups]])
    second = downs[(np.cumsum(under) - under)[stack.owner[first]] + place]
    shared = stack.tight[first] & stack.tight[second]
    enough = np.bitwise_count(shared).sum(axis=1) >= stack.least[stack.owner[first]]
    first, second, shared = first[enough], second[enough], shared[enough]
    edge = np.zeros(first.size, dtype=bool)
    for begin in range(0, first.size, _PAIRS):
        some = slice(begin, begin + _PAIRS)
        own = stack.owner[first[some]]
        pair, place = _each_with(np.arange(own.size), stack.count[own])
        ray = stack.start[own][pair] + place
        missing = np.any(shared[some][pair] & ~stack.tight[ray], axis=1)
        edge[some] = np.bincount(pair[~missing], minlength=own.size) == 2
    return first[edge], second[edge], shared[edge]


def _each_with(items: IntArray, counts: IntArray) -> tuple[IntArray, IntArray]:
    """Every item as often as its count says, and the numbers from zero beside it."""
    ends = np.cumsum(counts)
    repeated = np.repeat(items, counts)
    return repeated, np.arange(repeated.size) - np.repeat(ends - counts, counts)


def _across_line(cone: Cone, normal: FloatArray, along: FloatArray) -> tuple[Cone, Cone]:
    """A line that crosses the plane becomes a ray; everything else slides along it onto it."""
    j = int(np.argmax(np.abs(along)))
    line, slope = cone.lines[j], along[j]
    others = np.delete(cone.lines, j, axis=0)
    lines = _unit(others - np.outer(np.delete(along, j) / slope, line))
    slid = cone.rays - np.outer(cone.rays @ normal / slope, line)
    word, bit = divmod(cone.cuts, _BITS)
    words = max(word + 1, cone.tight.shape[1])
    tight = np.zeros((len(slid) + 1, words), dtype=np.uint64)
    tight[:-1, : cone.tight.shape[1]] = cone.tight
    tight[:-1, word] |= _ONE << np.uint64(bit)
    for plane in range(cone.cuts):  # the line lies on all of them
        tight[-1, plane // _BITS] |= _ONE << np.uint64(plane % _BITS)
    parts = []
    for sign in (-np.sign(slope), np.sign(slope)):
        parts.append(Cone(_unit(np.vstack([slid, sign * line])), lines, tight, cone.cuts + 1))
    return parts[0], parts[1]


def _unit(rows: FloatArray) -> FloatArray:
    if not rows.size:
        return rows
    unit: FloatArray = rows / np.sqrt(np.einsum("ij,ij->i", rows, rows))[:, None]
    return unit
