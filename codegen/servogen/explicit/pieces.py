"""The pieces that regions fall into under the hyperplanes of a tree, each cut made once."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from servogen.explicit.cones import Cone, cone_of, cut, homogeneous, sides
from servogen.explicit.small_lp import BoolArray, IntArray
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import SAME_PLANE
from servogen.plants.statespace import FloatArray

Node = tuple[int, ...]


@dataclass
class Pieces:
    """Pieces of regions, numbered as they come up.

    Attributes:
        unit: what lengths are measured in here.
        planes: (planes, r + 1) homogeneous unit normals of the candidate hyperplanes.
        cones, regions, laws: of each piece.
        below, above: (planes,) of each piece, which planes it has points strictly on each side of.
    """

    unit: float
    planes: FloatArray
    cones: list[Cone] = field(default_factory=list)
    regions: list[int] = field(default_factory=list)
    laws: list[int] = field(default_factory=list)
    below: list[BoolArray] = field(default_factory=list)
    above: list[BoolArray] = field(default_factory=list)
    known: dict[tuple[int, bytes, bytes], int] = field(default_factory=dict)
    parts: dict[tuple[int, int, int], int] = field(default_factory=dict)
    counted: dict[Node, int] = field(default_factory=dict)

    def add(self, region: int, law: int, cone: Cone) -> int:
        """The number of a piece, new or not."""
        return self._numbered(region, law, cone, *sides(cone, self.planes))

    def side(self, piece: int, plane: int, sign: int) -> int:
        """The part of a piece below (-1) or above (1) a plane that crosses it.

        It has no side of a plane that the piece has not; where its points, for want of digits,
        tell of neither, it has the same. So two regions that a plane has once told apart stay so.
        """
        key = (piece, plane, sign)
        if key not in self.parts:
            part = cut(self.cones[piece], -sign * self.planes[plane])
            below, above = self.below[piece].copy(), self.above[piece].copy()
            below[plane], above[plane] = sign < 0, sign > 0
            crossed = np.flatnonzero(below & above)
            low, high = sides(part, self.planes[crossed])
            unclear = ~(low | high)
            below[crossed], above[crossed] = low | unclear, high | unclear
            number = self._numbered(self.regions[piece], self.laws[piece], part, below, above)
            self.parts[key] = number
        return self.parts[key]

    def _numbered(
        self, region: int, law: int, cone: Cone, below: BoolArray, above: BoolArray
    ) -> int:
        """A piece is its region within the planes that do not cross it, so the sides that it has of
        the planes tell it from every other piece of its region."""
        key = (region, below.tobytes(), above.tobytes())
        if key not in self.known:
            self.known[key] = len(self.laws)
            self.cones.append(cone)
            self.regions.append(region)
            self.laws.append(law)
            self.below.append(below)
            self.above.append(above)
        return self.known[key]

    def split(self, node: Node, plane: int) -> tuple[Node, Node]:
        """The pieces of a node below and above a plane."""
        halves: tuple[list[int], list[int]] = ([], [])
        for piece in node:
            low, high = self.below[piece][plane], self.above[piece][plane]
            if low:
                halves[0].append(self.side(piece, plane, -1) if high else piece)
            if high:
                halves[1].append(self.side(piece, plane, 1) if low else piece)
        return tuple(sorted(halves[0])), tuple(sorted(halves[1]))

    def laws_of(self, node: Node) -> int:
        """How many different laws a node still holds."""
        if node not in self.counted:
            self.counted[node] = len({self.laws[piece] for piece in node})
        return self.counted[node]

    def scores(self, node: Node) -> tuple[IntArray, IntArray, IntArray]:
        """(planes,) each: laws below, laws above, pieces on both sides together."""
        ordered = sorted(node, key=lambda piece: (self.laws[piece], piece))
        laws = np.array([self.laws[piece] for piece in ordered])
        starts = np.flatnonzero(np.append(True, laws[1:] != laws[:-1]))
        below = np.array([self.below[piece] for piece in ordered])
        above = np.array([self.above[piece] for piece in ordered])
        laws_below = np.sum(np.logical_or.reduceat(below, starts, axis=0), axis=0)
        laws_above = np.sum(np.logical_or.reduceat(above, starts, axis=0), axis=0)
        return laws_below, laws_above, np.sum(below, axis=0) + np.sum(above, axis=0)


def unit_of(solution: ExplicitSolution) -> float:
    """The height of the farthest hyperplane, or 1: what is far must not lose its last digits
    beside the one that makes the coordinates homogeneous."""
    heights = [float(np.max(np.abs(region.k), initial=1.0)) for region in solution.regions]
    return max(heights, default=1.0)


def hyperplanes(solution: ExplicitSolution, unit: float = 1.0) -> FloatArray:
    """(planes, r + 1): those of all facets of all regions, each once, homogeneous unit normals.

    The largest entry of the part that multiplies eta is positive.
    """
    size = solution.image.size
    kept = np.zeros((0, size + 1))
    for region in solution.regions:
        for row in homogeneous(region.h, region.k / unit) if region.k.size else ():
            signed = row * np.sign(row[np.argmax(np.abs(row[:size]))])
            if not kept.size or np.min(np.max(np.abs(kept - signed), axis=1)) > SAME_PLANE:
                kept = np.vstack([kept, signed])
    return kept


def whole(solution: ExplicitSolution, mirror: int = -1) -> tuple[Pieces, Node]:
    """The pieces to begin with, every region within the domain, and the root that holds them.

    Args:
        mirror: only the half of the parameters where this coordinate is not negative; -1 for all.
    """
    unit = unit_of(solution)
    pieces = Pieces(unit, hyperplanes(solution, unit))
    rows, bounds = solution.program.domain_rows, solution.program.domain_bounds / unit
    if mirror >= 0:
        rows = np.vstack([rows, -np.eye(solution.image.size)[mirror]])
        bounds = np.append(bounds, 0.0)
    half = np.append(np.eye(solution.image.size)[mirror], 0.0)[None]
    root = []
    for i, region in enumerate(solution.regions):
        full = cone_of(region.h, region.k / unit)
        if mirror >= 0 and not sides(full, half)[1][0]:
            continue
        cone = cone_of(np.vstack([region.h, rows]), np.concatenate([region.k / unit, bounds]))
        root.append(pieces.add(i, int(solution.law_of[i]), cone))
    return pieces, tuple(root)
