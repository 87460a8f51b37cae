"""The active-set method itself at many parameters, against the bound that its ways give.

The ways know nothing of rounding: where ``accept`` is near what the tables' precision leaves of a
row, the method computes its optimum again, once or up to the cap, or goes round in a circle. Trials
prove nothing, but one of them is enough to take a bound back.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from servogen.explicit.iteration_program import IterationProgram
from servogen.plants.statespace import FloatArray
from servogen.qp.active_set_factor import empty_set

SEED = 20264
# Parameters anywhere in the set, and in the ball of each of the longest pieces: rounding that costs
# one iteration in three hundred calls is met by them.
ANYWHERE, PER_PIECE = 600, 20


def iterations_taken(
    program: IterationProgram, sequence: Sequence[FloatArray] | FloatArray, cap: int
) -> list[int]:
    """Of calls one after the other with parameters (p,), the first with no set; up to the call that
    meets the cap."""
    work, taken = empty_set(program.tables), list[int]()
    for theta in sequence:
        taken.append(program.solve(theta, work, cap).iterations)
        if taken[-1] >= cap:
            break
    return taken


def most_taken(
    program: IterationProgram, sequences: Iterable[Sequence[FloatArray] | FloatArray], cap: int
) -> int:
    """The most of any call; no further once the cap is met."""
    most = 0
    for sequence in sequences:
        most = max(most, *iterations_taken(program, sequence, cap))
        if most >= cap:
            break
    return most


def points_inside(rows: FloatArray, bounds: FloatArray, middle: FloatArray) -> FloatArray:
    """(ANYWHERE, p) points of the bounded set {rows t <= bounds}, each on a line through the last.

    Every third is drawn towards ``middle`` (p,): at the rims of states and bounds few programs have
    a solution.
    """
    rng = np.random.default_rng(SEED)
    at, points = middle, np.empty((ANYWHERE, middle.size))
    for i in range(ANYWHERE):
        direction = rng.normal(size=middle.size)
        along, room = rows @ direction, bounds - rows @ at
        ahead, back = along > 0.0, along < 0.0
        most = max(np.min(room[ahead] / along[ahead]), 0.0)
        least = min(np.max(room[back] / along[back]), 0.0)
        at = at + rng.uniform(least, most) * direction
        share = 10.0 ** rng.uniform(-2.0, 0.0) if i % 3 == 2 else 1.0
        points[i] = middle + share * (at - middle)
    return points


def points_in_ball(centre: FloatArray, radius: float) -> FloatArray:
    """(PER_PIECE, p) points of a ball, its centre first."""
    rng = np.random.default_rng(SEED)
    away = rng.normal(size=(PER_PIECE, centre.size))
    length = np.sqrt(np.sum(away**2, axis=1))
    reach = max(radius, 0.0) * rng.uniform(size=PER_PIECE) / np.where(length > 0.0, length, 1.0)
    reach[0] = 0.0
    result: FloatArray = centre + away * reach[:, None]
    return result
