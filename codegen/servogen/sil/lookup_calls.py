"""Parameters that try a lookup: ordinary ones, on facets and next to them, far outside."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.lookup_design import LookupDesign
from servogen.explicit.feasible import FeasibleSet
from servogen.explicit.lookup import TreeLookup, image
from servogen.explicit.small_lp import inner_ball
from servogen.explicit.tree import ordered_product
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# How far from a facet, in units of the last place of a parameter.
_BESIDE = (0, 0, 1, -1, 3, -20, 1000)
_ACROSS = 4


def lookup_calls(design: LookupDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    """``count`` calls of ``find``, a third of each kind, now and then one that is no number."""
    planes, heights = facets_of(design)
    back = directions(design)
    for index in range(count):
        theta: FloatArray = back @ rng.normal(size=back.shape[1])
        theta = theta * float(rng.choice([0.1, 0.5, 1.0, 3.0]))
        if index % 3 == 1 and heights.size:
            theta = _on_facets(design, rng, theta, planes, heights, back)
        if index % 3 == 2:
            theta = theta * 10.0 ** rng.uniform(1.0, 9.0)
        if rng.random() < 0.02:
            theta[int(rng.integers(theta.size))] = rng.choice([np.nan, np.inf, -np.inf])
        yield Call("find", {"theta": theta})


def _on_facets(
    design: LookupDesign,
    rng: np.random.Generator,
    theta: FloatArray,
    planes: FloatArray,
    heights: FloatArray,
    back: FloatArray,
) -> FloatArray:
    """On one facet or on several that meet, where the feasible set ends, or as near to where a
    tree's decision turns over as the scalar type can tell."""
    kind = rng.random()
    if design.feasible is not None and kind < 0.5:
        return _beside(rng, design, _at_the_edge(design.feasible, rng, back), back)
    some = rng.integers(heights.size, size=int(rng.integers(1, back.shape[1] + 1)))
    placed, form = on_planes(theta, planes[some], heights[some], back), design.form
    if isinstance(form, TreeLookup) and form.tree.inner and kind > 0.8:
        node = int(rng.integers(form.tree.inner))
        placed = on_planes(theta, planes[node : node + 1], heights[node : node + 1], back)
        return _turning(design, form, node, planes[node], placed)
    return _beside(rng, design, placed, back)


def _at_the_edge(feasible: FeasibleSet, rng: np.random.Generator, back: FloatArray) -> FloatArray:
    """On a facet, by a few steps across the feasible set, each in a direction of its own and but
    for the last a part of the way; from zero, where a plant may rest, or else from the middle."""
    theta: FloatArray = np.zeros(back.shape[0])
    with np.errstate(divide="ignore"):
        reach = np.min(np.abs(feasible.bounds)[:, None] / np.abs(feasible.rows), axis=0)
    sizes = np.where(np.isfinite(reach), reach, np.max(np.abs(back), axis=1))
    if np.any(feasible.bounds < 0.0):
        theta = sizes * inner_ball(feasible.rows * sizes, feasible.bounds).centre
    for step in range(_ACROSS):
        away = rng.normal(size=theta.size) * sizes
        room = feasible.bounds - feasible.rows @ theta
        speed = feasible.rows @ away
        ahead = speed > 1e-9 * np.max(np.abs(speed))
        if not np.any(ahead):
            continue
        length = float(np.min(room[ahead] / speed[ahead]))
        share = 1.0 if step == _ACROSS - 1 else rng.random()
        theta = theta + share * length * away
    return theta


def _turning(
    design: LookupDesign, form: TreeLookup, node: int, plane: FloatArray, theta: FloatArray
) -> FloatArray:
    """The parameter that a node's height feels least, moved until the comparison turns over there:
    to where both sides are equal, if the scalar type has such a place."""
    dtype = design.precision.dtype
    own, given = form.rounded(dtype), theta.astype(dtype)
    felt = np.where(plane != 0.0, np.abs(plane) * np.spacing(np.abs(given)), np.inf)
    j = int(np.argmin(felt))

    def height(value: np.floating) -> float:
        moved = given.copy()
        moved[j] = value
        eta = image(own.matrix, own.offset, moved[None]) if own.matrix.size else moved[None]
        found = ordered_product(own.tree.normals[node : node + 1], eta)[0]
        return float(found) - float(own.tree.offsets[node])

    room = 1e3 * float(np.finfo(dtype).eps) * (1.0 + np.max(np.abs(plane * theta))) / abs(plane[j])
    low, high = dtype.type(given[j] - room), dtype.type(given[j] + room)
    rising = height(high) > 0.0
    if (height(low) > 0.0) == rising:
        return theta
    for _ in range(80):
        middle = dtype.type(0.5 * (float(low) + float(high)))
        excess = height(middle)
        if excess == 0.0 or middle in (low, high):
            given[j] = middle
            break
        low, high = (low, middle) if (excess > 0.0) == rising else (middle, high)
    result: FloatArray = given.astype(np.float64)
    return result


def facets_of(design: LookupDesign) -> tuple[FloatArray, FloatArray]:
    """All hyperplanes at which the lookup decides, rows theta = heights: nodes of the tree, the
    first clips of each variable, facets of the feasible set."""
    form, p = design.form, design.parameters
    matrix = form.matrix if form.matrix.size else np.eye(p)
    offset = form.offset if form.matrix.size else np.zeros(p)
    if isinstance(form, TreeLookup):
        normals, heights = form.tree.normals, form.tree.offsets
        if form.tree.mirror >= 0:
            normals = np.vstack([normals, np.eye(matrix.shape[0])[form.tree.mirror]])
            heights = np.append(heights, 0.0)
    else:
        eye = np.eye(matrix.shape[0])
        normals = np.vstack([eye, eye])
        heights = np.append(np.ones(len(eye)), -np.ones(len(eye)))
    rows = normals @ matrix if normals.size else np.zeros((0, p))
    bounds = heights - normals @ offset if normals.size else np.zeros(0)
    if design.feasible is not None:
        rows = np.vstack([rows, design.feasible.rows])
        bounds = np.concatenate([bounds, design.feasible.bounds])
    return rows, bounds


def directions(design: LookupDesign) -> FloatArray:
    """(p, r) what parameters make each coordinate of the lookup one, if that can be told; where its
    coordinates are the parameters, each by what moves the laws by a bound."""
    form = design.form
    if form.matrix.size:
        result: FloatArray = np.linalg.pinv(form.matrix)
        return result
    assert isinstance(form, TreeLookup)
    scale = [s for s in (*np.abs(design.low), *np.abs(design.high)) if np.isfinite(s) and s > 0.0]
    table = np.abs(form.gains.reshape(-1, form.gains.shape[2])) / max(scale, default=1.0)
    largest = np.max(table, axis=0)
    return np.diag(1.0 / np.where(largest > 0.0, largest, 1.0))


def on_planes(
    theta: FloatArray, planes: FloatArray, heights: FloatArray, back: FloatArray
) -> FloatArray:
    """``theta`` moved along the columns of ``back`` onto planes theta = heights, as far as they
    meet."""
    along = planes @ back
    lengths = np.linalg.norm(along, axis=1)
    used = lengths > 0.0
    short = (heights - planes @ theta)[used] / lengths[used]
    step = np.linalg.lstsq(along[used] / lengths[used, None], short, rcond=1e-9)[0]
    moved: FloatArray = theta + back @ step
    return moved


def _beside(
    rng: np.random.Generator, design: LookupDesign, theta: FloatArray, back: FloatArray
) -> FloatArray:
    """On it as far as the scalar type can say, a few roundings beside it, or a little more."""
    if rng.random() < 0.4:
        theta = theta + back @ rng.normal(size=back.shape[1]) * 10.0 ** -rng.uniform(1.0, 9.0)
    given = theta.astype(design.precision.dtype)
    i = int(rng.integers(given.size))
    given[i] += given.dtype.type(rng.choice(_BESIDE)) * np.spacing(given[i])
    result: FloatArray = given.astype(np.float64)
    return result
