"""Proofs that a computed set is what Result 1 of paper 1 says: invariant, admissible, maximal.

They use the sampled model in its own states and nothing of the way the set was computed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import FloatArray, StateSpace, discretise
from servogen.sets.admissible import AdmissibleSet
from servogen.sets.constraints import AxisLimits, ConstraintRows, constraint_rows
from servogen.sets.polyhedron import maximise

# What the redundancy test forgives, plus what two linear programs leave open.
PROOF_TOLERANCE = 1e-8
# Corners of a facet that are mixed; as many as a simplex of states and command has, and one more.
CORNERS = 5


@dataclass(frozen=True)
class RowProof:
    """One claim: over the set, a row never exceeds its bound; in shares of the bound.

    ``excess`` is the maximum found less the bound: at most ``PROOF_TOLERANCE`` if it holds.
    """

    name: str
    excess: float


@dataclass(frozen=True)
class SetProof:
    """A claim for every row; ``worst`` is the largest excess."""

    rows: tuple[RowProof, ...]

    @property
    def worst(self) -> float:
        """Largest excess, in shares of the bound."""
        return max(row.excess for row in self.rows)

    @property
    def holds(self) -> bool:
        """Whether every row stays within ``PROOF_TOLERANCE`` of its bound."""
        return self.worst <= PROOF_TOLERANCE


def _support(target: AdmissibleSet, x_row: FloatArray, r_row: float) -> float:
    """Greatest x_row x + r_row r over the set."""
    h = np.column_stack([target.h_x, target.h_r])
    return maximise(h, target.k, np.append(x_row, r_row)).value


def prove_invariance(target: AdmissibleSet, a: FloatArray, b: FloatArray) -> SetProof:
    """Facet by facet: (x, r) inside implies (a x + b r, r) inside.

    All facets are proved, both of each pair; ``a`` (n, n), ``b`` (n,) of the sampled stage.
    """
    proofs = []
    for i in range(target.k.size):
        x_row = target.h_x[i] @ a
        r_row = float(target.h_x[i] @ b + target.h_r[i])
        excess = _support(target, x_row, r_row) - float(target.k[i])
        proofs.append(RowProof(f"facet {i}", excess))
    return SetProof(tuple(proofs))


def prove_admissibility(
    target: AdmissibleSet,
    slow: StateSpace,
    sample_time_s: float,
    limits: AxisLimits,
    inter_sample_rows: int = 0,
) -> SetProof:
    """Inside implies every limit kept, at the sample and at the inter-sample instants; and at rest.

    The last row is the steady state: |r| at most (1 - eps) of the position limit.
    """
    rows = constraint_rows(slow, sample_time_s, limits, inter_sample_rows)
    proofs = [
        RowProof(name, _support(target, rows.x_rows[i], float(rows.r_rows[i])) - 1.0)
        for i, name in enumerate(rows.names)
    ]
    steady = 1.0 / ((1.0 - target.tightening) * limits.position_m)
    zero = np.zeros(target.h_x.shape[1])
    proofs.append(RowProof("steady state", _support(target, zero, steady) - 1.0))
    return SetProof(tuple(proofs))


@dataclass(frozen=True)
class MaximalityCheck:
    """Points just outside: how many, how many of them broke no limit later, and by how much.

    Attributes:
        points: tried.
        innocent: kept every limit for ever: the set would be too small there. Must be zero.
        least_violation: smallest, over the points, of the greatest excess of a limit seen later,
            in shares of the limit: how clearly the set is maximal.
        latest_step: the latest sample at which a point first broke a limit.
    """

    points: int
    innocent: int
    least_violation: float
    latest_step: int


def check_maximality(
    target: AdmissibleSet,
    slow: StateSpace,
    sample_time_s: float,
    limits: AxisLimits,
    inter_sample_rows: int = 0,
    samples: int = 20,
    distance: float = 1e-6,
    seed: int = 1,
) -> MaximalityCheck:
    """Sample every facet, step ``distance`` (relative) outside, hold r and see a limit broken.

    A facet's points are random mixtures of its own corners, found by linear programs with random
    objectives. A step outside is a scaling about the origin, which is interior.

    Args:
        samples: points per facet (one facet of each pair: the other is its mirror image).
        distance: relative, well above ``PROOF_TOLERANCE``.
    """
    held = discretise(slow, sample_time_s)
    rows = constraint_rows(slow, sample_time_s, limits, inter_sample_rows)
    generator = np.random.default_rng(seed)
    steps = 2 * target.finite_step + 20
    points = innocent = latest = 0
    least = float("inf")
    h = np.column_stack([target.h_x, target.h_r])
    sizes = np.array([maximise(h, target.k, axis).value for axis in np.eye(h.shape[1])])
    for facet in range(target.k.size // 2):
        objectives = generator.normal(size=(CORNERS, h.shape[1])) / sizes
        corners = _facet_corners(h, target.k, facet, objectives)
        shares = generator.dirichlet(np.ones(len(corners)), size=samples)
        for point in shares @ corners * (1.0 + distance):
            history = _excesses(rows, held.a, held.b, point, steps)
            history[0] = max(history[0], _steady_excess(target, limits, point[-1]))
            broken = np.flatnonzero(history > 0.1 * distance)
            points += 1
            innocent += int(broken.size == 0)
            latest = max(latest, int(broken[0]) if broken.size else 0)
            least = min(least, float(np.max(history)))
    return MaximalityCheck(points, innocent, least, latest)


def _facet_corners(h: FloatArray, k: FloatArray, facet: int, objectives: FloatArray) -> FloatArray:
    """(objectives, n + 1) corners (x, r) of one facet, one for each objective."""
    on_facet, bounds = np.vstack([h, -h[facet]]), np.append(k, -k[facet])
    corners = []
    for objective in objectives:
        best = maximise(on_facet, bounds, objective)
        assert best.point is not None  # the set is bounded
        corners.append(best.point)
    return np.array(corners)


def _excesses(
    rows: ConstraintRows, a: FloatArray, b: FloatArray, point: FloatArray, steps: int
) -> FloatArray:
    """(steps + 1,) greatest excess of any limit at each sample, r held."""
    state, command = point[:-1], float(point[-1])
    history = np.zeros(steps + 1)
    for t in range(steps + 1):
        history[t] = np.max(np.abs(rows.x_rows @ state + rows.r_rows * command)) - 1.0
        state = a @ state + b * command
    return history


def _steady_excess(target: AdmissibleSet, limits: AxisLimits, command: float) -> float:
    return abs(command) / ((1.0 - target.tightening) * limits.position_m) - 1.0
