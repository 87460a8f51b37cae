"""The clip identity for bounds on the first move, with a tree, and without one.

V(z_1), the least cost with the first move held at z_1, is convex on the interval D of first moves
that can be completed. A convex function's minimum over D cut to [low, high] is the clip of its
minimum over D, wherever the cut leaves anything. So bounds on the first move alone may be dropped
from the program and applied to the move that comes out: a third of the regions of a box remain.

It takes one first move and bounds that are rows of their own; what else constrains the program, and
whether that involves z_1, does not matter. With several first moves V is a function of a vector and
its minimum over a box is not the clip of the free one. What remains true is the identity for one
move at a time, the earlier ones held: that is what the recursive form uses, and it needs a box.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from servogen.explicit.boxes import scaled_hessian
from servogen.explicit.errors import ExplicitError
from servogen.explicit.image import scaled_optimum, scales
from servogen.plants.statespace import FloatArray, read_only
from servogen.qp.parametric import ParametricQP

IndexArray = npt.NDArray[np.int32]

# Variables of the recursive form: 2^(n-1) clips are no longer a small constant beyond.
MAX_RECURSIVE = 12


def without_first_bounds(problem: ParametricQP) -> tuple[ParametricQP, tuple[float, float]]:
    """The program with the first move's own bounds dropped, and those bounds.

    Wherever ``problem`` is feasible its first move is that of the program returned, clipped.

    Raises:
        ExplicitError: several first moves, or one without bounds of its own.
    """
    if problem.first_move != 1:
        expected = "1: the clip of a vector of first moves is not the optimum"
        raise ExplicitError("first_move", problem.first_move, expected)
    low, high = float(problem.lower[0]), float(problem.upper[0])
    if np.isinf(low) and np.isinf(high):
        expected = "a lower or upper bound on the first move alone"
        raise ExplicitError("bounds of the first move", "infinite", expected)
    lower, upper = problem.lower.copy(), problem.upper.copy()
    lower[0], upper[0] = -np.inf, np.inf
    return replace(problem, lower=lower, upper=upper), (low, high)


@dataclass(frozen=True)
class RecursiveClips:
    """First moves of a box program by clips alone: no tree, no branch, a constant trip count.

    With eta = matrix theta + offset, the unconstrained optimum in shares of the bounds, and
    delta = 0 to begin with, for each step s: i = index[s]; x = clip(eta[i] + coefficients[s] .
    delta, -1, 1); delta[i] = x - eta[i]. Step ``moves[j]`` leaves first move j = half x + middle.

    Attributes:
        matrix: (n, p); offset: (n,).
        coefficients: (steps, n), zero for variables that are free in that step.
        index: (steps,) int32; moves: (nu,) int32.
        half, middle: (nu,) of the first moves.
        lower, upper: (nu,) their bounds, which half and middle may round beyond.
    """

    matrix: FloatArray
    offset: FloatArray
    coefficients: FloatArray
    index: IndexArray
    moves: IndexArray
    half: FloatArray
    middle: FloatArray
    lower: FloatArray
    upper: FloatArray

    @property
    def rounds(self) -> bool:
        """Whether a move at its bound, computed in float64 or float32, may round beyond it."""
        return any(self._rounds(dtype) for dtype in (np.float64, np.float32))

    def _rounds(self, dtype: npt.DTypeLike) -> bool:
        half, middle = self.half.astype(dtype), self.middle.astype(dtype)
        above = np.any(middle + half > self.upper.astype(dtype))
        return bool(above or np.any(middle - half < self.lower.astype(dtype)))


def recursive_clips(problem: ParametricQP) -> RecursiveClips:
    """The recursive form: 2^(n-1) + ... + 2^(n-nu) clips, right for every theta, of any rank.

    solve(variables, held): the first variable with the others in ``variables`` solved for while it
    is free, clipped; then, it being held, the others once more.

    Raises:
        ExplicitError: constraints other than two bounds on every variable, or more than
            ``MAX_RECURSIVE`` variables.
    """
    n, nu = problem.variables, problem.first_move
    if problem.rows.shape[0] or not np.all(problem.bounded):
        expected = "two finite bounds on every variable and no other constraint"
        raise ExplicitError("constraints of the recursive form", None, expected)
    if n > MAX_RECURSIVE:
        raise ExplicitError("variables of the recursive form", n, f"at most {MAX_RECURSIVE}")
    hessian = scaled_hessian(problem)
    steps: list[tuple[int, FloatArray]] = []
    moves: list[int] = []

    def step(variable: int, held: list[int]) -> None:
        free = [i for i in range(n) if i not in held]
        row = np.zeros(n)
        if held:
            rest = np.linalg.solve(hessian[np.ix_(free, free)], hessian[np.ix_(free, held)])
            row[held] = -rest[free.index(variable)]
        steps.append((variable, row))

    def solve(variables: list[int], held: list[int]) -> None:
        if not variables:
            return
        first, others = variables[0], variables[1:]
        solve(others, held)
        step(first, others + held)
        solve(others, [*held, first])

    for move in range(nu):
        others, held = list(range(move + 1, n)), list(range(move))
        solve(others, held)
        step(move, others + held)
        moves.append(len(steps) - 1)
    image, (half, middle) = scaled_optimum(problem), scales(problem)
    return RecursiveClips(
        read_only(image.matrix),
        read_only(image.offset),
        read_only(np.array([row for _, row in steps])),
        np.array([variable for variable, _ in steps], dtype=np.int32),
        np.array(moves, dtype=np.int32),
        read_only(half[:nu]),
        read_only(middle[:nu]),
        read_only(problem.lower[:nu]),
        read_only(problem.upper[:nu]),
    )
