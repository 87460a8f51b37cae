"""The smallest search tree that a given amount of work finds: least depth first, then nodes.

A node's candidates are ordered by the laws that a hyperplane leaves on its worse side, then on
both, then by the regions it cuts. The first candidate alone gives the greedy tree. Then any tree
that is one level shallower is searched for among the first 2, 3, 5, ... candidates of every node,
again and again; what work is left goes into the fewest leaves at that depth. Work is counted in
nodes opened, and in the pieces of regions that these hold, not in time: the same input gives the
same tree on every machine.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from math import ceil, log2

import numpy as np

from servogen.explicit.errors import ExplicitError
from servogen.explicit.pieces import Arrangement, Node, Pieces, arrange, whole
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree, empty_tree
from servogen.plants.statespace import FloatArray
from servogen.progress import Progress, Silent, Task

# Candidates of a node that are tried, search by search.
_WIDTHS = (2, 3, 5, 8, 13, 21, 34)
_NONE = 10**9
# Inner nodes of a greedy tree unless the caller says otherwise: some hundred kilobytes of tables,
# half a minute of growing.
MAX_NODES = 5000
# Random ways that a tree's size is estimated from before it is grown: a quarter off, so one that is
# estimated at twice the limit has no chance.
_PROBES, _HOPELESS = 20, 2
# A node with more pieces than this counts for several: cutting them is what takes the time.
_PIECES = 5


@dataclass(frozen=True)
class _Candidate:
    """A plane that splits a node, and the laws that the node then holds below and above it."""

    plane: int
    laws: tuple[int, int]


@dataclass(frozen=True)
class Plan:
    """A tree still in pieces: the number of its leaves and the cut at its root."""

    leaves: int
    cut: _Candidate


class _OutOfWork(Exception):
    pass


@dataclass
class _Search:
    pieces: Pieces
    most: int
    task: Task
    orders: dict[Node, list[_Candidate]] = field(default_factory=dict)
    halves: dict[tuple[Node, int, int], Node] = field(default_factory=dict)
    opened: int = 0  # nodes whose candidates were ordered, one with many pieces for several

    def order(self, node: Node) -> list[_Candidate]:
        """Planes that split a node, most promising first."""
        if node not in self.orders:
            self.task.advance()
            self.opened += -(-len(node) // _PIECES)
            if len(self.orders) >= self.most:
                raise _too_large(self.most, f"more than {self.most}")
            below, above, pieces = self.pieces.scores(node)
            useful = np.flatnonzero((below > 0) & (above > 0))
            if not useful.size:
                expected = "regions whose hyperplanes tell them apart (fewer constraints)"
                raise ExplicitError("search tree", "cut short for want of digits", expected)
            worse = np.maximum(below, above)[useful]
            ranked = np.lexsort((useful, pieces[useful], (below + above)[useful], worse))
            best = useful[ranked][: _WIDTHS[-1]]
            self.orders[node] = [_Candidate(int(i), (int(below[i]), int(above[i]))) for i in best]
        return self.orders[node]

    def half(self, node: Node, plane: int, side: int) -> Node:
        """One side of a node."""
        key = (node, plane, side)
        if key not in self.halves:
            self.halves[key] = self.pieces.part(node, plane, side)
        return self.halves[key]


def _too_large(most: int, found: str) -> ExplicitError:
    expected = f"at most {most} (a shorter horizon, fewer constraints, or a higher limit)"
    return ExplicitError("number of tree nodes", found, expected)


def least_depth(laws: int) -> int:
    """No tree tells so many laws apart in less."""
    return ceil(log2(laws)) if laws > 1 else 0


@dataclass
class _Shallow:
    """Any tree that is not too deep, over the first ``width`` candidates of every node."""

    search: _Search
    width: int
    limit: int
    found: dict[Node, tuple[int, _Candidate]] = field(default_factory=dict)
    failed: dict[Node, int] = field(default_factory=dict)

    def fits(self, node: Node, depth: int) -> bool:
        """Whether a tree not deeper than ``depth`` was found for a node of several laws."""
        if node in self.found and self.found[node][0] <= depth:
            return True
        if depth <= self.failed.get(node, 0):
            return False
        if self.search.opened >= self.limit:
            raise _OutOfWork
        most = 1 << (depth - 1)  # laws that a child may have
        for candidate in self.search.order(node)[: self.width]:
            if max(candidate.laws) > most:
                continue
            worse = int(candidate.laws[1] > candidate.laws[0])
            if self._half_fits(node, candidate, worse, depth - 1) and self._half_fits(
                node, candidate, 1 - worse, depth - 1
            ):
                self.found[node] = (depth, candidate)
                return True
        self.failed[node] = depth
        return False

    def _half_fits(self, node: Node, candidate: _Candidate, side: int, depth: int) -> bool:
        if candidate.laws[side] == 1:
            return True  # whatever pieces it consists of
        return self.fits(self.search.half(node, candidate.plane, side), depth)

    def best(self, node: Node, depth: int) -> Plan | None:
        """The plan found."""
        if not self.fits(node, depth):
            return None
        cut = self.found[node][1]
        leaves = 0
        for side in (0, 1):
            if cut.laws[side] == 1:
                leaves += 1
            else:
                plan = self.best(self.search.half(node, cut.plane, side), depth - 1)
                assert plan is not None
                leaves += plan.leaves
        return Plan(leaves, cut)


@dataclass
class _Fewest:
    """Trees with the fewest leaves over the first ``width`` candidates of every node."""

    search: _Search
    width: int
    limit: int
    memo: dict[tuple[Node, int], Plan | None] = field(default_factory=dict)

    def best(self, node: Node, depth: int) -> Plan | None:
        """The plan of a node of several laws with the fewest leaves not deeper than ``depth``; None
        if there is none."""
        key = (node, depth)
        if key in self.memo:
            return self.memo[key]
        if depth < 1:
            return None
        if self.search.opened >= self.limit:
            raise _OutOfWork
        found: Plan | None = None
        most = 1 << (depth - 1)  # laws that a child may have
        for candidate in self.search.order(node)[: self.width]:
            low, high = candidate.laws
            bound = _NONE if found is None else found.leaves
            if max(low, high) > most or low + high >= bound:
                continue
            left = self._leaves(node, candidate, 0, depth - 1)
            if left is None or left + high >= bound:
                continue
            right = self._leaves(node, candidate, 1, depth - 1)
            if right is not None and left + right < bound:
                found = Plan(left + right, candidate)
        self.memo[key] = found
        return found

    def _leaves(self, node: Node, candidate: _Candidate, side: int, depth: int) -> int | None:
        if candidate.laws[side] == 1:
            return 1
        plan = self.best(self.search.half(node, candidate.plane, side), depth)
        return None if plan is None else plan.leaves


def grow_tree(
    solution: ExplicitSolution,
    work: int = 20_000,
    mirror: int = -1,
    progress: Progress | None = None,
    max_nodes: int = MAX_NODES,
) -> Tree:
    """A search tree with law leaves that is right for every feasible parameter of the domain.

    Args:
        work: nodes opened beyond those of the greedy tree, which is finished whatever it takes; one
            with many pieces of regions counts for several.
        mirror: build for the half of the parameters where this coordinate is not negative; the
            program must be odd (``is_odd``).
        max_nodes: inner nodes of the greedy tree beyond which there is none.

    Raises:
        ExplicitError: ``mirror`` on a program that is not odd, more than ``max_nodes`` nodes, or
            laws that no hyperplane tells apart.
    """
    growth = Growth(arrange(solution), mirror, progress, max_nodes)
    growth.thin_out(work - growth.lower(work))
    return growth.tree()


class Growth:
    """A tree that grows: greedy to begin with, then smaller and smaller.

    Attributes:
        depth, leaves: of the smallest tree so far.
        least: no tree is shallower.

    Raises:
        ExplicitError: as ``grow_tree``.
    """

    def __init__(
        self,
        arrangement: Arrangement,
        mirror: int = -1,
        progress: Progress | None = None,
        max_nodes: int = MAX_NODES,
    ) -> None:
        solution = arrangement.solution
        if mirror >= 0 and not is_odd(solution):
            expected = "-1, since the program is not odd (symmetric bounds, no constant terms)"
            raise ExplicitError("mirror", mirror, expected)
        self.solution, self.mirror = solution, mirror
        self._watcher = Silent() if progress is None else progress
        self.depth, self.leaves = 0, 1
        with self._watcher.task("Growing the search tree") as task:
            pieces, self._root = whole(arrangement, mirror)
            self._search = _Search(pieces, max_nodes, task)
            self._unit = arrangement.unit
            self.least = least_depth(pieces.laws_of(self._root))
            self._plans: _Shallow | _Fewest = _Fewest(self._search, 1, _NONE)
            if self.least:
                self._refuse_hopeless(max_nodes)
                self._take(self._plans, self._greedy_depth())
            self._search.most = _NONE  # the searches that follow end at their work

    def _refuse_hopeless(self, max_nodes: int) -> None:
        """Ends early where the greedy tree would be far too large, by Knuth's estimate (1975): the
        nodes on a random way to a leaf, each as often as there are ways of its length."""
        chance = np.random.default_rng(_PROBES)
        total = 0
        for _ in range(_PROBES):
            node, ways = self._root, 1
            while True:
                total, best = total + ways, self._search.order(node)[0]
                side, ways = int(chance.integers(2)), 2 * ways
                if best.laws[side] == 1:
                    break
                node = self._search.half(node, best.plane, side)
        expected = total // _PROBES
        if expected > _HOPELESS * max_nodes:
            raise _too_large(max_nodes, f"about {expected}")

    def _greedy_depth(self) -> int:
        depth = self.least
        while self._plans.best(self._root, depth) is None:
            depth += 1
        return depth

    def _take(self, plans: _Shallow | _Fewest, depth: int) -> None:
        plan = plans.best(self._root, depth)
        assert plan is not None
        self._plans, self.depth, self.leaves = plans, depth, plan.leaves

    def lower(self, work: int) -> int:
        """Spends at most ``work`` (see ``grow_tree``) on less depth; how much it took."""
        return self._spent(self._lower, work)

    def thin_out(self, work: int) -> int:
        """Spends at most ``work`` on fewer leaves at the same depth; how much it took."""
        return self._spent(self._thin_out, work)

    def _spent(self, search: Callable[[int], None], work: int) -> int:
        start = self._search.opened
        with self._watcher.task("Growing the search tree") as task, suppress(_OutOfWork):
            self._search.task = task
            search(start + work)
        return self._search.opened - start

    def _lower(self, limit: int) -> None:
        for width in _WIDTHS:
            while self.depth > self.least:
                wider = _Shallow(self._search, width, limit)
                if not wider.fits(self._root, self.depth - 1):
                    break
                self._take(wider, self.depth - 1)

    def _thin_out(self, limit: int) -> None:
        for width in (1, *_WIDTHS):
            wider = _Fewest(self._search, width, limit)
            plan = wider.best(self._root, self.depth) if self.least else None
            if plan is not None and plan.leaves < self.leaves:
                self._take(wider, self.depth)

    def tree(self) -> Tree:
        """The tables, level by level, so that parents come before their children."""
        pieces, size = self._search.pieces, self.solution.image.size
        if not self.least:
            return empty_tree(size, pieces.laws[self._root[0]])
        planes: list[int] = []
        children: list[list[int]] = []
        level: list[tuple[Node, int, int]] = [(self._root, -1, 0)]  # node, parent, side
        left = self.depth
        while level:
            following: list[tuple[Node, int, int]] = []
            for node, parent, side in level:
                plan = self._plans.best(node, left)
                assert plan is not None
                cut = plan.cut
                place = len(planes)
                if parent >= 0:
                    children[parent][side] = place
                planes.append(cut.plane)
                children.append([0, 0])
                for half in (0, 1):
                    if cut.laws[half] == 1:
                        children[place][half] = -1 - pieces.law_beside(node, cut.plane, half)
                    else:
                        part = self._search.half(node, cut.plane, half)
                        following.append((part, place, half))
            level, left = following, left - 1
        return _tabled(pieces.planes[planes], self._unit, children, self.mirror)


def _tabled(planes: FloatArray, unit: float, children: list[list[int]], mirror: int) -> Tree:
    lengths = np.linalg.norm(planes[:, :-1], axis=1)
    normals, offsets = planes[:, :-1] / lengths[:, None], -planes[:, -1] / lengths * unit
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
