"""Parallel quadratic programming (20)-(21) on two-sided rows: the reference of the emitted solver.

The dual of (19) is min 1/2 y'Q_d y + F_d'y over y >= 0. With rows in pairs, low <= A z <= high,
Q_d = [[D, -D], [-D, D]] with D = A H^-1 A'. Write s = y_u + y_l and d = y_u - y_l; then

    Q_d^+ y = (|D| s +- D d) / 2,   Q_d^- y = (|D| s -+ D d) / 2   (+ for upper, - for lower),

so that one product with |D| and one with D replace four, and D d = A (H^-1 A' d) has rank N. The
inner factor t = H^-1 A' d is the primal correction of (21), z = z_unc - t, and the slacks of the
rows are F_d + Q_d y: feasibility and the duality gap y'(w - G z) cost nothing.

Three kinds of turns, in a fixed cycle, all on the same products:
  * PQP (20), phi_i = phi Q_ii: any phi > 0 keeps the dual monotone;
  * coordinate: the exact minimum along the dual of the most violated row. Monotone too, and it
    revives a multiplier that (20) has driven to nothing and could only double step by step;
  * extrapolation: exact line search along the last PQP step, with the duals that matter kept
    positive. Its clamp lies outside the proof of (20): the cap and the backup stay.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.ordered import dot, matvec, total
from servogen.qp.tolerances import QpTolerances


@dataclass(frozen=True)
class PqpTables:
    """Tables of the iteration, in the target precision.

    Attributes:
        rows_columns: (N, m) = A'; inverse_columns: (m, N) = (H^-1 A')'.
        absolute: (m, m) = |D|; diagonal, inverse_diagonal: (m,) of D.
        phi_diagonal: (m,) = phi D_ii.
        floor, vanish, ceiling: (m,) dual bounds, each of the tolerance over D_ii.
        least_step: two duals, both at least the least ``vanish``, are equal or differ by more.
        least_curvature, longest: the exact line search divides by at least the one and goes at
            most the other: the square roots of the smallest normal and of the largest number, so
            that the quotient of a slope and its product with a dual stay in the type's range.
        period: turns per cycle; 0 and 1 for plain (20), 2 without extrapolation.
        cap: iterations.
    """

    rows_columns: FloatArray
    inverse_columns: FloatArray
    absolute: FloatArray
    diagonal: FloatArray
    inverse_diagonal: FloatArray
    phi_diagonal: FloatArray
    floor: FloatArray
    vanish: FloatArray
    ceiling: FloatArray
    least_step: np.floating
    least_curvature: np.floating
    longest: np.floating
    period: int
    cap: int

    @property
    def coordinates(self) -> bool:
        """Coordinate turns only raise duals; turns of (20) between them must let them down."""
        return self.period > 1

    @property
    def extrapolates(self) -> bool:
        """An extrapolation needs a turn of (20) right before it, after the coordinate turn."""
        return self.period > 2


@dataclass
class PqpResult:
    """``correction``: (N,) t of z = z_unc - t; duals y_u, y_l: (m,); ``feasible`` and
    ``converged`` tell whether the last iterate passed the feasibility and the gap test;
    ``iterations`` counts the evaluated iterates, at most the cap."""

    correction: FloatArray
    upper: FloatArray
    lower: FloatArray
    iterations: int
    feasible: bool
    converged: bool


def pqp_tables(
    hessian: FloatArray,
    rows: FloatArray,
    phi: float,
    period: int,
    cap: int,
    tol: QpTolerances,
    dtype: np.dtype[np.floating],
) -> PqpTables:
    """Tables from H (N, N) and A (m, N), computed in float64 and rounded once."""
    inverse_rows = np.linalg.solve(hessian, rows.T)  # (N, m)
    dual = rows @ inverse_rows
    dual = 0.5 * (dual + dual.T)
    diagonal = np.diag(dual).copy()

    def cast(values: FloatArray) -> FloatArray:
        array = np.ascontiguousarray(values, dtype=dtype)
        array.flags.writeable = False
        return array

    vanish, real = cast(tol.vanish / diagonal), dtype.type
    return PqpTables(
        rows_columns=cast(rows.T),
        inverse_columns=cast(inverse_rows.T),
        absolute=cast(np.abs(dual)),
        diagonal=cast(diagonal),
        inverse_diagonal=cast(1.0 / diagonal),
        phi_diagonal=cast(phi * diagonal),
        floor=cast(tol.floor / diagonal),
        vanish=vanish,
        ceiling=cast(tol.ceiling / diagonal),
        # both are multiples of the spacing of the numbers at vanish, which is above vanish eps / 2
        least_step=real(0.25 * float(np.finfo(dtype).eps) * float(np.min(vanish))),
        least_curvature=real(np.sqrt(float(np.finfo(dtype).tiny))),
        longest=real(np.sqrt(float(np.finfo(dtype).max))),
        period=period,
        cap=cap,
    )


def shift_duals(y: FloatArray, per_step: int, terminal: int, floor: FloatArray) -> FloatArray:
    """Duals of the last program, one step on; the last step repeats, terminal rows keep theirs."""
    stage = y.size - terminal
    shifted = y.copy()
    shifted[: stage - per_step] = y[per_step:stage]
    return np.maximum(shifted, floor)


def solve(
    tables: PqpTables,
    tol: QpTolerances,
    slack_upper: FloatArray,
    slack_lower: FloatArray,
    upper: FloatArray,
    lower: FloatArray,
) -> PqpResult:
    """Minimise the dual from (``upper``, ``lower``), all (m,), in the tables' precision.

    Args:
        slack_upper, slack_lower: (m,) F_d, the slacks of the tightened bounds at the
            unconstrained optimum.
    """
    real = tables.absolute.dtype.type
    accept, gap_limit = real(tol.accept), real(tol.gap)
    zero, half = real(0.0), real(0.5)
    negative_upper = np.maximum(-slack_upper, zero)
    negative_lower = np.maximum(-slack_lower, zero)
    positive_upper = np.maximum(slack_upper, zero)
    positive_lower = np.maximum(slack_lower, zero)
    last_upper, last_lower = upper, lower
    last_change = np.zeros_like(upper)
    turn = 0
    correction = np.zeros(tables.rows_columns.shape[0], dtype=real)
    feasible = converged = False
    iteration = 0
    for iteration in range(1, tables.cap + 1):
        correction = matvec(tables.inverse_columns, upper - lower)
        change = matvec(tables.rows_columns, correction)  # D d
        r_upper = slack_upper + change
        r_lower = slack_lower - change
        slacks = np.stack([r_upper, r_lower], axis=1).ravel()
        worst = int(np.argmin(slacks))
        feasible = bool(slacks[worst] >= -accept)
        gap = total(upper * r_upper + lower * r_lower)
        converged = feasible and bool(gap <= gap_limit)
        if converged or iteration == tables.cap:
            break
        if tables.coordinates and turn == 0 and not feasible:
            upper, lower = _coordinate(tables, upper, lower, slacks, worst)
        elif tables.extrapolates and turn == tables.period - 1:
            upper, lower = _extrapolate(
                tables, tol, upper, lower, last_upper, last_lower, change - last_change,
                r_upper, r_lower,
            )  # fmt: skip
        else:
            absolute = matvec(tables.absolute, upper + lower)
            plus = np.maximum(half * (absolute + change), zero)
            minus = np.maximum(half * (absolute - change), zero)
            keep_upper = tables.phi_diagonal * upper
            keep_lower = tables.phi_diagonal * lower
            last_upper, last_lower, last_change = upper, lower, change
            upper = (
                upper * (minus + keep_upper + negative_upper) / (plus + keep_upper + positive_upper)
            )
            lower = (
                lower * (plus + keep_lower + negative_lower) / (minus + keep_lower + positive_lower)
            )
            upper = np.minimum(np.maximum(upper, tables.vanish), tables.ceiling)
            lower = np.minimum(np.maximum(lower, tables.vanish), tables.ceiling)
        turn = turn + 1 if turn + 1 < tables.period else 0
    return PqpResult(correction, upper, lower, iteration, feasible, converged)


def _coordinate(
    tables: PqpTables, upper: FloatArray, lower: FloatArray, slacks: FloatArray, worst: int
) -> tuple[FloatArray, FloatArray]:
    """Exact minimum along the dual of the most violated row: y_i - r_i / Q_ii."""
    row = worst // 2
    target = (upper if worst % 2 == 0 else lower).copy()
    raised = target[row] - slacks[worst] * tables.inverse_diagonal[row]
    target[row] = min(max(raised, tables.vanish[row]), tables.ceiling[row])
    return (target, lower) if worst % 2 == 0 else (upper, target)


def _extrapolate(
    tables: PqpTables,
    tol: QpTolerances,
    upper: FloatArray,
    lower: FloatArray,
    last_upper: FloatArray,
    last_lower: FloatArray,
    change: FloatArray,
    r_upper: FloatArray,
    r_lower: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Line search from y along p = y - y_last; ``change`` = D (p_u - p_l), (m,).

    The ratio test looks at duals with y_i Q_ii above a share of the largest only: small ones are
    on their way out and may be clamped.
    """
    real = upper.dtype.type
    step_upper = upper - last_upper
    step_lower = lower - last_lower
    curvature = dot(step_upper - step_lower, change)
    slope = total(step_upper * r_upper + step_lower * r_lower)
    if not (slope < real(0.0) and curvature > real(0.0)):
        return upper, lower
    length = -slope / max(curvature, tables.least_curvature)
    length = min(max(length, real(0.0)), tables.longest)
    weight_upper, weight_lower = upper * tables.diagonal, lower * tables.diagonal
    level = real(tol.weight) * max(np.max(weight_upper), np.max(weight_lower))
    room = real(1.0) - real(tol.clamp)
    for y, step, weight in (
        (upper, step_upper, weight_upper),
        (lower, step_lower, weight_lower),
    ):
        limits = (step < -tables.least_step) & (weight >= level)
        if np.any(limits):
            length = min(length, np.min(room * y[limits] / -step[limits]))
    clamp = real(tol.clamp)
    new_upper = np.maximum(upper + length * step_upper, clamp * upper)
    new_lower = np.maximum(lower + length * step_lower, clamp * lower)
    return (
        np.minimum(np.maximum(new_upper, tables.vanish), tables.ceiling),
        np.minimum(np.maximum(new_lower, tables.vanish), tables.ceiling),
    )
