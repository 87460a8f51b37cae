"""Lookups as the emitted C evaluates them: tables in the target precision, sums in a fixed order.

Order of the arithmetic, the same here and in C (no contraction of products and sums):

1. eta_i = (M_i0 theta_0 + M_i1 theta_1 + ...) + m_i, from the first term to the last;
2. a tree: with a mirror, all eta are negated if its coordinate is below zero; at a node the height
   n_0 eta_0 + n_1 eta_1 + ... in that order, to the second child if it is greater than the offset;
   at the leaf u_j = (k_j0 eta_0 + ...) + c_j, negated if eta was, then clipped: first raised to the
   lower bound, then lowered to the upper one;
3. recursive clips: at each step c_0 delta_0 + c_1 delta_1 + ... over all n in that order, eta_i
   plus that, clipped to [-1, 1], delta_i = x - eta_i; in the end u_j = half_j x + middle_j, clipped
   as in a tree if that may round beyond a bound.

A NaN never passes a clip in C as here: the caller checks that its parameters are finite.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from servogen.explicit.clips import RecursiveClips
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree, descend, ordered_product
from servogen.plants.statespace import read_only
from servogen.precision import FloatArray


@dataclass(frozen=True)
class Count:
    """Worst case of one evaluation, and the numbers that its tables hold.

    A multiply-add that follows another in a sum counts as one; the first product of a sum counts as
    one too: ``opened`` sums begin with a product that C adds to nothing. A clip is two comparisons.
    ``additions`` are those that no product goes with.
    """

    multiply_adds: int
    additions: int
    comparisons: int
    sign_changes: int
    opened: int
    numbers: int

    @property
    def work(self) -> int:
        """Operations altogether, each for one; a sign change turns a bit and counts for none."""
        return self.multiply_adds + self.additions + self.comparisons

    @property
    def all_additions(self) -> int:
        """Additions of the C, where a product and the addition that takes it up are two."""
        return self.multiply_adds - self.opened + self.additions


@dataclass(frozen=True)
class TreeLookup:
    """A search tree over first-move laws with everything that an evaluation needs.

    Attributes:
        matrix: (r, p), offset: (r,) of eta; no rows: eta is theta itself.
        tree: see ``Tree``.
        gains: (laws, nu, r); offsets: (laws, nu).
        lower, upper: (nu,) the first moves are clipped to; -inf and inf for none. The laws of a
            program with these bounds keep them by themselves, but for rounding.
    """

    matrix: FloatArray
    offset: FloatArray
    tree: Tree
    gains: FloatArray
    offsets: FloatArray
    lower: FloatArray
    upper: FloatArray

    @property
    def bounded(self) -> bool:
        """Whether the moves are clipped: all of them, to the scalar's range where one has none."""
        return bool(np.any(np.isfinite(self.lower)) or np.any(np.isfinite(self.upper)))

    @property
    def count(self) -> Count:
        """Worst case: the deepest leaf."""
        rows, p = self.matrix.shape
        laws, nu, r = self.gains.shape
        depth, inner = self.tree.depth, self.tree.inner
        clips = 2 * nu if self.bounded else 0
        mirrored = self.tree.mirror >= 0
        shift = rows if np.any(self.offset) else 0
        return Count(
            multiply_adds=rows * p + depth * r + nu * r,
            additions=shift + nu,
            comparisons=depth + clips + int(mirrored),
            sign_changes=r + nu if mirrored else 0,
            opened=depth + nu,
            numbers=rows * p + shift + inner * (r + 3) + laws * nu * (r + 1) + clips,
        )

    def rounded(self, dtype: npt.DTypeLike) -> TreeLookup:
        """The tables as ``dtype`` holds them."""
        cast = {
            name: getattr(self, name).astype(dtype)
            for name in ("matrix", "offset", "gains", "offsets", "lower", "upper")
        }
        return replace(self, tree=self.tree.rounded(dtype), **cast)

    def evaluate(self, theta: FloatArray, dtype: npt.DTypeLike = np.float64) -> FloatArray:
        """(N, nu) first moves of ``theta`` (N, p), in the arithmetic of ``dtype``."""
        return self.find(theta, dtype)[1]

    def find(
        self, theta: FloatArray, dtype: npt.DTypeLike = np.float64
    ) -> tuple[npt.NDArray[np.int64], FloatArray]:
        """(N,) laws of the leaves reached, and ``evaluate``."""
        own = self.rounded(dtype)
        x = theta.astype(dtype)
        eta = image(own.matrix, own.offset, x) if own.matrix.shape[0] else x
        negated = np.zeros(eta.shape[0], dtype=bool)
        if own.tree.mirror >= 0:
            negated = eta[:, own.tree.mirror] < 0.0
            eta = np.where(negated[:, None], -eta, eta)
        law = descend(own.tree, eta)
        moves = [
            ordered_product(own.gains[law, j], eta) + own.offsets[law, j]
            for j in range(own.gains.shape[1])
        ]
        u = np.column_stack(moves)
        u = np.where(negated[:, None], -u, u)
        result: FloatArray = np.minimum(np.maximum(u, own.lower), own.upper)
        return law, result


def image(matrix: FloatArray, offset: FloatArray, theta: FloatArray) -> FloatArray:
    """(N, r) eta of ``theta`` (N, p): summed from the first parameter to the last, then shifted."""
    total = matrix[:, 0] * theta[:, :1]
    for j in range(1, matrix.shape[1]):
        total = total + matrix[:, j] * theta[:, j : j + 1]
    shifted: FloatArray = total + offset
    return shifted


def evaluate_clips(
    clips: RecursiveClips, theta: FloatArray, dtype: npt.DTypeLike = np.float64
) -> FloatArray:
    """(N, nu) first moves of ``theta`` (N, p) by the recursive form, in ``dtype``'s arithmetic."""
    eta = image(clips.matrix.astype(dtype), clips.offset.astype(dtype), theta.astype(dtype))
    coefficients = clips.coefficients.astype(dtype)
    delta = np.zeros_like(eta)
    found: dict[int, FloatArray] = {}
    one = np.ones((), dtype=dtype)
    for s, i in enumerate(clips.index):
        rows = np.broadcast_to(coefficients[s], delta.shape)
        x = eta[:, i] + ordered_product(rows, delta)
        x = np.minimum(np.maximum(x, -one), one)
        delta[:, i] = x - eta[:, i]
        found[s] = x
    half, middle = clips.half.astype(dtype), clips.middle.astype(dtype)
    moves = [half[j] * found[int(s)] + middle[j] for j, s in enumerate(clips.moves)]
    lower, upper = clips.lower.astype(dtype), clips.upper.astype(dtype)
    bounded: FloatArray = np.minimum(np.maximum(np.column_stack(moves), lower), upper)
    return bounded


def count_clips(clips: RecursiveClips) -> Count:
    """Worst case, which is every case, of the recursive form."""
    n, p = clips.matrix.shape
    steps, nu = clips.index.size, clips.moves.size
    shift = n if np.any(clips.offset) else 0
    # the last step's own delta is never used, but a loop computes it
    return Count(
        multiply_adds=n * p + steps * n + nu,
        additions=shift + 2 * steps,
        comparisons=2 * steps + (2 * nu if clips.rounds else 0),
        sign_changes=0,
        opened=steps,
        numbers=n * p + shift + steps * (n + 1) + (5 if clips.rounds else 3) * nu,
    )


def tree_lookup(
    solution: ExplicitSolution, tree: Tree, clip: tuple[float, float] | None = None
) -> TreeLookup:
    """The lookup of a tree grown for ``solution``, in eta or in theta itself, whichever is less.

    Args:
        clip: bounds of the first move that ``solution`` was computed without; None: its own.
    """
    own, laws, nu = solution.image, solution.laws, solution.problem.first_move
    low, high = solution.problem.lower[:nu], solution.problem.upper[:nu]
    if clip is not None:
        low, high = np.full(nu, clip[0]), np.full(nu, clip[1])
    lookup = TreeLookup(
        own.matrix, own.offset, tree, laws.gains, laws.offsets, read_only(low), read_only(high)
    )
    if tree.mirror >= 0:
        return lookup
    folded = TreeLookup(
        read_only(np.zeros((0, own.matrix.shape[1]))),
        read_only(np.zeros(0)),
        Tree(tree.normals @ own.matrix, tree.offsets - tree.normals @ own.offset,
             tree.children, tree.root),
        read_only(laws.gains @ own.matrix),
        read_only(laws.offsets + laws.gains @ own.offset),
        read_only(low),
        read_only(high),
    )  # fmt: skip
    return folded if folded.count.work < lookup.count.work else lookup
