"""The proof of a search tree: every region that reaches a leaf has that leaf's law.

From the root down, a region is carried into a child unless a linear program shows that it has no
more than a flat set there. What arrives at a leaf must have its law. Tables that were rounded are
proved with the rounding of the numbers and of the arithmetic allowed for: every test is widened by
a stated bound, and a region with another law that then arrives must give nearly the same move.
Nothing of the way the tree was grown is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.explicit.errors import ExplicitError
from servogen.explicit.facet_parts import padded_balls
from servogen.explicit.small_lp import greatest_many
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import FLAT, FLAT_UP_TO
from servogen.explicit.tree import Tree
from servogen.plants.statespace import FloatArray

Clip = tuple[float, float]


@dataclass(frozen=True)
class TreeProof:
    """What was proved.

    Attributes:
        leaves: leaves looked at; arrivals: pairs of a leaf and a region that reaches it.
        programs: linear programs solved.
        wrong: law of the leaf and region, where the laws differ: none, or the tree is wrong (exact
            tables), or as far off as ``worst_difference`` says (rounded tables, where every pair
            counts if the laws are rounded too).
        worst_difference: the greatest difference of a first move, in its units, over those pairs;
            0 if there are none, inf if it was not bounded.
        unreached: leaves that no region reaches.
    """

    leaves: int
    arrivals: int
    programs: int
    wrong: tuple[tuple[int, int], ...]
    worst_difference: float
    unreached: int

    def holds(self, allowed: float = 0.0) -> bool:
        """Whether no first move is off by more than ``allowed`` (its units)."""
        return not self.wrong or self.worst_difference <= allowed


def prove_tree(
    tree: Tree,
    solution: ExplicitSolution,
    slack: npt.ArrayLike | None = None,
    within: tuple[FloatArray, FloatArray] | None = None,
    clip: Clip | None = None,
    laws: tuple[FloatArray, FloatArray] | None = None,
) -> TreeProof:
    """Proves ``tree`` for every parameter of the solution's domain, or of ``within`` besides.

    Args:
        tree: as grown, or as read back from tables.
        slack: (inner,) by how much the height compared at each node may be off; None: exact.
        within: rows (q, r) and bounds (q,) on eta; with a slack, a bounded set.
        clip: bounds that the first move is clipped to behind the leaf (one move).
        laws: gains and offsets that the leaves really hold, if rounded; as in ``Laws``.

    Raises:
        ExplicitError: the tree and the solution do not fit each other.
    """
    if tree.inner and tree.normals.shape[1] != solution.image.size:
        expected = f"{solution.image.size} coordinates, as the solution has"
        raise ExplicitError("tree", f"in {tree.normals.shape[1]} coordinates", expected)
    walk = _Walk(tree, solution, slack, within, clip, laws)
    walk.run()
    leaves = {leaf for leaf, _ in walk.arrived}
    return TreeProof(
        tree.leaves, len(walk.arrived), walk.programs, tuple(walk.wrong), walk.worst,
        tree.leaves - len(leaves),
    )  # fmt: skip


class _Walk:
    def __init__(
        self,
        tree: Tree,
        solution: ExplicitSolution,
        slack: npt.ArrayLike | None,
        within: tuple[FloatArray, FloatArray] | None,
        clip: Clip | None,
        laws: tuple[FloatArray, FloatArray] | None,
    ) -> None:
        self.tree, self.solution, self.clip = tree, solution, clip
        self.exact = slack is None and laws is None
        self.slack = np.zeros(tree.inner) if slack is None else np.asarray(slack, dtype=np.float64)
        own = solution.laws
        self.gains, self.offsets = (own.gains, own.offsets) if laws is None else laws
        rows, bounds = solution.program.domain_rows, solution.program.domain_bounds
        if within is not None:
            rows, bounds = np.vstack([rows, within[0]]), np.concatenate([bounds, within[1]])
        if tree.mirror >= 0:
            rows = np.vstack([rows, -np.eye(solution.image.size)[tree.mirror]])
            # a coordinate just below zero may have been computed as zero
            bounds = np.append(bounds, np.max(self.slack, initial=0.0))
        self.rows, self.bounds = rows, bounds
        self.programs = 0
        self.arrived: set[tuple[int, int]] = set()
        self.wrong: list[tuple[int, int]] = []
        self.worst = 0.0

    def run(self) -> None:
        everyone = list(range(len(self.solution.regions)))
        start = self._remaining(everyone, self.rows, self.bounds)
        stack = [(self.tree.root, -1, start, self.rows, self.bounds)]
        while stack:
            at, place, alive, rows, bounds = stack.pop()
            if at < 0:
                self._leaf(-1 - at, place, alive, rows, bounds)
                continue
            normal = self.tree.normals[at].astype(np.float64)
            offset, slack = float(self.tree.offsets[at]), float(self.slack[at])
            for side, sign in ((0, 1.0), (1, -1.0)):
                h = np.vstack([rows, sign * normal])
                k = np.append(bounds, sign * offset + slack)
                child = int(self.tree.children[at, side])
                stack.append((child, 2 * at + side, self._remaining(alive, h, k), h, k))

    def _stack(
        self, alive: list[int], rows: FloatArray, bounds: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Each region with the rows of the way to a node: (alive, rows, r), (alive, rows)."""
        regions = [self.solution.regions[i] for i in alive]
        most = max(region.k.size for region in regions)
        h = np.zeros((len(alive), most + bounds.size, rows.shape[1]))
        k = np.ones((len(alive), most + bounds.size))  # rows 0 eta <= 1 fill up
        h[:, most:], k[:, most:] = rows, bounds
        for i, region in enumerate(regions):
            h[i, : region.k.size], k[i, : region.k.size] = region.h, region.k
        return h, k

    def _remaining(self, alive: list[int], rows: FloatArray, bounds: FloatArray) -> list[int]:
        """Regions that no linear program shows to be flat (exact) or empty (widened) here."""
        if not alive:
            return []
        h, k = self._stack(alive, rows, bounds)
        if not k.shape[1]:
            return alive
        self.programs += len(alive)
        least = FLAT if self.exact else -FLAT
        balls = padded_balls(list(zip(h, k, strict=True)))  # no answer: it may remain
        return [
            i
            for i, ball in zip(alive, balls, strict=True)
            if ball.radius > least * max(1.0, np.max(np.abs(ball.centre)) / FLAT_UP_TO)
        ]

    def _leaf(
        self, law: int, place: int, alive: list[int], rows: FloatArray, bounds: FloatArray
    ) -> None:
        self.arrived.update((place, i) for i in alive)
        other = [i for i in alive if int(self.solution.law_of[i]) != law]
        if self.exact:
            for i in other:
                self.wrong.append((law, i))
                self.worst = float("inf")
            return
        # leaves whose laws were rounded are off where they are right, too
        asked = other if self.gains is self.solution.laws.gains else alive
        self.wrong += [(law, i) for i in asked]
        if asked:
            h, k = self._stack(asked, rows, bounds)
            for index, i in enumerate(asked):
                self.worst = max(self.worst, *self._difference(law, i, h[index], k[index]))

    def _difference(self, law: int, region: int, h: FloatArray, k: FloatArray) -> list[float]:
        """Greatest difference of each first move by a leaf's law and by a region's, over a set."""
        own = int(self.solution.law_of[region])
        true_gain, true_offset = self.solution.laws.gains[own], self.solution.laws.offsets[own]
        gain, offset = self.gains[law].astype(np.float64), self.offsets[law].astype(np.float64)
        if self.clip is not None:
            return [_clipped_difference(h, k, gain[0], offset[0], true_gain[0], true_offset[0],
                                        self.clip)]  # fmt: skip
        apart, constant = gain - true_gain, offset - true_offset
        objectives = np.vstack([apart, -apart])
        self.programs += len(objectives)
        tops = greatest_many(h, np.tile(k, (len(objectives), 1)), objectives)
        return [float(v) for v in tops + np.concatenate([constant, -constant])]


def _clipped_difference(
    h: FloatArray, k: FloatArray, gain: FloatArray, offset: float, true_gain: FloatArray,
    true_offset: float, clip: Clip,
) -> float:  # fmt: skip
    """Greatest difference of two clipped moves over {h eta <= k}.

    Where the true move is within the bounds, clipping cannot enlarge the difference; where it is
    beyond one, the difference is by how far the other stays short of that bound.
    """
    low, high = clip
    size = float(np.max(np.abs(np.append(true_gain, gain)))) or 1.0
    true_row, row = true_gain / size, gain / size
    within = np.vstack([h, true_row, -true_row])
    bounds = np.concatenate([k, [(high - true_offset) / size, (true_offset - low) / size]])
    worst = [0.0]
    for sign in (1.0, -1.0):
        top = greatest_many(within, bounds[None], sign * (row - true_row)[None])[0]
        worst.append(float(top) * size + sign * (offset - true_offset))
    beyond = np.vstack([h, -true_row])
    top = greatest_many(beyond, np.append(k, (true_offset - high) / size)[None], -row[None])[0]
    worst.append(float(top) * size - offset + high)
    beyond = np.vstack([h, true_row])
    top = greatest_many(beyond, np.append(k, (low - true_offset) / size)[None], row[None])[0]
    worst.append(float(top) * size + offset - low)
    return min(max(worst), high - low)


def rounding_slack(tree: Tree, reach: FloatArray, image_error: FloatArray) -> FloatArray:
    """(inner,) bound on the error of each node's height in the arithmetic of the tree's tables.

    Products and sums of r terms each round once: gamma_{r+1} sum |a_j| reach_j, and the error that
    the coordinates come with. The tables themselves are taken as they are, rounded.

    Args:
        reach: (r,) largest |eta_j|; image_error: (r,) largest error of each computed coordinate.
    """
    terms = np.abs(tree.normals.astype(np.float64))
    unit = 0.5 * float(np.finfo(tree.normals.dtype).eps)
    count = tree.normals.shape[1] + 1
    growth = count * unit / (1.0 - count * unit)
    slack: FloatArray = terms @ (growth * np.abs(reach) + np.abs(image_error) * (1.0 + growth))
    return slack
