"""What paper 1's theorems ask of a design, proved on the design itself by linear programs.

Nothing here is used to make the design: the sets, the terminal cost and the terminal rows are taken
as they are and held against the sampled plant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from servogen.controllers.mpc_design import MpcDesign
from servogen.plants.statespace import FloatArray, StateSpace, discretise
from servogen.qp.condense import (
    LYAPUNOV_TOLERANCE,
    TrackingWeights,
    lyapunov_excess,
    prediction,
    stage_cost,
)
from servogen.sets.admissible import AdmissibleSet
from servogen.sets.constraints import AxisLimits
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import maximise
from servogen.sets.proofs import (
    PROOF_TOLERANCE,
    check_maximality,
    prove_admissibility,
    prove_invariance,
)
from servogen.systems.claims import Claim

# Points tried outside each facet; each is one linear program's worth of work.
SAMPLES_PER_FACET = 5


def set_claims(
    axis: str,
    admissible: AdmissibleSet,
    slow: StateSpace,
    sample_time_s: float,
    limits: AxisLimits,
    inter_sample_rows: int,
) -> list[Claim]:
    """Result 1: O-infinity is invariant under a held command, admissible, and not too small."""
    plant = discretise(slow, sample_time_s)
    invariant = prove_invariance(admissible, plant.a, plant.b)
    kept = prove_admissibility(admissible, slow, sample_time_s, limits, inter_sample_rows)
    return [
        _claim(f"{axis}: O-infinity is invariant", invariant.worst, len(invariant.rows)),
        _claim(f"{axis}: O-infinity keeps every limit", kept.worst, len(kept.rows)),
        _outside(axis, admissible, slow, sample_time_s, limits, inter_sample_rows),
    ]


def _outside(
    axis: str,
    admissible: AdmissibleSet,
    slow: StateSpace,
    sample_time_s: float,
    limits: AxisLimits,
    inter_sample_rows: int,
) -> Claim:
    """A facet that is none (no point of the set lies on it) makes the claim false too."""
    name = f"{axis}: outside O-infinity a limit is broken"
    try:
        found = check_maximality(
            admissible, slow, sample_time_s, limits, inter_sample_rows, SAMPLES_PER_FACET
        )
    except SetError:
        return Claim(name, False, math.inf, 0.0, admissible.k.size, "sample")
    holds = found.innocent == 0 and found.points > 0
    return Claim(name, holds, float(found.innocent), 0.0, found.points, "sample")


def terminal_claims(
    axis: str,
    mpc: MpcDesign,
    admissible: AdmissibleSet,
    weights: TrackingWeights,
    limits: AxisLimits,
) -> list[Claim]:
    """(16g) and (17): the emitted terminal rows imply O-infinity, the terminal cost falls."""
    q, _ = stage_cost(mpc.plant.order, weights, limits)
    falls = lyapunov_excess(mpc.plant, q, mpc.qp.terminal_cost)
    h_x, h_r, k = admissible.pairs()
    at_the_end = _State.of(mpc)
    known = _known_at_the_end(mpc, at_the_end, admissible, limits)
    both, ones = np.vstack([known, -known]), np.ones(2 * len(known))
    facets = [at_the_end.row(h_x[i], h_r[i]) / k[i] for i in range(k.size)]
    worst = max(maximise(both, ones, facet).value - 1.0 for facet in facets)
    return [
        Claim(
            f"{axis}: the terminal cost falls by the stage cost (17)",
            falls <= LYAPUNOV_TOLERANCE,
            falls,
            LYAPUNOV_TOLERANCE,
            mpc.plant.order,
        ),
        _claim(f"{axis}: the terminal rows imply O-infinity (16g)", worst, len(facets)),
    ]


@dataclass(frozen=True)
class _State:
    """(x_N, r_N) on what the program sees: plan less position (N,), velocity and what follows it
    (n-1,), position, r_N less position."""

    on_plan: FloatArray  # (n, N)
    on_rest: FloatArray  # (n, n-1)

    @staticmethod
    def of(mpc: MpcDesign) -> _State:
        on_command, on_state = prediction(mpc.plant, mpc.horizon)
        return _State(on_command[mpc.horizon], on_state[mpc.horizon][:, 1:])

    def row(self, on_state: FloatArray, on_reference: float) -> FloatArray:
        """A row on (x_N, r_N) in these variables; a plan that stands at p ends at p."""
        ends = [on_state[0] + on_reference, on_reference]
        return np.concatenate([on_state @ self.on_plan, on_state @ self.on_rest, ends])


def _known_at_the_end(
    mpc: MpcDesign, at_the_end: _State, admissible: AdmissibleSet, limits: AxisLimits
) -> FloatArray:
    """Rows with bounds of one that hold at step N: the emitted terminal rows, the limits and the
    range of the fast stage (rows of step N), and what the governor keeps of the command alone."""
    n = mpc.plant.order
    unit = np.eye(n)
    rows = [
        at_the_end.row(unit[0] / limits.position_m, 0.0),
        at_the_end.row(unit[1] / limits.velocity_m_per_s, 0.0),
        at_the_end.row(unit[2] / limits.acceleration_m_per_s2, 0.0),
        at_the_end.row(unit[0] / limits.fast_range_m, -1.0 / limits.fast_range_m),
    ]
    for h_x, h_r, k in zip(*admissible.pairs(), strict=True):
        if not h_x.any():
            rows.append(at_the_end.row(h_x, h_r) / k)
    qp = mpc.qp
    for i in range(qp.terminal_rows):
        at = qp.rows_command.shape[0] - qp.terminal_rows + i
        ends = [qp.terminal_position[i], qp.terminal_reference[i]]
        row = np.concatenate([qp.rows_command[at], qp.rows_state[at], ends])
        rows.append(row / qp.terminal_bound[i])
    return np.array(rows)


def _claim(name: str, excess: float, cases: int) -> Claim:
    return Claim(name, cases > 0 and excess <= PROOF_TOLERANCE, excess, PROOF_TOLERANCE, cases)
