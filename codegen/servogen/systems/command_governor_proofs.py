"""What paper 4's properties (a) and (b) ask of a P-tilde, proved on the set by linear programs."""

from __future__ import annotations

from servogen.plants.statespace import StateSpace
from servogen.sets.extended import ExtendedSet
from servogen.sets.extended_proofs import (
    prove_extended_admissibility,
    prove_extended_invariance,
)
from servogen.sets.proofs import PROOF_TOLERANCE, SetProof
from servogen.systems.claims import Claim


def extended_claims(axis: str, target: ExtendedSet, slow: StateSpace) -> list[Claim]:
    """The set goes into itself when state and register move on with the same rho, and every limit
    is kept at the N instants of a period that begins in it."""
    return [
        _claim(f"{axis}: P-tilde is invariant", prove_extended_invariance(target, slow)),
        _claim(f"{axis}: P-tilde keeps every limit", prove_extended_admissibility(target, slow)),
    ]


def _claim(name: str, proof: SetProof) -> Claim:
    return Claim(name, proof.holds, proof.worst, PROOF_TOLERANCE, len(proof.rows))
