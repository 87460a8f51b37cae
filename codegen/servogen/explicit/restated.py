"""A program written down once more over eta, from its own matrices: what its proofs stand on.

The coordinates are data, of whatever origin. That the program sees its parameters through them
alone is shown here, row by row; so is that the parameter set in them leaves no parameter out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.image import Image
from servogen.plants.statespace import FloatArray
from servogen.qp.parametric import ParametricQP
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise


@dataclass(frozen=True)
class Affine:
    """Functions slope eta + offset: (q, r), (q,); ``terms`` (q,) what the slopes are sums of."""

    slope: FloatArray
    offset: FloatArray
    terms: FloatArray


@dataclass(frozen=True)
class Restated:
    """min 1/2 z'Hz + (F t + f)'z subject to g z <= w + s t, t the parameters in columns' units.

    Attributes:
        hessian: (n, n), unit diagonal; linear: (n, p); constant: (n,).
        free, free_offset: (n, p), (n,): the optimum without constraints, free t + free_offset.
        g: (m, n) unit rows; w: (m,); s: (m, p); places: number of a constraint -> its row.
        sizes: (n,) a variable of the program is sizes z.
        matrix, shift: (r, p), (r,): eta = matrix t + shift, columns of unit length.
        inverse: (p, r), a right inverse of ``matrix``.
        columns: (p,) t = columns theta.
        domain_rows, domain_bounds: (q, r), (q,): the parameter set over eta, unit rows.
    """

    problem: ParametricQP
    hessian: FloatArray
    linear: FloatArray
    constant: FloatArray
    free: FloatArray
    free_offset: FloatArray
    g: FloatArray
    w: FloatArray
    s: FloatArray
    places: dict[int, int]
    sizes: FloatArray
    matrix: FloatArray
    shift: FloatArray
    inverse: FloatArray
    columns: FloatArray
    domain_rows: FloatArray
    domain_bounds: FloatArray

    @property
    def coordinates(self) -> int:
        """r, the length of eta."""
        return int(self.shift.size)

    def seen(
        self, slope: FloatArray, offset: FloatArray, terms: FloatArray | None = None
    ) -> tuple[Affine, float]:
        """slope t + offset over eta, and what of it eta does not show, as a share of its terms.

        Args:
            slope: (q, p); offset: (q,); terms: (q,) lengths of what ``slope`` is a sum of.
        """
        own = slope @ self.inverse
        lengths = np.linalg.norm(slope, axis=1) if terms is None else terms
        rest = np.max(np.abs(slope - own @ self.matrix), axis=1, initial=0.0)
        unseen = np.divide(rest, lengths, out=np.zeros_like(rest), where=lengths > 0.0)
        found = Affine(own, offset - own @ self.shift, lengths)
        return found, float(np.max(unseen, initial=0.0))

    def theta(self, eta: FloatArray) -> FloatArray:
        """(N, p) parameters of the program with the images ``eta`` (N, r)."""
        parameters: FloatArray = (eta - self.shift) @ self.inverse.T / self.columns
        return parameters

    def feasible_rows(self) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """a (q, n), b (q,), c (q, r): a y <= b + c eta, with y = z - z_unc in its own units, says
        that z is feasible; the parameter set is left out. See ``seen`` for the last."""
        slope, offset = self.free, self.free_offset
        terms = np.linalg.norm(np.abs(self.s) + np.abs(self.g) @ np.abs(slope), axis=1)
        over, unseen = self.seen(self.s - self.g @ slope, self.w - self.g @ offset, terms)
        # y such that its rows' bounds are about one, as those of eta are
        size = float(np.median(np.abs(over.offset))) if np.any(over.offset) else 1.0
        size = size or 1.0
        return self.g, over.offset / size, over.slope / size, unseen


def restate(
    problem: ParametricQP, image: Image, domain_rows: FloatArray, domain_bounds: FloatArray
) -> Restated:
    """The program over ``image``, with ``domain_rows`` eta <= ``domain_bounds`` for its domain."""
    columns = np.linalg.norm(image.matrix, axis=0)
    columns = np.where(columns > 0.0, columns, 1.0)
    matrix = image.matrix / columns
    sizes = 1.0 / np.sqrt(np.diag(problem.hessian))
    rows, bounds, parameter, numbers = problem.all_rows()
    scaled = rows * sizes
    lengths = np.linalg.norm(scaled, axis=1)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    hessian = problem.hessian * np.outer(sizes, sizes)
    linear, constant = problem.linear * sizes[:, None] / columns, problem.constant * sizes
    free = -np.linalg.solve(hessian, np.column_stack([linear, constant])).astype(np.float64)
    return Restated(
        problem=problem,
        hessian=hessian,
        linear=linear,
        constant=constant,
        free=free[:, :-1],
        free_offset=free[:, -1],
        g=scaled / lengths[:, None],
        w=bounds / lengths,
        s=parameter / lengths[:, None] / columns,
        places={int(number): row for row, number in enumerate(numbers)},
        sizes=sizes,
        matrix=matrix,
        shift=image.offset,
        inverse=np.linalg.pinv(matrix).astype(np.float64),
        columns=columns,
        domain_rows=domain_rows,
        domain_bounds=domain_bounds,
    )


def domain_excess(own: Restated) -> float:
    """How far a parameter of the program's domain may lie outside that over eta: a linear program
    in theta for each row; -inf where there is none."""
    rows, bounds = own.problem.domain_rows, own.problem.domain_bounds
    over = own.domain_rows @ own.matrix
    limits = own.domain_bounds - own.domain_rows @ own.shift
    worst = -np.inf
    for row, limit in zip(over, limits, strict=True):
        try:
            top = maximise(rows / own.columns, bounds, row).value if bounds.size else np.inf
        except SetError:
            return float("inf")  # the domain is empty: nothing is proved of it
        worst = max(worst, top - float(limit))
    return float(worst)
