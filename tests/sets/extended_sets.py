"""The stage of paper 4 and its sets; the facts' setting takes some ten seconds to compute."""

import numpy as np

from servogen.plants.statespace import StateSpace
from servogen.plants.transfer import transfer_function
from servogen.sets.auxiliary import AuxiliaryDynamics
from servogen.sets.constraints import AxisLimits
from servogen.sets.extended import ExtendedSet, centred_limits, extended_set

T_S = 0.0356
LIMITS, CENTRE = centred_limits(0.0, 0.25, AxisLimits(1.0, 0.1, 10.0, 0.025))


def stage(pole: float) -> StateSpace:
    """p^3 / (s + p)^3 with states position, velocity, acceleration."""
    return transfer_function([pole**3], np.poly([-pole] * 3))


def paper_set(
    pole: float, auxiliary: AuxiliaryDynamics, sub_samples: int = 3, tightening: float = 0.005
) -> ExtendedSet:
    return extended_set(stage(pole), T_S, auxiliary, sub_samples, LIMITS, CENTRE, tightening)
