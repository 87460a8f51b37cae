"""Proofs that a P-tilde is what (5) of paper 4 says: invariant and admissible.

They use the sampled stage in its own states and nothing of the way the set was computed.
"""

from __future__ import annotations

import numpy as np

from servogen.plants.statespace import FloatArray, StateSpace, discretise
from servogen.sets.extended import KINDS, ExtendedSet
from servogen.sets.polyhedron import maximise
from servogen.sets.proofs import RowProof, SetProof

# Two rows closer than this, relative to the larger one, are one row: both are sums of some hundred
# products, and moving a row on by a period only makes them in another order.
SAME_ROW = 1e-11


def prove_extended_invariance(target: ExtendedSet, slow: StateSpace) -> SetProof:
    """Row by row: (x, x_aux, rho) inside implies (A x + B v, A_aux x_aux, rho) inside.

    That is property (b), recursive feasibility, of the programs (6) and (17) without S_k. A row
    that moves on to another row of the set needs no program.
    """
    moved = target.rows @ _period(target, slow)
    known = target.rows
    sizes = np.maximum(np.linalg.norm(known, axis=1), np.finfo(np.float64).tiny)
    proofs = []
    for (kind, instant), row in zip(target.sources, moved, strict=True):
        distance = np.linalg.norm(known - row, axis=1) / sizes
        excess = 0.0 if np.min(distance) <= SAME_ROW else _support(known, row) - 1.0
        proofs.append(RowProof(f"{kind}, instant {instant}", excess))
    return SetProof(tuple(proofs))


def prove_extended_admissibility(target: ExtendedSet, slow: StateSpace) -> SetProof:
    """Inside implies every limit kept at the N instants of the first period, and at rest.

    The last row is V': |rho'| at most (1 - eps) of half the position range.
    """
    n, size = slow.order, target.rows.shape[1]
    limits = target.limits
    bounds = (limits.position_m, limits.velocity_m_per_s, limits.acceleration_m_per_s2)
    proofs = []
    for j in range(target.sub_samples):
        state = np.zeros((n, size))
        state[:, :n] = np.eye(n)
        if j:
            held = discretise(slow, target.sample_time_s * j / target.sub_samples)
            state[:, :n] = held.a
            state[:, n:] = np.outer(held.b, _command(target))
        proofs += [
            RowProof(f"{kind}, instant {j}", _support(target.rows, state[i] / bound) - 1.0)
            for i, (kind, bound) in enumerate(zip(KINDS, bounds, strict=True))
        ]
    steady = np.eye(size)[-1] / ((1.0 - target.tightening) * limits.position_m)
    proofs.append(RowProof("steady state", _support(target.rows, steady) - 1.0))
    return SetProof(tuple(proofs))


def _support(rows: FloatArray, row: FloatArray) -> float:
    """Greatest ``row`` z over {|rows z| <= 1}."""
    return maximise(np.vstack([rows, -rows]), np.ones(2 * len(rows)), row).value


def _command(target: ExtendedSet) -> FloatArray:
    """(aux + 1,) v on the auxiliary state and rho."""
    return np.append(target.auxiliary.c, 1.0)


def _period(target: ExtendedSet, slow: StateSpace) -> FloatArray:
    """(n + aux + 1) square: one slow period of state, auxiliary state and rho."""
    n, aux = slow.order, target.auxiliary.order
    held = discretise(slow, target.sample_time_s)
    step = np.eye(n + aux + 1)
    step[:n, :n] = held.a
    step[:n, n:] = np.outer(held.b, _command(target))
    step[n:-1, n:-1] = target.auxiliary.a
    return step
