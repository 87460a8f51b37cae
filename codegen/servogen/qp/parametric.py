"""Strictly convex quadratic programs whose linear terms and bounds depend on a parameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.plants.statespace import FloatArray, read_only
from servogen.qp.errors import ProgramError
from servogen.qp.tolerances import CONVEXITY


@dataclass(frozen=True)
class ParametricQP:
    """min over z of 1/2 z'Hz + (F theta + f)'z subject to G z <= w + S theta, lower <= z <= upper.

    Constraints are numbered: the rows of G first, then the n upper bounds, then the n lower ones;
    active sets use these numbers. theta ranges over {D theta <= d}, over all if D has no row.

    Attributes:
        hessian: (n, n) H, symmetric positive definite.
        linear: (n, p) F; constant: (n,) f.
        rows: (m, n) G; bounds: (m,) w; bounds_parameter: (m, p) S. m may be 0.
        lower, upper: (n,), -inf and inf where there is no bound.
        domain_rows: (q, p) D; domain_bounds: (q,) d. q may be 0.
        first_move: leading entries of z that the law needs.
    """

    hessian: FloatArray
    linear: FloatArray
    constant: FloatArray
    rows: FloatArray
    bounds: FloatArray
    bounds_parameter: FloatArray
    lower: FloatArray
    upper: FloatArray
    domain_rows: FloatArray
    domain_bounds: FloatArray
    first_move: int

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            if name != "first_move":
                object.__setattr__(self, name, read_only(getattr(self, name)))
        _check_shapes(self)
        _check_numbers(self)

    @property
    def variables(self) -> int:
        """n, the length of z."""
        return int(self.hessian.shape[0])

    @property
    def parameters(self) -> int:
        """p, the length of theta."""
        return int(self.linear.shape[1])

    @property
    def bounded(self) -> npt.NDArray[np.bool_]:
        """(n,) which variables have two finite bounds."""
        return np.isfinite(self.lower) & np.isfinite(self.upper)

    @property
    def is_box(self) -> bool:
        """Whether bounds are the only constraints, both of a variable or none."""
        free = np.isinf(self.lower) & np.isinf(self.upper)
        whole = bool(np.all(self.bounded | free)) and bool(np.any(self.bounded))
        return self.rows.shape[0] == 0 and whole

    def unconstrained(self) -> tuple[FloatArray, FloatArray]:
        """-H^-1 F (n, p) and -H^-1 f (n,): the optimum without constraints is affine in theta."""
        both = np.column_stack([self.linear, self.constant])
        solved: FloatArray = -np.linalg.solve(self.hessian, both).astype(np.float64)
        return solved[:, :-1], solved[:, -1]

    def all_rows(self) -> tuple[FloatArray, FloatArray, FloatArray, npt.NDArray[np.int64]]:
        """G, w, S with the finite bounds as rows, and the number of each row's constraint."""
        n, p, m = self.variables, self.parameters, self.rows.shape[0]
        up, low = np.flatnonzero(np.isfinite(self.upper)), np.flatnonzero(np.isfinite(self.lower))
        eye = np.eye(n)
        g = np.vstack([self.rows, eye[up], -eye[low]])
        w = np.concatenate([self.bounds, self.upper[up], -self.lower[low]])
        s = np.vstack([self.bounds_parameter, np.zeros((up.size + low.size, p))])
        numbers = np.concatenate([np.arange(m), m + up, m + n + low])
        return g, w, s, numbers.astype(np.int64)


def parametric_qp(
    hessian: npt.ArrayLike,
    linear: npt.ArrayLike,
    *,
    constant: npt.ArrayLike | None = None,
    rows: npt.ArrayLike | None = None,
    bounds: npt.ArrayLike | None = None,
    bounds_parameter: npt.ArrayLike | None = None,
    lower: npt.ArrayLike | None = None,
    upper: npt.ArrayLike | None = None,
    domain_rows: npt.ArrayLike | None = None,
    domain_bounds: npt.ArrayLike | None = None,
    first_move: int = 1,
) -> ParametricQP:
    """A ``ParametricQP`` with what is not given left out: f = 0, S = 0, no bounds, no domain.

    Rows of G that only restate bounds of single variables (one entry, S zero) become ``lower`` and
    ``upper``, so that a box is recognised however it was written; rows of zeros limit theta alone
    and go to the domain. Constraint numbers count the rows that are left.

    Raises:
        ProgramError: shapes that do not fit, numbers that are not finite, H not positive definite,
            a lower bound not below the upper one, or ``first_move`` outside 1..n.
    """
    h, f = np.asarray(hessian, dtype=np.float64), np.asarray(linear, dtype=np.float64)
    if f.ndim != 2:
        raise ProgramError("linear", f"of shape {f.shape}", "a matrix (variables, parameters)")
    n, p = f.shape
    g = _or(rows, np.zeros((0, n)))
    w = _or(bounds, np.zeros(g.shape[0]))
    s = _or(bounds_parameter, np.zeros((g.shape[0], p)))
    low, high = _or(lower, np.full(n, -np.inf)), _or(upper, np.full(n, np.inf))
    shapes = g.ndim == 2 and g.shape[1] == n and w.shape == g.shape[:1] and s.shape == (len(g), p)
    if shapes and low.shape == (n,) and high.shape == (n,):
        g, w, s, low, high = _single_bounds(g, w, s, low, high)
    d = _or(domain_rows, np.zeros((0, p)))
    limits = _or(domain_bounds, np.zeros(d.shape[0]))
    if shapes and d.ndim == 2 and d.shape == (limits.size, p):
        alone = ~np.any(g, axis=1)
        empty = alone & ~np.any(s, axis=1)
        if np.any(empty & (w < 0.0)):
            i = int(np.flatnonzero(empty & (w < 0.0))[0])
            raise ProgramError("bounds of a row of zeros", float(w[i]), "0 or more")
        d, limits = np.vstack([d, -s[alone & ~empty]]), np.append(limits, w[alone & ~empty])
        g, w, s = g[~alone], w[~alone], s[~alone]
    f0 = _or(constant, np.zeros(n))
    return ParametricQP(h, f, f0, g, w, s, low, high, d, limits, first_move)


def parameter_box(lower: npt.ArrayLike, upper: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """D (2p, p) and d (2p,) of lower <= theta <= upper, (p,) each."""
    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    eye = np.eye(low.size)
    return np.vstack([eye, -eye]), np.concatenate([high, -low])


def _or(values: npt.ArrayLike | None, default: FloatArray) -> FloatArray:
    return default if values is None else np.array(values, dtype=np.float64)


def _single_bounds(
    g: FloatArray, w: FloatArray, s: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    low, high, kept = low.copy(), high.copy(), []
    for i in range(g.shape[0]):
        entries = np.flatnonzero(g[i])
        if entries.size != 1 or np.any(s[i]):
            kept.append(i)
            continue
        j = int(entries[0])
        bound = w[i] / g[i, j]
        if g[i, j] > 0.0:
            high[j] = min(high[j], bound)
        else:
            low[j] = max(low[j], bound)
    return g[kept], w[kept], s[kept], low, high


def _check_shapes(qp: ParametricQP) -> None:
    if qp.linear.ndim != 2 or qp.linear.shape[0] == 0:
        text = f"of shape {qp.linear.shape}"
        raise ProgramError("linear", text, "a matrix (variables, parameters)")
    n, p = qp.linear.shape
    m, q = qp.bounds.size, qp.domain_bounds.size
    wanted = {
        "hessian": (n, n), "constant": (n,), "rows": (m, n), "bounds": (m,),
        "bounds_parameter": (m, p), "lower": (n,), "upper": (n,), "domain_rows": (q, p),
        "domain_bounds": (q,),
    }  # fmt: skip
    for key, shape in wanted.items():
        found = getattr(qp, key).shape
        if found != shape:
            raise ProgramError(key, f"of shape {found}", f"shape {shape}")
    if not 1 <= qp.first_move <= n:
        raise ProgramError("first_move", qp.first_move, f"a number from 1 to {n}")


def _check_numbers(qp: ParametricQP) -> None:
    for name in ("hessian", "linear", "constant", "rows", "bounds", "bounds_parameter",
                 "domain_rows", "domain_bounds"):  # fmt: skip
        if not np.all(np.isfinite(getattr(qp, name))):
            raise ProgramError(name, "not finite", "finite numbers")
    if np.any(np.isnan(qp.lower)) or np.any(np.isnan(qp.upper)):
        raise ProgramError("lower and upper", "not a number", "numbers, or infinity for no bound")
    if not np.all(qp.lower < qp.upper):
        i = int(np.flatnonzero(~(qp.lower < qp.upper))[0])
        raise ProgramError(f"lower[{i}]", float(qp.lower[i]), f"less than {qp.upper[i]:g}")
    largest = float(np.max(np.abs(qp.hessian)))
    if np.max(np.abs(qp.hessian - qp.hessian.T)) > 1e-9 * largest:
        raise ProgramError("hessian", "not symmetric", "a symmetric matrix")
    diagonal = np.diag(qp.hessian)
    if not np.all(diagonal > 0.0):
        raise ProgramError("hessian", "not positive definite", "a positive diagonal")
    # units aside: a variable in mA beside one in A is no sign of a flat cost
    scaled = qp.hessian / np.sqrt(np.outer(diagonal, diagonal))
    eigenvalues = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    least = CONVEXITY["float64"]
    if eigenvalues[0] <= least * eigenvalues[-1]:
        expected = (
            f"a positive definite matrix (smallest eigenvalue above {least:g} of the largest, "
            "with a unit diagonal): a weight on every variable, here R > 0"
        )
        raise ProgramError("hessian", f"singular (eigenvalue {eigenvalues[0]:.3g})", expected)
