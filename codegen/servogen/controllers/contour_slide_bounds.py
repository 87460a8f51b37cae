"""How large the numbers of the slides' system can become: a proof looks at them one at a time.

With M = L D L' positive definite: no entry of what is left of M after some columns is larger than
the largest of its diagonal, and with z = L^-1 b,  |z_k| <= |b| sqrt(d_k / price),  |z_k / d_k| and
|s_k| <= |b| / price, for the least price of the slides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.contour_lq_design import HIDDEN_BOUND, ContourLqDesign

# Of what follows from the inputs, so that no rounding gets there.
ROOM = 4.0


@dataclass(frozen=True)
class SlideBounds:
    """stiffest: of the matrix. farthest: of the right side and the slides, m."""

    stiffest: float
    farthest: float


def slide_bounds(design: ContourLqDesign) -> SlideBounds:
    """Of a design whose references may slide; each bound has ``ROOM``.

    Directions have a largest component of one, and one mirrored is as long: the sum of two is not
    longer than 2 sqrt(p).
    """
    longest = 2.0 * float(np.sqrt(len(design.axes)))
    # the stiffness is below one, and so is beta / q of the price
    stiffest = 2.0 * longest**2
    errors = sum(_error(design, index) for index in range(len(design.axes)))
    right = longest * float(np.sqrt(design.count)) * errors
    least = design.least_price
    most = max(float(np.sqrt(stiffest / least)), 1.0 / least)
    return SlideBounds(ROOM * stiffest, ROOM * right * most)


def _error(design: ContourLqDesign, index: int) -> float:
    """Largest error that a plan leaves, times beta / q, for a reference, a position and an estimate
    anywhere in their ranges."""
    axis, n = design.axes[index], design.preview
    largest = np.full(n + axis.model.order, HIDDEN_BOUND)
    largest[:n], largest[n] = 4.0 * design.reach, 3.0 * design.reach
    return float(np.max(np.abs(axis.tables.error) @ largest))
