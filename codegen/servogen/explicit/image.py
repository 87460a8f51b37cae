"""The few coordinates eta = M theta + m in which a program sees its parameters.

The optimum moves with theta only through z_unc(theta) and the slacks of the rows there. With s =
L'(z - z_unc), H = L L', the program reads min 1/2 |s|^2 subject to g s <= w + e eta with unit rows
g: a projection. Regions, laws and trees live in eta. For input bounds alone eta is the
unconstrained optimum in shares of the bounds, +-1 at the bounds, whatever the units of theta.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
import numpy.typing as npt

from servogen.explicit.errors import ExplicitError
from servogen.explicit.tolerances import RANK, SAME_PLANE
from servogen.plants.statespace import FloatArray
from servogen.qp.parametric import ParametricQP

# Facets of the image of a parameter box beyond which the box is kept in its own coordinates.
MAX_IMAGE_FACETS = 600


@dataclass(frozen=True)
class Image:
    """eta = ``matrix`` theta + ``offset``: (r, p) and (r,); ``matrix`` has full row rank."""

    matrix: FloatArray
    offset: FloatArray

    @property
    def size(self) -> int:
        """r, how many coordinates."""
        return int(self.offset.size)

    def of(self, theta: FloatArray) -> FloatArray:
        """eta (..., r) of theta (..., p)."""
        image: FloatArray = theta @ self.matrix.T + self.offset
        return image


@dataclass(frozen=True)
class Canonical:
    """min 1/2 |s|^2 subject to g s <= w + e eta, z_first = unscale s + base eta + base_offset.

    Attributes:
        g: (m, n) unit rows; w: (m,); e: (m, r); numbers: (m,) of the constraints.
        unscale: (n, n), z - z_unc = unscale s.
        base, base_offset: (nu, r), (nu,): the first moves of z_unc.
        domain_rows, domain_bounds: (q, r), (q,): the parameters' set in eta, unit rows.
        image: eta of theta.
        box_optimum: the program is a box whose unconstrained optimum, in shares of the bounds, is
            eta and takes every value.
    """

    g: FloatArray
    w: FloatArray
    e: FloatArray
    numbers: npt.NDArray[np.int64]
    unscale: FloatArray
    base: FloatArray
    base_offset: FloatArray
    domain_rows: FloatArray
    domain_bounds: FloatArray
    image: Image
    box_optimum: bool


def canonical(problem: ParametricQP) -> Canonical:
    """The program as a projection, in the fewest coordinates of its parameters.

    A parameter set is projected on those coordinates where it is a box with an image of at most
    ``MAX_IMAGE_FACETS`` facets; otherwise eta keeps all parameters.

    Raises:
        ExplicitError: a row of G that is zero (``parametric_qp`` moves those to the domain), or no
            parameter that matters.
    """
    g, w, s, numbers = problem.all_rows()
    slope, offset = problem.unconstrained()
    factor = np.linalg.cholesky(problem.hessian)
    scaled = np.linalg.solve(factor, g.T).T if g.size else np.zeros((0, problem.variables))
    lengths = np.linalg.norm(scaled, axis=1)
    if np.any(lengths == 0.0):
        i = int(numbers[np.flatnonzero(lengths == 0.0)[0]])
        expected = "an entry that is not zero (limits on theta alone go to the domain)"
        raise ExplicitError(f"rows[{i}]", 0.0, expected)
    w_seen = (w - g @ offset) / lengths
    e_seen = (s - g @ slope) / lengths[:, None]
    size = _one(w_seen, numbers >= problem.rows.shape[0])
    nu = problem.first_move
    own = scaled_optimum(problem) if problem.is_box else None
    box = own is not None and _rank(own.matrix) == problem.variables
    image = own if box and own is not None else _image(problem, e_seen / size, slope / size)
    rows, bounds = _domain(problem, image)
    if rows is None:
        image, box = _all_parameters(problem), False
        rows, bounds = _domain(problem, image)
    assert rows is not None
    assert bounds is not None
    back = _right_inverse(image)
    return Canonical(
        g=scaled / lengths[:, None],
        w=(w_seen - e_seen @ back @ image.offset) / size,
        e=e_seen @ back / size,
        numbers=numbers,
        unscale=np.linalg.solve(factor.T, np.eye(problem.variables)) * size,
        base=slope[:nu] @ back,
        base_offset=offset[:nu] - slope[:nu] @ back @ image.offset,
        domain_rows=rows,
        domain_bounds=bounds,
        image=image,
        box_optimum=box,
    )


def _one(slacks: FloatArray, alone: npt.NDArray[np.bool_]) -> float:
    """What s is measured in: a typical slack of the bounds on single variables, of all rows where
    there are none.

    Limits of a plant's states may be a million times farther than its inputs reach in a horizon; in
    their measure every region between the inputs' bounds would count as flat.
    """
    for rows in (slacks[alone], slacks):
        if np.any(rows):
            return float(np.median(np.abs(rows[rows != 0.0])))
    return 1.0


def scales(problem: ParametricQP) -> tuple[FloatArray, FloatArray]:
    """Half the range (n,) and the middle (n,) of each variable of a box program.

    A variable without bounds gets the mean half range of the others, and 0.
    """
    bounded = problem.bounded
    lower = np.where(bounded, problem.lower, 0.0)
    upper = np.where(bounded, problem.upper, 0.0)
    half = 0.5 * (upper - lower)
    half[~bounded] = np.mean(half[bounded])
    return half, 0.5 * (upper + lower)


def scaled_optimum(problem: ParametricQP) -> Image:
    """The unconstrained optimum of a box program, +-1 at the bounds: (n, p), (n,), any rank."""
    slope, offset = problem.unconstrained()
    half, middle = scales(problem)
    return Image(slope / half[:, None], (offset - middle) / half)


def _rank(matrix: FloatArray) -> int:
    values = np.linalg.svd(_unit_columns(matrix)[0], compute_uv=False)
    return int(np.sum(values > RANK * values[0])) if values.size and values[0] > 0.0 else 0


def _image(problem: ParametricQP, e_seen: FloatArray, slope: FloatArray) -> Image:
    """The fewest coordinates through which the slacks and the first moves are seen."""
    # a first move as the slack of a bound on it alone would see it
    moves = np.eye(problem.variables)[:, : problem.first_move]
    lengths = np.linalg.norm(np.linalg.solve(np.linalg.cholesky(problem.hessian), moves), axis=0)
    first = slope[: problem.first_move] / lengths[:, None]
    seen = np.vstack([e_seen, first])
    unit, columns = _unit_columns(seen)
    _, values, right = np.linalg.svd(unit, full_matrices=False)
    rank = _rank(seen)
    if rank == 0:
        raise ExplicitError("linear and bounds_parameter", 0.0, "a parameter that matters")
    # mixed even where there are as many: parameters of which the slacks see nearly one combination
    # (positions and speeds over a few samples) would leave every region a needle
    matrix = _fixed_signs((values[:rank, None] * right[:rank]) * columns)
    # eta of unit size moves the slacks by about their own size
    image = np.linalg.lstsq(matrix.T, seen.T, rcond=None)[0].T
    matrix = matrix * np.linalg.norm(image, axis=0)[:, None] / np.sqrt(max(1, seen.shape[0]))
    return Image(matrix, np.zeros(rank))


def _unit_columns(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    columns = np.max(np.abs(matrix), axis=0)
    columns = np.where(columns > 0.0, columns, 1.0)
    return matrix / columns, columns


def _fixed_signs(matrix: FloatArray) -> FloatArray:
    """The same row space with the signs fixed: an SVD leaves them to the library."""
    largest = np.argmax(np.abs(matrix), axis=1)
    signs: FloatArray = np.sign(matrix[np.arange(matrix.shape[0]), largest])
    return matrix * signs[:, None]


def _all_parameters(problem: ParametricQP) -> Image:
    """Every parameter, scaled by the extent of a box or by the domain's rows."""
    columns = np.max(np.abs(problem.domain_rows / _bound_sizes(problem)[:, None]), axis=0)
    columns = np.where(columns > 0.0, columns, 1.0)
    return Image(np.diag(columns), np.zeros(problem.parameters))


def _bound_sizes(problem: ParametricQP) -> FloatArray:
    sizes = np.abs(problem.domain_bounds)
    return np.where(sizes > 0.0, sizes, 1.0)


def _right_inverse(image: Image) -> FloatArray:
    """(p, r) with M B = I, in columns of unit size so that units do not matter."""
    unit, columns = _unit_columns(image.matrix)
    inverse: FloatArray = np.linalg.pinv(unit, rcond=RANK) / columns[:, None]
    return inverse


def _domain(problem: ParametricQP, image: Image) -> tuple[FloatArray | None, FloatArray | None]:
    """The parameter set in eta; None where it cannot be said in so few coordinates."""
    if not problem.domain_bounds.size:
        return np.zeros((0, image.size)), np.zeros(0)
    if image.size == problem.parameters:
        rows = problem.domain_rows @ np.linalg.inv(image.matrix)
        return _unit_rows(rows, problem.domain_bounds + rows @ image.offset)
    seen = problem.domain_rows @ _right_inverse(image)
    lost = np.max(np.abs(seen @ image.matrix - problem.domain_rows), axis=1)
    if np.all(lost <= SAME_PLANE * np.max(np.abs(problem.domain_rows), axis=1)):
        return _unit_rows(seen, problem.domain_bounds + seen @ image.offset)
    box = _as_box(problem)
    if box is None or comb(problem.parameters, image.size - 1) > MAX_IMAGE_FACETS // 2:
        return None, None
    return _box_image(image, *box)


def _unit_rows(rows: FloatArray, bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
    lengths = np.linalg.norm(rows, axis=1)
    if np.any(lengths == 0.0):
        raise ExplicitError("domain_rows", "zero in one row", "rows that limit a parameter")
    return rows / lengths[:, None], bounds / lengths


def _as_box(problem: ParametricQP) -> tuple[FloatArray, FloatArray] | None:
    """Lower and upper limit of each parameter if the domain is a bounded box."""
    low = np.full(problem.parameters, -np.inf)
    high = np.full(problem.parameters, np.inf)
    for row, bound in zip(problem.domain_rows, problem.domain_bounds, strict=True):
        entries = np.flatnonzero(row)
        if entries.size != 1:
            return None
        j = int(entries[0])
        if row[j] > 0.0:
            high[j] = min(high[j], bound / row[j])
        else:
            low[j] = max(low[j], bound / row[j])
    if not (np.all(np.isfinite(low)) and np.all(np.isfinite(high))):
        return None
    if not np.all(low < high):
        raise ExplicitError("domain", "empty or flat", "lower limits below the upper ones")
    return low, high


def _box_image(image: Image, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Facets of {M theta + m : low <= theta <= high}: each is normal to r - 1 edges of the box."""
    edges = image.matrix * (0.5 * (high - low))  # (r, p), half edges
    centre = image.of(0.5 * (low + high))
    normals = _unit_normals(edges)
    reach = np.sum(np.abs(normals @ edges), axis=1)
    middle = normals @ centre
    return np.vstack([normals, -normals]), np.concatenate([middle + reach, reach - middle])


def _unit_normals(edges: FloatArray) -> FloatArray:
    """(facets, r): normals of all independent choices of r - 1 edges, opposite ones once."""
    r = edges.shape[0]
    lengths = np.linalg.norm(edges, axis=0)
    unit = edges[:, lengths > 0.0] / lengths[lengths > 0.0]
    chosen = np.array(list(combinations(range(unit.shape[1]), r - 1)), dtype=np.int64)
    if r == 1:
        return np.ones((1, 1))
    left, values, _ = np.linalg.svd(unit.T[chosen].transpose(0, 2, 1), full_matrices=True)
    normals = left[values[:, -1] > SAME_PLANE, :, -1]
    largest = np.argmax(np.abs(normals), axis=1)
    normals = normals * np.sign(normals[np.arange(normals.shape[0]), largest])[:, None]
    kept: list[int] = []
    for i in range(normals.shape[0]):
        if not kept or np.min(np.max(np.abs(normals[kept] - normals[i]), axis=1)) > SAME_PLANE:
            kept.append(i)
    result: FloatArray = normals[kept]
    return result
