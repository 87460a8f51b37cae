"""What the contour controller is asked for: the weights of (7) and (8), and the end of the horizon.

A weight on the error across the contour alone, W = I - r r' with r along it, and one on the error
whole: Q = alpha I + beta W. Whatever the direction, alpha I <= Q <= Q_max = (alpha + beta) I.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from servogen.controllers.errors import DesignError
from servogen.precision import FloatArray


class Terminal(Enum):
    """H at the end of the preview: C'QC of the last point, without guarantee, or H_s(Q_max), the
    solution of the Riccati equation (16) for Q_max, with that of Theorem 1."""

    OUTPUT = "output"
    STATIONARY = "stationary"


@dataclass(frozen=True)
class ContourWeights:
    """alpha and beta of (7) per square metre, rho per squared unit of the inputs.

    Raises:
        DesignError: alpha or rho not above zero, beta below it, or one that is not finite. Without
            alpha no error along a straight contour would ever be corrected: an axis along it is not
            detectable, which Theorem 1 asks for.
    """

    tracking: float
    contour: float
    control: float

    def __post_init__(self) -> None:
        for key in ("tracking", "control"):
            value = getattr(self, key)
            if not (np.isfinite(value) and value > 0.0):
                raise DesignError(f"{key}_weight", value, "a number above zero")
        if not (np.isfinite(self.contour) and self.contour >= 0.0):
            raise DesignError("contour_weight", self.contour, "a number of zero or more")

    @property
    def largest(self) -> float:
        """alpha + beta, of Q_max."""
        return self.tracking + self.contour

    def output_weight(self, tangent: FloatArray) -> FloatArray:
        """(p, p) of (8) for a tangent (p,) of length one, or shorter where the contour turns: at
        length zero every error counts as one across it."""
        along = np.outer(tangent, tangent)
        result: FloatArray = self.largest * np.eye(tangent.size) - self.contour * along
        return result
