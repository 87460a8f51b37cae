"""The smallest search tree that a given amount of work finds: least depth first, then nodes.

A node's candidates are ordered by the laws that a hyperplane leaves on its worse side, then on
both, then by the regions it cuts. The first candidate alone gives the greedy tree. Then the best
trees over the first 2, 3, 5, ... candidates of every node are searched by branch and bound, least
depth first, as long as the work lasts. Work is counted in nodes opened, not in time: the same
input gives the same tree on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, log2

import numpy as np

from servogen.explicit.errors import ExplicitError
from servogen.explicit.pieces import Node, Pieces, whole
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree, empty_tree
from servogen.progress import Progress, Silent, Task

# Candidates of a node that are tried, search by search.
_WIDTHS = (1, 2, 3, 5, 8, 13)
_NONE = 10**9


@dataclass(frozen=True)
class Plan:
    """A tree still in pieces: the number of its leaves and the plane at each of its nodes."""

    leaves: int
    plane: int


class _OutOfWork(Exception):
    pass


@dataclass
class _Search:
    pieces: Pieces
    work: int
    task: Task
    orders: dict[Node, list[int]] = field(default_factory=dict)
    halves: dict[tuple[Node, int], tuple[Node, Node]] = field(default_factory=dict)
    opened: int = 0

    def order(self, node: Node) -> list[int]:
        """Planes that split a node, most promising first."""
        if node not in self.orders:
            self.opened += 1
            self.task.advance()
            below, above, pieces = self.pieces.scores(node)
            useful = np.flatnonzero((below > 0) & (above > 0))
            worse = np.maximum(below, above)[useful]
            ranked = np.lexsort((useful, pieces[useful], (below + above)[useful], worse))
            self.orders[node] = [int(i) for i in useful[ranked][: _WIDTHS[-1]]]
        return self.orders[node]

    def split(self, node: Node, plane: int) -> tuple[Node, Node]:
        """Both sides of a node."""
        if (node, plane) not in self.halves:
            self.halves[node, plane] = self.pieces.split(node, plane)
        return self.halves[node, plane]


def least_depth(laws: int) -> int:
    """No tree tells so many laws apart in less."""
    return ceil(log2(laws)) if laws > 1 else 0


@dataclass
class _Width:
    """Best trees over the first ``width`` candidates of every node."""

    search: _Search
    width: int
    limit: int
    memo: dict[tuple[Node, int], Plan | None] = field(default_factory=dict)

    def best(self, node: Node, depth: int) -> Plan | None:
        """The plan with the fewest leaves not deeper than ``depth``; None if there is none."""
        laws = self.search.pieces.laws_of(node)
        if laws == 1:
            return Plan(1, -1)
        if depth < least_depth(laws):
            return None
        key = (node, depth)
        if key in self.memo:
            return self.memo[key]
        if self.search.opened > self.limit:
            raise _OutOfWork
        found: Plan | None = None
        for plane in self.search.order(node)[: self.width]:
            low, high = self.search.split(node, plane)
            bound = _NONE if found is None else found.leaves
            fewest = self.search.pieces.laws_of(low) + self.search.pieces.laws_of(high)
            if fewest >= bound:
                continue
            left = self.best(low, depth - 1)
            if left is None or left.leaves + self.search.pieces.laws_of(high) >= bound:
                continue
            right = self.best(high, depth - 1)
            if right is not None and left.leaves + right.leaves < bound:
                found = Plan(left.leaves + right.leaves, plane)
        self.memo[key] = found
        return found


def grow_tree(
    solution: ExplicitSolution,
    work: int = 20_000,
    mirror: int = -1,
    progress: Progress | None = None,
) -> Tree:
    """A search tree with law leaves that is right for every feasible parameter of the domain.

    Args:
        work: nodes opened, all searches together; the greedy tree is finished whatever it takes.
        mirror: build for the half of the parameters where this coordinate is not negative; the
            program must be odd (``is_odd``).

    Raises:
        ExplicitError: ``mirror`` on a program that is not odd.
    """
    if mirror >= 0 and not is_odd(solution):
        expected = "-1, since the program is not odd (symmetric bounds, no constant terms)"
        raise ExplicitError("mirror", mirror, expected)
    watcher = Silent() if progress is None else progress
    with watcher.task("Growing the search tree") as task:
        pieces, root = whole(solution, mirror)
        search = _Search(pieces, work, task)
        if pieces.laws_of(root) == 1:
            return empty_tree(solution.image.size, pieces.laws[root[0]])
        plan, depth = _Width(search, 1, _NONE), 0
        while plan.best(root, depth) is None:
            depth += 1
        chosen, leaves = plan, plan.best(root, depth)
        assert leaves is not None
        for width in _WIDTHS[1:]:
            wider = _Width(search, width, work)
            try:
                found = _least(wider, root, depth)
            except _OutOfWork:
                break
            if found is not None and (found[0], found[1].leaves) < (depth, leaves.leaves):
                chosen, depth, leaves = wider, found[0], found[1]
        return _laid_out(search, chosen, root, depth, solution.image.size, mirror)


def _least(width: _Width, root: Node, deepest: int) -> tuple[int, Plan] | None:
    start = least_depth(width.search.pieces.laws_of(root))
    for depth in range(start, deepest + 1):
        plan = width.best(root, depth)
        if plan is not None:
            return depth, plan
    return None


def _laid_out(
    search: _Search, width: _Width, root: Node, depth: int, size: int, mirror: int
) -> Tree:
    """The tree's tables, level by level, so that parents come before their children."""
    planes: list[int] = []
    children: list[list[int]] = []
    level: list[tuple[Node, int, int]] = [(root, -1, 0)]  # node, parent, side
    left = depth
    while level:
        following: list[tuple[Node, int, int]] = []
        for node, parent, side in level:
            plan = width.best(node, left)
            assert plan is not None
            place = -1 - search.pieces.laws[node[0]] if plan.plane < 0 else len(planes)
            if parent >= 0:
                children[parent][side] = place
            if plan.plane < 0:
                continue
            planes.append(plan.plane)
            children.append([0, 0])
            low, high = search.split(node, plan.plane)
            following += [(low, place, 0), (high, place, 1)]
        level, left = following, left - 1
    chosen = search.pieces.planes[planes]
    lengths = np.linalg.norm(chosen[:, :size], axis=1)
    normals = chosen[:, :size] / lengths[:, None]
    offsets = -chosen[:, size] / lengths * search.pieces.unit
    return Tree(normals, offsets, np.array(children, dtype=np.int32), 0, mirror)


def is_odd(solution: ExplicitSolution) -> bool:
    """Whether the optimum of -eta is minus that of eta: rows in opposite pairs, no constants."""
    program = solution.program
    rows = np.column_stack([program.g, program.e])
    domain = program.domain_rows
    return bool(
        np.max(np.abs(program.base_offset)) <= 1e-12 * np.max(np.abs(program.base))
        and np.max(np.abs(program.image.offset)) <= 1e-12
        and _in_pairs(rows, program.w)
        and _in_pairs(domain, program.domain_bounds)
    )


def _in_pairs(rows: np.ndarray, bounds: np.ndarray) -> bool:
    """Whether each row has its opposite with the same bound."""
    for row, bound in zip(rows, bounds, strict=True):
        apart = np.max(np.abs(rows + row), axis=1) + np.abs(bounds - bound)
        if np.min(apart) > 1e-9 * (1.0 + abs(bound)):
            return False
    return True
