"""A claim about a design and what its proof found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """One claim about a design.

    Attributes:
        name: with the axis or the controller, ``x: invariance of O-infinity``.
        holds: proved.
        excess: what was found above the bound claimed, in the claim's own shares; a claim holds up
            to ``tolerance``.
        cases: how many facets, rows or points it was proved on; none proves nothing.
        kind: ``proof``, or ``sample`` where points stand for all of them.
    """

    name: str
    holds: bool
    excess: float
    tolerance: float
    cases: int
    kind: str = "proof"

    def to_json(self) -> dict[str, object]:
        return {
            "name": self.name,
            "holds": self.holds,
            "excess": self.excess,
            "tolerance": self.tolerance,
            "cases": self.cases,
            "kind": self.kind,
        }
