"""The pieces that regions fall into under the hyperplanes of a tree, each cut made once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.explicit.cones import Cone, cone_of, halves, homogeneous, sides
from servogen.explicit.small_lp import BoolArray, IntArray
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import SAME_CUT
from servogen.plants.statespace import FloatArray

Node = tuple[int, ...]


@dataclass(frozen=True)
class Arrangement:
    """What all trees of a solution begin with: ``planes`` (planes, r + 1), homogeneous unit normals
    of the candidate hyperplanes, and every region within the domain as a cone, with lengths in
    ``unit``; ``sides`` (regions, 2, planes): whether each has points below, above each plane."""

    solution: ExplicitSolution
    unit: float
    planes: FloatArray
    cones: tuple[Cone, ...]
    sides: BoolArray

    def in_half(self, direction: FloatArray) -> int:
        """How many regions have points where direction . eta is positive."""
        half = np.append(direction, 0.0)[None]
        return int(np.sum(sides(self.cones, half)[:, 1, 0]))


class Pieces:
    """Pieces of regions, numbered as they come up.

    Attributes:
        planes: see ``Arrangement``.
        cones, regions, laws: of each piece.
        sides: (pieces, 2, planes), whether each piece has points strictly below, strictly above
            each plane; more rows than pieces.
    """

    def __init__(self, planes: FloatArray) -> None:
        self.planes = planes
        self.cones: list[Cone] = []
        self.regions: list[int] = []
        self.laws: list[int] = []
        self.sides: BoolArray = np.zeros((64, 2, len(planes)), dtype=bool)
        self._known: dict[tuple[int, bytes], int] = {}
        self._parts: dict[tuple[int, int, int], int] = {}
        self._waiting: dict[tuple[int, int, int], Cone] = {}

    def add(self, region: int, law: int, cone: Cone, where: BoolArray) -> int:
        """The number of a piece, new or not, by the sides (2, planes) that it has of the planes.

        A piece is its region within the planes that do not cross it, so its sides tell it from
        every other piece of its region.
        """
        key = (region, np.packbits(where).tobytes())
        number = self._known.setdefault(key, len(self.laws))
        if number == len(self.laws):
            if number == len(self.sides):
                self.sides = np.concatenate([self.sides, np.zeros_like(self.sides)])
            self.sides[number] = where
            self.cones.append(cone)
            self.regions.append(region)
            self.laws.append(law)
        return number

    def part(self, node: Node, plane: int, side: int) -> Node:
        """The pieces of a node below (0) or above (1) a plane."""
        numbers = np.array(node)
        here = numbers[self.sides[numbers, side, plane]]
        crossed = self.sides[here, 1 - side, plane]
        found = here[~crossed].tolist() + self._cut(here[crossed].tolist(), plane, side)
        return tuple(sorted(found))

    def _cut(self, pieces: list[int], plane: int, side: int) -> list[int]:
        """The parts of pieces on one side of a plane that crosses them."""
        keys = [(piece, plane, side) for piece in pieces]
        new = [key for key in keys if key not in self._parts]
        uncut = [key[0] for key in new if key not in self._waiting]
        both = halves([self.cones[piece] for piece in uncut], self.planes[plane])
        for piece, (low, high) in zip(uncut, both, strict=True):
            self._waiting[piece, plane, 0], self._waiting[piece, plane, 1] = low, high
        parts = [self._waiting.pop(key) for key in new]
        if parts:
            where = self._sides_of([key[0] for key in new], plane, side, parts)
            for key, part, own in zip(new, parts, where, strict=True):
                self._parts[key] = self.add(self.regions[key[0]], self.laws[key[0]], part, own)
        return [self._parts[key] for key in keys]

    def _sides_of(self, pieces: list[int], plane: int, side: int, parts: list[Cone]) -> BoolArray:
        """A part is on the side that its piece is on of every plane that does not cross that; where
        its points, for want of digits, tell of neither, it counts for both."""
        where: BoolArray = self.sides[pieces]
        where[:, 1 - side, plane] = False
        crossed = where[:, 0] & where[:, 1]
        planes = np.flatnonzero(np.any(crossed, axis=0))
        found = sides(parts, self.planes[planes])
        found |= ~np.any(found, axis=1, keepdims=True)
        where[:, :, planes] = np.where(crossed[:, None, planes], found, where[:, :, planes])
        return where

    def laws_of(self, node: Node) -> int:
        """How many different laws a node still holds."""
        return len({self.laws[piece] for piece in node})

    def law_beside(self, node: Node, plane: int, side: int) -> int:
        """The law that a node holds on a side of a plane where it holds only one."""
        return next(self.laws[piece] for piece in node if self.sides[piece, side, plane])

    def scores(self, node: Node) -> tuple[IntArray, IntArray, IntArray]:
        """(planes,) each: laws below, laws above, pieces on both sides together."""
        numbers = np.array(node)
        laws = np.array([self.laws[piece] for piece in node])
        ordered = np.lexsort((numbers, laws))
        numbers, laws = numbers[ordered], laws[ordered]
        starts = np.flatnonzero(np.append(True, laws[1:] != laws[:-1]))
        where = self.sides[numbers]
        held = np.sum(np.logical_or.reduceat(where, starts, axis=0), axis=0)
        return held[0], held[1], np.sum(where, axis=(0, 1))


def _unit(solution: ExplicitSolution) -> float:
    """The height of the farthest hyperplane, or 1: two far ones, of limits on a plant's states,
    must not lose their difference beside the coordinate that makes them homogeneous."""
    heights = (float(np.max(np.abs(region.k), initial=1.0)) for region in solution.regions)
    return max(heights, default=1.0)


def hyperplanes(
    solution: ExplicitSolution, unit: float = 1.0
) -> tuple[FloatArray, list[list[tuple[int, int]]]]:
    """(planes, r + 1): those of all facets of all regions, each once, homogeneous unit normals; and
    of each region, which planes its facets lie on, below (0) or above (1) which it is.

    The largest entry of the part that multiplies eta is positive.
    """
    size = solution.image.size
    kept = np.zeros((0, size + 1))
    facets: list[list[tuple[int, int]]] = []
    for region in solution.regions:
        own = []
        for row in homogeneous(region.h, region.k / unit) if region.k.size else ():
            sign = np.sign(row[np.argmax(np.abs(row[:size]))])
            apart = np.max(np.abs(kept - sign * row), axis=1)
            at = int(np.argmin(apart)) if apart.size else 0
            if not apart.size or apart[at] > SAME_CUT:
                at, kept = len(kept), np.vstack([kept, sign * row])
            own.append((at, int(sign < 0.0)))
        facets.append(own)
    return kept, facets


def arrange(solution: ExplicitSolution) -> Arrangement:
    """The hyperplanes and the regions that trees are grown from."""
    rows, bounds = solution.program.domain_rows, solution.program.domain_bounds
    unit = _unit(solution)
    cones = [
        cone_of(np.vstack([region.h, rows]), np.concatenate([region.k, bounds]) / unit)
        for region in solution.regions
    ]
    planes, facets = hyperplanes(solution, unit)
    where = sides(cones, planes)
    for i, own in enumerate(facets):  # known, whatever the digits of a far-off corner say
        for plane, side in own:
            where[i, side, plane], where[i, 1 - side, plane] = True, False
    return Arrangement(solution, unit, planes, tuple(cones), where)


def whole(arrangement: Arrangement, mirror: int = -1) -> tuple[Pieces, Node]:
    """The pieces to begin with, every region within the domain, and the root that holds them.

    Args:
        mirror: only the half of the parameters where this coordinate is not negative; -1 for all.
    """
    solution, pieces = arrangement.solution, Pieces(arrangement.planes)
    cones = dict(enumerate(arrangement.cones))
    own = arrangement.sides
    if mirror >= 0:
        half = np.eye(solution.image.size + 1)[mirror]
        where = sides(arrangement.cones, half[None])[:, :, 0]
        cones = {
            i: halves([cone], half)[0][1] if where[i, 0] else cone
            for i, cone in cones.items()
            if where[i, 1]
        }
        found = sides(list(cones.values()), arrangement.planes)
        found &= own[list(cones)]
        own = found | (own[list(cones)] & ~np.any(found, axis=1, keepdims=True))
    root = [
        pieces.add(i, int(solution.law_of[i]), cone, seen)
        for (i, cone), seen in zip(cones.items(), own, strict=True)
    ]
    return pieces, tuple(root)
