"""The explicit solution: all regions, their laws, and what was met on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.explicit.image import Canonical, Image
from servogen.explicit.regions import Region
from servogen.explicit.tolerances import LEAST_LAW, SAME_LAW
from servogen.plants.statespace import FloatArray, read_only
from servogen.qp.parametric import ParametricQP

IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Laws:
    """Distinct first-move laws u = gains[i] eta + offsets[i]: (laws, nu, r) and (laws, nu)."""

    gains: FloatArray
    offsets: FloatArray

    @property
    def count(self) -> int:
        """How many."""
        return int(self.offsets.shape[0])


@dataclass(frozen=True)
class Findings:
    """What the enumeration met.

    Attributes:
        closed_form: every pattern of a box is a region; nothing was searched.
        boundary_facets: facets beyond which the program has no feasible point.
        shared_facets: facets settled by the adjacency of active sets.
        stepped_facets: facets where that is not enough (dependent rows, several rows on one facet,
            several regions behind it) and points beyond them were solved.
        flat_sets: active sets, optimal somewhere, whose region is lower-dimensional.
        weakly_active: regions with constraints that hold with equality without being needed.
        unresolved: facet pieces beyond which nothing was found: empty unless numbers gave out.
        slivers: the same of pieces narrower than a step across can tell (``SLIVER``).
    """

    closed_form: bool
    boundary_facets: int = 0
    shared_facets: int = 0
    stepped_facets: int = 0
    flat_sets: tuple[tuple[int, ...], ...] = ()
    weakly_active: int = 0
    unresolved: tuple[str, ...] = ()
    slivers: int = 0


@dataclass(frozen=True)
class ExplicitSolution:
    """Regions in eta = image(theta) that cover the feasible parameters, and their laws.

    Attributes:
        problem: what was solved; program: the same as a projection.
        regions: ordered by their active sets.
        laws: of the first moves, ordered as regions first use them.
        law_of: (regions,) index into ``laws``.
        findings: see ``Findings``.
    """

    problem: ParametricQP
    program: Canonical
    regions: tuple[Region, ...]
    laws: Laws
    law_of: IntArray
    findings: Findings

    @property
    def image(self) -> Image:
        """eta of theta."""
        return self.program.image

    def full_law(self, index: int) -> tuple[FloatArray, FloatArray]:
        """K (n, p), k (n,): the whole optimum z = K theta + k in a region."""
        region, image = self.regions[index], self.image
        slope, offset = self.problem.unconstrained()
        moved = self.program.unscale @ region.slope
        constant = self.program.unscale @ (region.offset + region.slope @ image.offset) + offset
        return slope + moved @ image.matrix, constant

    def locate(self, eta: FloatArray, tolerance: float = 1e-9) -> IntArray:
        """(N,) the region that holds each of ``eta`` (N, r) best; -1 where none does.

        Exhaustive, for tests and reports; the emitted lookups are trees and clip forms.
        """
        worst = np.full((eta.shape[0], len(self.regions)), -np.inf)
        for i, region in enumerate(self.regions):
            if region.k.size:
                worst[:, i] = np.max(eta @ region.h.T - region.k, axis=1)
        best = np.argmin(worst, axis=1)
        scale = 1.0 + np.max(np.abs(eta), axis=1)
        inside = worst[np.arange(eta.shape[0]), best] <= tolerance * scale
        if self.program.domain_bounds.size:
            excess = eta @ self.program.domain_rows.T - self.program.domain_bounds
            inside &= np.max(excess, axis=1) <= tolerance * scale
        return np.where(inside, best, -1)

    def first_move(self, theta: FloatArray) -> FloatArray:
        """(N, nu) the optimal first moves of ``theta`` (N, p); NaN where infeasible."""
        eta = self.image.of(theta)
        found = self.locate(eta)
        law = self.law_of[np.maximum(found, 0)]
        moves = np.einsum("nij,nj->ni", self.laws.gains[law], eta) + self.laws.offsets[law]
        moves[found < 0] = np.nan
        result: FloatArray = moves
        return result


def first_move_law(
    problem: ParametricQP, program: Canonical, region: Region
) -> tuple[FloatArray, FloatArray]:
    """The first moves (nu, r), (nu,) of a region's optimum.

    A move at its own bound is that bound exactly: what rounding leaves of its gain would be
    multiplied by parameters far outside any box.
    """
    nu, n, m = problem.first_move, problem.variables, problem.rows.shape[0]
    gain = program.unscale[:nu] @ region.slope + program.base
    offset = program.unscale[:nu] @ region.offset + program.base_offset
    for number in region.active:
        side, i = divmod(number - m, n)
        if number >= m and i < nu:
            gain[i], offset[i] = 0.0, (problem.upper, problem.lower)[side][i]
    return gain, offset


def group_laws(gains: list[FloatArray], offsets: list[FloatArray]) -> tuple[Laws, IntArray]:
    """Equal laws once, in the order of first use, and the index of each given law among them.

    Equal means coefficients within ``SAME_LAW`` of the largest of that move in the two laws: others
    may be a million times steeper. A chain of nearly equal laws could not creep: each is compared
    with the first of its group.
    """
    tables = np.array([np.column_stack([g, o]) for g, o in zip(gains, offsets, strict=True)])
    sizes = np.max(np.abs(tables), axis=2)
    sizes = np.maximum(sizes, LEAST_LAW * np.max(sizes, axis=0))
    leaders: list[int] = []
    index = np.zeros(len(gains), dtype=np.int64)
    for i, table in enumerate(tables):
        apart = np.max(np.abs(tables[leaders] - table), axis=2)
        same = np.all(apart <= SAME_LAW * np.maximum(sizes[leaders], sizes[i]), axis=1)
        if not np.any(same):
            leaders.append(i)
        index[i] = np.argmax(same) if np.any(same) else len(leaders) - 1
    kept = tables[leaders]
    return Laws(read_only(kept[:, :, :-1]), read_only(kept[:, :, -1])), index
