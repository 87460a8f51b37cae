"""How far apart the weights on contour and tracking may be before a precision loses the latter.

The slides' matrix is price + sum_a T_a P_a T_a. Where the contour is straight its least eigenvalue
may be the price itself, alpha / q, while entries beside it are of the size of beta / q. Rounding
the tables P and each of the S eliminations moves the matrix by no more than S units in the last
place of those entries; what the factorisation at design time left of P comes on top. The tracking
weight is what the slides cost: where that is a quarter wrong, so is the lag that it holds.
"""

from __future__ import annotations

import numpy as np

from servogen.controllers.contour_weights import ContourWeights
from servogen.controllers.errors import DesignError
from servogen.precision import FLOAT64, Precision

# Largest share of the price that rounding may come to in the worst case. What was seen is a
# hundredth of such a bound.
SHARE_OF_PRICE = 0.25


def largest_ratio(precision: Precision, count: int, factorised: float) -> float:
    """beta / alpha up to which S = ``count`` slides are told.

    Args:
        factorised: relative error of the tables before they are rounded, see ``AxisTables``.
    """
    unit = float(np.finfo(precision.dtype).eps) + factorised
    return SHARE_OF_PRICE / (count * unit)


def check_ratio(
    weights: ContourWeights, precision: Precision, count: int, factorised: float
) -> None:
    """Nothing, where the precision carries both weights.

    Raises:
        DesignError: ``contour_weight`` too large beside ``tracking_weight``.
    """
    most = largest_ratio(precision, count, factorised)
    if weights.contour <= most * weights.tracking:
        return
    told = f"at most {most:.2g} times tracking_weight = {weights.tracking:g} in {precision.name}"
    wide = largest_ratio(FLOAT64, count, factorised)
    if precision.is_float32 and weights.contour <= wide * weights.tracking:
        told += "; float64 carries it"
    raise DesignError("contour_weight", weights.contour, told)
