"""Every tolerance of the quadratic programs, each with its reason.

Rows are scaled by their limits and positions are taken relative to the present one, so a tolerance
of 1e-6 means one millionth of a limit: 35 nm of a 35 mm fast-stage range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.precision import Precision


@dataclass(frozen=True)
class QpTolerances:
    """Attributes:
    margin: the bounds are drawn in by this much, so that an iterate that is feasible only up to
        ``accept`` is strictly feasible for the true bounds, and so is its shifted plan.
    accept: largest violation of the tightened bounds that is accepted; below ``margin``.
    gap: largest duality gap y'(w - G z) accepted, in units of the objective.
    floor: smallest dual of a warm start times Q_ii; PQP multiplies, so it cannot leave zero.
    vanish: smallest dual inside an iteration, times Q_ii: keeps (20) from dividing zero by zero.
    ceiling: largest dual times Q_ii; a dual that grows this far says the problem is infeasible.
    clamp: an extrapolation keeps at least this share of every dual.
    weight: duals with y_i Q_ii below this share of the largest do not limit the extrapolation.
    """

    margin: float
    accept: float
    gap: float
    floor: float = 1e-5
    vanish: float = 1e-14
    ceiling: float = 1e6
    clamp: float = 0.05
    weight: float = 1e-2


# Share of the margin that an accepted iterate may use up. In float64 the rows are exact to 1e-13;
# in float32 they are assembled to about 1e-6, so more of the margin stays in reserve.
_ACCEPT_SHARE = {"float64": 0.9, "float32": 0.5}
# Smallest margin that the arithmetic can resolve: eps times the row sums (about 60) times a few.
MINIMUM_MARGIN = {"float64": 1e-9, "float32": 1e-5}


def tolerances(
    precision: Precision, margin: float, gap_tolerance: float, hessian: np.ndarray, scale_m: float
) -> QpTolerances:
    """Tolerances of one condensed program.

    ``gap_tolerance`` is relative: a gap g bounds the cost above the optimum, and a command that is
    off by e costs about h e^2 / 2 with h the largest diagonal entry of the Hessian. So
    g = gap_tolerance * h * scale^2 / 2 stands for a command error of sqrt(gap_tolerance) * scale.

    Args:
        margin: requested margin, raised to what the precision resolves.
        hessian: (N, N), of the condensed cost.
        scale_m: the fast stage's range in metres.
    """
    used = max(margin, MINIMUM_MARGIN[precision.name])
    gap = gap_tolerance * 0.5 * float(np.max(np.diag(hessian))) * scale_m**2
    return QpTolerances(margin=used, accept=used * _ACCEPT_SHARE[precision.name], gap=gap)


# The Hessian's smallest eigenvalue relative to its largest, with a unit diagonal. A solve with the
# Hessian loses as many digits as the ratio has zeros: at these a multiplier has four of float64's
# sixteen left and three of float32's seven. In float32, of random programs whose gradient is H
# times a point, none was off by more than a thousandth of its answer at 1e-4, and some ended at
# the cap at 1e-5; at 5e-7 answers were off by up to 10 %, at 1e-8 by all of them, with status OK.
CONVEXITY = {"float64": 1e-12, "float32": 1e-4}
# Of a Hessian with a unit diagonal, between an entry and the one across: sums of products made in
# another order differ by less, and a matrix in which a number was mistyped by more.
SYMMETRY = 1e-9


@dataclass(frozen=True)
class DualMethodTolerances:
    """Of the dual active-set method, which works on rows of unit length in the metric of H.

    Attributes:
        violation: a row counts as kept up to this share of the size of its own terms, 100 roundings
            of which make no difference to an answer of nine digits.
        dependent: what is left of a row's unit length after projection off the active, squared;
            below it the row is a combination of them. A sum of up to 40 active rows rounds to about
            1e-14, and a row that stands off by more than 1e-6 is told from them: by less, its
            multiplier, which grows with the inverse square, has fewer than four digits. The
            exploration, which asks for no multiplier, goes farther (``QP_DEPENDENT``).
        steps: per row and variable; each adds or drops one row, and few are visited twice.
    """

    violation: float = 1e-13
    dependent: float = 1e-12
    steps: int = 10


# Of the active-set method that is emitted. What the working set leaves of a row (a pivot, as a
# share of the row's own norm squared) carries the roundings of up to N products of size one: some
# 1e-14 and 1e-6. Ten thousand and a hundred times that leave a multiplier four digits and two.
DEPENDENT = {"float64": 1e-10, "float32": 1e-4}
# Where no other row makes room for it, one that depends only nearly is appended all the same, down
# to what is rounding indeed: few digits of its multiplier are better than no answer, and the rows
# judge it.
ROUNDING = {"float64": 1e-13, "float32": 5e-7}
# A row of the set takes part in a dependent one if its share is more than the same roundings.
FALLS = {"float64": 1e-9, "float32": 1e-4}
# A row that no other one makes room for is infeasible beyond doubt where every point that keeps it
# is eight times farther away than all that is reckoned with: a digit, for what they have lost.
DOUBT = 8.0**2
# What its factor and multipliers are kept within; its inverse is the least that is divided by.
# Products of three such numbers, a thousand times over, are finite; rows of size one stay inside.
LARGE = {"float64": 2.0**330, "float32": 2.0**36}
