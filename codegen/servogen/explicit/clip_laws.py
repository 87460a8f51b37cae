"""The numbers of the recursive clips, proved from the program's own matrices.

Clips are affine between their kinks. The optimum of a box is too, with a law for each pattern of
{free, upper, lower}, known in closed form, as are points inside the pattern's region. There the
clips have to give the optimum and its law: the law of the point's surroundings, differentiated
through every clip. That the kinks between lie where the optimum's do is the theorem's part
(``clips.py``); what it needs are these numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.explicit.clips import RecursiveClips
from servogen.plants.statespace import FloatArray
from servogen.qp.parametric import ParametricQP

# Patterns up to which all are asked, six variables; of more, as many evenly apart.
MOST_PATTERNS = 729
# How far multipliers move the unconstrained optimum, in half widths of the bounds: which of the
# inner clips are at their bounds within one pattern depends on that.
DEPTHS = (0.1, 1.0, 10.0)

IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class ClipLaws:
    """What was found of the recursive clips.

    Attributes:
        error: greatest difference of a coefficient from the program's own, relative to the largest
            of its table, and of an optimum or a coefficient of its law, in half widths.
        patterns: that were asked; complete: whether that is all of them.
    """

    error: float
    patterns: int
    complete: bool


def prove_clips(problem: ParametricQP, clips: RecursiveClips) -> ClipLaws:
    """The coordinates, the bounds, and the law of every pattern.

    Args:
        problem: two finite bounds on every variable and no other constraint.
    """
    n, nu = problem.variables, problem.first_move
    half = 0.5 * (problem.upper - problem.lower)
    middle = 0.5 * (problem.upper + problem.lower)
    slope, offset = problem.unconstrained()
    affine = (clips.coefficients, clips.matrix, clips.offset)
    tables = (*affine, clips.half, clips.middle, clips.lower, clips.upper)
    if not all(np.all(np.isfinite(table)) for table in tables):
        return ClipLaws(np.inf, 0, False)
    error = max(
        _apart(clips.matrix, slope / half[:, None]),
        _apart(clips.offset, (offset - middle) / half),
        _apart(clips.half, half[:nu]),
        _apart(clips.middle, middle[:nu]),
        _apart(clips.lower, problem.lower[:nu]),
        _apart(clips.upper, problem.upper[:nu]),
    )
    count = 3**n
    asked = min(count, MOST_PATTERNS)
    patterns = _patterns(np.arange(asked) * count // asked, n)
    hessian = problem.hessian * np.outer(half, half)
    wanted = [_optimum(hessian, pattern) for pattern in patterns]
    found, laws = _differentiated(clips, np.vstack([points for points, _, _ in wanted]))
    optima = np.repeat([x[:nu] for _, x, _ in wanted], len(DEPTHS), axis=0)
    slopes = np.repeat([law[:nu] for _, _, law in wanted], len(DEPTHS), axis=0)
    off = max(float(np.max(np.abs(found - optima))), float(np.max(np.abs(laws - slopes))))
    return ClipLaws(max(error, off), asked, asked == count)


def _patterns(numbers: IntArray, n: int) -> IntArray:
    """(N, n) of -1, 0 and 1: the digits of ``numbers``."""
    digits: IntArray = (numbers[:, None] // 3 ** np.arange(n)) % 3 - 1
    return digits


def _optimum(hessian: FloatArray, pattern: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points eta of a pattern's region, their one optimum x, and dx / deta (n, n).

    Of min (x - eta)'P(x - eta), |x_i| <= 1, with the free x_i between their bounds and multipliers
    of the others that are not zero: eta = x + P^-1 (multipliers).
    """
    n, held = pattern.size, np.flatnonzero(pattern)
    bordered = np.zeros((n + held.size, n + held.size))
    bordered[:n, :n] = hessian
    bordered[np.arange(held.size) + n, held] = bordered[held, np.arange(held.size) + n] = 1.0
    inverse = np.linalg.inv(hessian)
    law: FloatArray = np.linalg.solve(
        bordered, np.vstack([hessian, np.zeros((held.size, n))])
    )[:n].astype(np.float64)  # fmt: skip
    law[held] = 0.0
    # not in the middle, where one wrong law may cross the right one
    inside = 0.2 * np.cos(1.0 + 2.3 * np.arange(n))
    x = np.where(pattern == 0, inside, pattern)
    moved = [depth * inverse @ (pattern / np.diag(inverse)) for depth in DEPTHS]
    return x + np.array(moved), x, law


def _differentiated(clips: RecursiveClips, eta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(N, nu) the clips' x of the first moves at ``eta`` (N, n), and (N, nu, n) dx / deta."""
    count, n = eta.shape
    delta, slope = np.zeros((count, n)), np.zeros((count, n, n))
    found, laws = np.zeros((count, clips.moves.size)), np.zeros((count, clips.moves.size, n))
    unit = np.eye(n)
    for s, i in enumerate(clips.index):
        x = eta[:, i] + delta @ clips.coefficients[s]
        along = unit[i] + np.einsum("j,njk->nk", clips.coefficients[s], slope)
        along = np.where(np.abs(x)[:, None] < 1.0, along, 0.0)
        x = np.clip(x, -1.0, 1.0)
        delta[:, i], slope[:, i] = x - eta[:, i], along - unit[i]
        for move in np.flatnonzero(clips.moves == s):
            found[:, move], laws[:, move] = x, along
    return found, laws


def _apart(found: FloatArray, wanted: FloatArray) -> float:
    if found.shape != wanted.shape:
        return float("inf")
    largest = float(np.max(np.abs(wanted), initial=0.0)) or 1.0
    return float(np.max(np.abs(found - wanted), initial=0.0)) / largest
