"""Parameters that try a lookup: ordinary ones, on facets and next to them, far outside."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.lookup_design import LookupDesign
from servogen.explicit.lookup import TreeLookup
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# How far from a facet, in units of the last place of a parameter.
_BESIDE = (0, 0, 1, -1, 3, -20, 1000)


def lookup_calls(design: LookupDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    """``count`` calls of ``find``, a third of each kind, now and then one that is no number."""
    planes, heights = facets_of(design)
    back = directions(design)
    for index in range(count):
        theta: FloatArray = (
            back @ rng.normal(size=back.shape[1]) * float(rng.choice([0.1, 0.5, 1.0, 3.0]))
        )
        if index % 3 == 1 and heights.size:
            # several planes meet in the corners of thin regions
            some = rng.integers(heights.size, size=int(rng.integers(1, back.shape[1] + 1)))
            theta = _beside(rng, design, on_planes(theta, planes[some], heights[some], back), back)
        if index % 3 == 2:
            theta = theta * 10.0 ** rng.uniform(1.0, 9.0)
        if rng.random() < 0.02:
            theta[int(rng.integers(theta.size))] = rng.choice([np.nan, np.inf, -np.inf])
        yield Call("find", {"theta": theta})


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
