"""Programs with bounds on the variables alone: every region written down, none searched for.

In x = (z - middle) / half the program is min 1/2 (x - eta)'P(x - eta), -1 <= x <= 1, with eta the
unconstrained optimum. If eta takes every value of R^n, each of the 3^n patterns {free, upper,
lower} is a full-dimensional region: the free x_i, between their bounds, and the multipliers of the
others, not negative, are n independent quantities, each in an interval or a half-line of its own.
So no row is redundant and no linear program is needed. Variables without bounds are free in every
pattern and count for nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from servogen.explicit.image import scales
from servogen.explicit.problem import ParametricQP
from servogen.explicit.regions import MULTIPLIER, Candidate
from servogen.explicit.small_lp import Ball
from servogen.plants.statespace import FloatArray


def scaled_hessian(problem: ParametricQP) -> FloatArray:
    """P (n, n) of the box program in x, scaled to a largest diagonal entry of one."""
    half = scales(problem)[0]
    scaled = problem.hessian * np.outer(half, half)
    result: FloatArray = scaled / np.max(np.diag(scaled))
    return result


def patterns(bounded: int) -> Iterator[tuple[int, ...]]:
    """Active sets of all 3^n patterns, as places of rows: i for an upper bound, n + i a lower."""
    for pattern in product((None, 0, 1), repeat=bounded):
        chosen = [side * bounded + i for i, side in enumerate(pattern) if side is not None]
        yield tuple(sorted(chosen))


def middle_of(found: Candidate, bounded: int) -> Ball:
    """A point well inside the region of a pattern: free x_i in the middle, other slacks one."""
    rows, targets = [], []
    for i in range(bounded):
        mine = found.places % bounded == i
        held = mine & (found.kinds == MULTIPLIER)
        if np.any(held):
            row = int(np.flatnonzero(held)[0])
            rows.append(found.h[row])
            targets.append(found.k[row] - 1.0)
        else:
            above, below = (int(j) for j in np.flatnonzero(mine))
            rows.append(found.h[above])
            targets.append(0.5 * (found.k[above] - found.k[below]))
    solved = np.linalg.lstsq(np.array(rows), np.array(targets), rcond=None)[0]
    centre: FloatArray = solved.astype(np.float64)
    return Ball(centre, float(np.min(found.k - found.h @ centre)))
