"""Tables of the dual active-set method that is emitted, rounded once to the target precision."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.precision import FloatArray, Precision
from servogen.qp.row_tables import RowTables
from servogen.qp.tolerances import DEPENDENT, DOUBT, FALLS, LARGE, ROUNDING


@dataclass(frozen=True)
class ActiveSetTables:
    """Tables in the target precision.

    Attributes:
        inverse: (N, N) H^-1.
        rows: A.
        norm: (m,) square root of a'H^-1 a of every row, for who judges the method from outside;
            it computes the squares of the rows that it meets.
        dependent: share of a'H^-1 a at or below which what the working set leaves of a row is
            taken for rounding.
        rounding: the same where there is no other way than to append it.
        falls: share of its norm by which a row must hold another one to fall with it.
        large, small: what the factor and the multipliers are kept within, and from what on is
            divided by: bounds for the proof of the emitted C.
        doubt: points whose squared distance is so many times the squared reach are taken for none.
        accept: violation of a bound that is accepted.
        cap: iterations.
        stores: whether H^-1 a of the rows of the set is kept: N^2 numbers, worth it where more than
            N rows do not bound single variables. Else z is one product with H^-1 away from the
            multipliers.
        triangle: whether the emitted C keeps one triangle of H^-1 only, where fewer than N rows do
            not bound single variables; a product with it costs about twice as much.
        unit: whether every row has a'H^-1 a = 1, up to what rounding it and H^-1 leaves, far below
            what it is asked for: then the squares of the rows of the set are not kept.
        keep: a working set of at least so many rows stays as it is at the next call, factor and
            all; a smaller one is shifted by one sample and factored anew.
        resumes: whether a call that ended at the cap can be gone on with by the next one.
    """

    inverse: FloatArray
    rows: RowTables
    norm: FloatArray
    dependent: np.floating
    rounding: np.floating
    falls: np.floating
    doubt: np.floating
    large: np.floating
    small: np.floating
    accept: np.floating
    cap: int
    stores: bool
    triangle: bool
    unit: bool
    keep: int
    resumes: bool


def active_set_tables(
    hessian: FloatArray, written: FloatArray, rows: RowTables, accept: float, cap: int,
    precision: Precision, unit: bool = False, resumes: bool = False,
) -> ActiveSetTables:  # fmt: skip
    """Tables of H (N, N) and A, ``written`` (m, N) out and as ``rows``; rounded once.

    A set is kept from half the variables on: to factor one anew costs its size times an iteration,
    and one that large belongs to a machine that stays at its limits, where the same rows hold at
    the next sample; a small one moves towards the present with the horizon.

    Args:
        unit: A was scaled to rows of a'H^-1 a = 1.
        resumes: see ``ActiveSetTables``.
    """
    # with a unit diagonal: a variable in metres beside one in nanometres costs no digits
    size = 1.0 / np.sqrt(np.diag(hessian))
    inverse = np.linalg.inv(hessian * np.outer(size, size))
    inverse = 0.5 * (inverse + inverse.T) * np.outer(size, size)
    norm = np.sqrt(np.einsum("ij,jk,ik->i", written, inverse, written))
    real = precision.dtype.type

    def rounded(values: FloatArray) -> FloatArray:
        array = np.ascontiguousarray(values, dtype=real)
        array.flags.writeable = False
        return array

    return ActiveSetTables(
        inverse=rounded(inverse),
        rows=rows,
        norm=rounded(norm),
        dependent=real(DEPENDENT[precision.name]),
        rounding=real(ROUNDING[precision.name]),
        falls=real(FALLS[precision.name]),
        doubt=real(DOUBT),
        large=real(LARGE[precision.name]),
        small=real(1.0 / LARGE[precision.name]),
        accept=real(accept),
        cap=cap,
        stores=rows.count - rows.alone > rows.variables,
        triangle=rows.count - rows.alone < rows.variables,
        unit=unit,
        keep=max(1, rows.variables // 2),
        resumes=resumes,
    )
