"""Parallel quadratic programming (20)-(21) on two-sided rows: the reference of the emitted solver.

The dual of (19) is min 1/2 y'Q_d y + F_d'y over y >= 0. With rows in pairs, low <= A z <= high,
Q_d = [[D, -D], [-D, D]] with D = A H^-1 A'. Write s = y_u + y_l and d = y_u - y_l; then

    Q_d^+ y = (|D| s +- D d) / 2,   Q_d^- y = (|D| s -+ D d) / 2   (+ for upper, - for lower),

so that one product with |D| and one with D replace four, and D d = A (H^-1 A' d) has rank N. The
inner factor t = H^-1 A' d is the primal correction of (21), z = z_unc - t, and the slacks of the
rows are F_d + Q_d y: feasibility and the duality gap y'(w - G z) cost nothing. A and A' are never
multiplied as matrices: both know their structure (``row_tables``).

Instead of |D| s stands a bound u >= |D| s. It adds the same to numerator and denominator of (20),
as phi does, and any such addition keeps the dual monotone. Two things make u cheap:
  * the same row of four successive steps shares a column: w_j = sqrt(D_jj), c_i the largest of the
    four |D_ij| / w_j, times the sum of the four w_j s_j. As |D_ij| <= w_i w_j, the column gives a
    row for itself what |D| gives;
  * max(s, 2 floor) for s: a pair of duals that has come down to the floor of warm starts is frozen
    there as far as u is concerned. What all floors give is a table, and only columns with a pair
    above its floor are multiplied.

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
from servogen.qp.row_tables import RowTables
from servogen.qp.tolerances import QpTolerances

# Steps whose rows share a column. With four, closed loops and programs of twenty active rows take
# up to a tenth more iterations than with one; with twenty, the latter take up to twice as many.
TOGETHER = 4


@dataclass(frozen=True)
class PqpTables:
    """Tables of the iteration, in the target precision.

    Attributes:
        rows: A, as it is multiplied. inverse: (N, N) = H^-1.
        columns: (c, m) of the bound on |D| s; the rows of 4 ``blocks`` steps, ``per_step`` each,
            share them, every row after these has its own. root_diagonal: (m,), of D.
        at_floor: (m,) the bound at s = 2 floor.
        diagonal, inverse_diagonal: (m,) of D.
        phi_diagonal: (m,) = phi D_ii.
        floor, vanish, ceiling: (m,) dual bounds, each of the tolerance over D_ii.
        least_step: two duals, both at least the least ``vanish``, are equal or differ by more.
        least_curvature, longest: the exact line search divides by at least the one and goes at
            most the other: the square roots of the smallest normal and of the largest number, so
            that the quotient of a slope and its product with a dual stay in the type's range.
        period: turns per cycle; 0 and 1 for plain (20), 2 without extrapolation.
        cap: iterations.
    """

    rows: RowTables
    inverse: FloatArray
    columns: FloatArray
    root_diagonal: FloatArray
    at_floor: FloatArray
    per_step: int
    blocks: int
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
    matrix: FloatArray,
    rows: RowTables,
    phi: float,
    period: int,
    cap: int,
    tol: QpTolerances,
    dtype: np.dtype[np.floating],
    per_step: int = 0,
    steps: int = 0,
) -> PqpTables:
    """Tables from H (N, N) and A = ``matrix`` (m, N), computed in float64 and rounded once.

    Args:
        rows: the same rows in the tables' precision.
        per_step, steps: the first rows are those of so many steps, alike in each.
    """
    dual = matrix @ np.linalg.solve(hessian, matrix.T)
    dual = 0.5 * (dual + dual.T)
    inverse = np.linalg.inv(hessian)
    diagonal = np.diag(dual).copy()

    def cast(values: FloatArray) -> FloatArray:
        array = np.ascontiguousarray(values, dtype=dtype)
        array.flags.writeable = False
        return array

    floor, vanish, real = tol.floor / diagonal, cast(tol.vanish / diagonal), dtype.type
    blocks, root = steps // TOGETHER, np.sqrt(diagonal)
    columns = _merged(np.abs(dual) / root[:, None], per_step, blocks, np.maximum)
    at_floor = _merged(root * 2.0 * floor, per_step, blocks, np.add) @ columns
    return PqpTables(
        rows=rows,
        inverse=cast(0.5 * (inverse + inverse.T)),
        columns=cast(columns),
        root_diagonal=cast(root),
        at_floor=cast(at_floor),
        per_step=per_step,
        blocks=blocks,
        diagonal=cast(diagonal),
        inverse_diagonal=cast(1.0 / diagonal),
        phi_diagonal=cast(phi * diagonal),
        floor=cast(floor),
        vanish=vanish,
        ceiling=cast(tol.ceiling / diagonal),
        # both are multiples of the spacing of the numbers at vanish, which is above vanish eps / 2
        least_step=real(0.25 * float(np.finfo(dtype).eps) * float(np.min(vanish))),
        least_curvature=real(np.sqrt(float(np.finfo(dtype).tiny))),
        longest=real(np.sqrt(float(np.finfo(dtype).max))),
        period=period,
        cap=cap,
    )


def _merged(rows: FloatArray, per_step: int, blocks: int, merge: np.ufunc) -> FloatArray:
    """The same row of every four steps merged in their order, those after the ``blocks`` as they
    are."""
    end = TOGETHER * blocks * per_step
    four = rows[:end].reshape(blocks, TOGETHER, per_step, *rows.shape[1:])
    merged = merge.accumulate(four, axis=1)[:, -1].reshape(-1, *rows.shape[1:])
    return np.concatenate([merged, rows[end:]])


def shift_duals(
    y: FloatArray, per_step: int, terminal: int, floor: FloatArray, ceiling: FloatArray
) -> FloatArray:
    """Duals of the last program, one step on; the last step repeats, terminal rows keep theirs.
    Each stays between the ``floor`` and the ``ceiling`` of its new row."""
    stage = y.size - terminal
    shifted = y.copy()
    shifted[: stage - per_step] = y[per_step:stage]
    return np.minimum(np.maximum(shifted, floor), ceiling)


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
    real = tables.diagonal.dtype.type
    accept, gap_limit = real(tol.accept), real(tol.gap)
    last_upper, last_lower = upper, lower
    last_change = np.zeros_like(upper)
    turn = 0
    correction = np.zeros(tables.rows.variables, dtype=real)
    feasible = converged = False
    iteration = 0
    for iteration in range(1, tables.cap + 1):
        correction = matvec(tables.inverse, tables.rows.adjoint(upper - lower))
        change = tables.rows.product(correction)  # D d
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
            last_upper, last_lower, last_change = upper, lower, change
            upper, lower = _multiply(tables, slack_upper, slack_lower, change, upper, lower)
        turn = turn + 1 if turn + 1 < tables.period else 0
    return PqpResult(correction, upper, lower, iteration, feasible, converged)


def _multiply(
    tables: PqpTables, slack_upper: FloatArray, slack_lower: FloatArray, change: FloatArray,
    upper: FloatArray, lower: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """A turn of (20), with ``change`` = D d (m,)."""
    zero, half = change.dtype.type(0.0), change.dtype.type(0.5)
    absolute = _majorant(tables, upper, lower)
    plus = np.maximum(half * (absolute + change), zero)
    minus = np.maximum(half * (absolute - change), zero)
    sides = []
    for y, slack, raising, lowering in (
        (upper, slack_upper, minus, plus),
        (lower, slack_lower, plus, minus),
    ):
        keep = tables.phi_diagonal * y
        over = raising + keep + np.maximum(-slack, zero)
        under = lowering + keep + np.maximum(slack, zero)
        sides.append(np.minimum(np.maximum(y * over / under, tables.vanish), tables.ceiling))
    return sides[0], sides[1]


def _majorant(tables: PqpTables, upper: FloatArray, lower: FloatArray) -> FloatArray:
    """u >= |D| (``upper`` + ``lower``), (m,)."""
    pair = (upper + lower) - (tables.floor + tables.floor)
    above = tables.root_diagonal * np.maximum(pair, upper.dtype.type(0.0))
    shared = _merged(above, tables.per_step, tables.blocks, np.add)
    terms = np.vstack([tables.at_floor, tables.columns * shared[:, None]])
    result: FloatArray = np.add.accumulate(terms, axis=0)[-1]
    return result


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
    length = min(-slope, tables.longest) / max(curvature, tables.least_curvature)
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
