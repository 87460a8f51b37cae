"""Feed drives of the machining centre of paper 2, as identified: 2 kHz, velocity command to metres.

The print lost two minus signs in the y block, which is unstable without them: A(6,6) = -0.0227 and
A(7,8) = -4.2149 of the whole matrix. With both back its modes are 1.00004, 0.6423 +- 0.4575j and
0.2230 +- 0.7946j; no single sign does that.
"""

from __future__ import annotations

import numpy as np

from servogen.plants.statespace import Discrete

SAMPLE_TIME_S = 0.0005
# The columns of B are printed in this unit.
INPUT_UNIT = 1e-5

_X_A = (
    (-0.2916, 0.2755, -0.8029),
    (-0.8890, 1.6565, -0.8540),
    (0.0000, 1.0343, 0.3324),
)
_X_B = (-0.0379, 0.5879, 0.0402)
_Y_A = (
    (0.5109, 0.5102, 1.1644, 0.9037, -0.9856),
    (-0.7566, 0.7378, 0.7638, 0.9284, -1.5212),
    (0.0000, 0.0344, -0.0227, 0.9665, -0.2304),
    (0.0000, 0.0000, 1.6801, 2.1797, -4.2149),
    (0.0000, 0.0000, 0.0000, 0.9843, -0.6750),
)
_Y_B = (0.2101, 0.2655, 0.1732, 0.6884, 0.0332)


def machining_centre() -> tuple[Discrete, Discrete]:
    """The x and the y axis, of orders 3 and 5: the input is the drive's velocity command in its own
    unit (0.0226 m/s each), the output the position in metres, the last state of either."""
    return _axis(_X_A, _X_B), _axis(_Y_A, _Y_B)


def _axis(a: tuple[tuple[float, ...], ...], b: tuple[float, ...]) -> Discrete:
    order = len(b)
    return Discrete(np.array(a), np.array(b) * INPUT_UNIT, np.eye(order)[-1], SAMPLE_TIME_S)
