"""Polyhedra, bounded or not, as cones of generators that a hyperplane can be held against and cut.

{x : h x <= k} is the slice t = 1 of the cone {(x, t) : h x <= k t, t >= 0}. Its rays are the
vertices and the directions to infinity alike, so nothing has to be boxed in. A hyperplane is cut
in by the double description method (Motzkin and others 1953; Fukuda and Prodon 1996), which keeps
for each ray the planes that it lies on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.small_lp import BoolArray, IntArray
from servogen.explicit.tolerances import TOUCHES_CONE
from servogen.plants.statespace import FloatArray


@dataclass(frozen=True)
class Cone:
    """``rays`` (g, n) of unit length, ``lines`` (l, n), ``tight`` (g, cuts): on which planes."""

    rays: FloatArray
    lines: FloatArray
    tight: BoolArray


def homogeneous(h: FloatArray, k: FloatArray) -> FloatArray:
    """(rows, r + 1) unit normals of h x <= k as h x - k t <= 0."""
    rows = np.column_stack([h, -k])
    unit: FloatArray = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return unit


def cone_of(h: FloatArray, k: FloatArray) -> Cone:
    """The cone over {x : h x <= k}."""
    n = h.shape[1] + 1
    cone = Cone(np.zeros((0, n)), np.eye(n), np.zeros((0, 0), dtype=bool))
    cone = cut(cone, -np.eye(n)[-1])
    for normal in homogeneous(h, k):
        cone = cut(cone, normal)
    return cone


def sides(cone: Cone, normals: FloatArray) -> tuple[BoolArray, BoolArray]:
    """(planes,) each: whether points lie strictly below and strictly above each plane."""
    heights = cone.rays @ normals.T
    below = np.any(heights < -TOUCHES_CONE, axis=0)
    above = np.any(heights > TOUCHES_CONE, axis=0)
    crossed = np.any(np.abs(cone.lines @ normals.T) > TOUCHES_CONE, axis=0)
    return below | crossed, above | crossed


def cut(cone: Cone, normal: FloatArray) -> Cone:
    """The part of ``cone`` where normal . x <= 0."""
    along = cone.lines @ normal
    if along.size and float(np.max(np.abs(along))) > TOUCHES_CONE:
        return _cut_line(cone, normal, along)
    heights = cone.rays @ normal
    above, below = heights > TOUCHES_CONE, heights < -TOUCHES_CONE
    on_plane = ~above & ~below
    kept = ~above
    tight = np.column_stack([cone.tight, on_plane])[kept]
    if not np.any(above):
        return Cone(cone.rays, cone.lines, tight)
    rays, planes = _new_rays(cone, heights, np.flatnonzero(above), np.flatnonzero(below))
    return Cone(np.vstack([cone.rays[kept], rays]), cone.lines, np.vstack([tight, planes]))


def _cut_line(cone: Cone, normal: FloatArray, along: FloatArray) -> Cone:
    """A line that crosses the plane becomes a ray; everything else slides along it onto it."""
    j = int(np.argmax(np.abs(along)))
    line, slope = cone.lines[j], along[j]
    others = np.delete(cone.lines, j, axis=0)
    lines = others - np.outer(np.delete(along, j) / slope, line)
    rays = cone.rays - np.outer(cone.rays @ normal / slope, line)
    count = cone.tight.shape[1]
    tight = np.column_stack([cone.tight, np.ones(len(rays), dtype=bool)])
    fresh = np.append(np.ones(count, dtype=bool), False)
    return Cone(_unit(np.vstack([rays, -np.sign(slope) * line])), _unit(lines),
                np.vstack([tight, fresh]))  # fmt: skip


def _new_rays(
    cone: Cone, heights: FloatArray, above: IntArray, below: IntArray
) -> tuple[FloatArray, BoolArray]:
    """Where the edges between rays above and below meet the plane.

    Two rays span an edge if no third one lies on all planes that they share.
    """
    first = np.repeat(above, below.size)
    second = np.tile(below, above.size)
    shared = cone.tight[first] & cone.tight[second]
    # an edge lies on so many planes at least
    enough = np.sum(shared, axis=1) >= cone.rays.shape[1] - cone.lines.shape[0] - 2
    first, second, shared = first[enough], second[enough], shared[enough]
    missing = shared.astype(np.float32) @ (~cone.tight).T.astype(np.float32)
    edge = np.sum(missing == 0.0, axis=1) == 2
    first, second, shared = first[edge], second[edge], shared[edge]
    rays = heights[first, None] * cone.rays[second] - heights[second, None] * cone.rays[first]
    return _unit(rays), np.column_stack([shared, np.ones(len(rays), dtype=bool)])


def _unit(rows: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    unit: FloatArray = rows / lengths if rows.size else rows
    return unit
