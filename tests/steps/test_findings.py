"""Claims in the form of a finding."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from servogen.evidence.bench import Bench
from servogen.progress import Silent
from servogen.steps.findings import proof_finding
from servogen.steps.system import Proof
from servogen.systems.claims import Claim

BENCH = cast(Bench, SimpleNamespace(digests={"float64": "a"}, subjects=()))
PROVED = Claim("law", True, 2e-9, 1e-8, 9)
SEEN = Claim("moves", True, 3e-4, 1e-3, 1000, "sample")


@pytest.mark.parametrize(
    ("claims", "told"),
    [
        ([PROVED, SEEN], "2 claims on 1009 rows and points, largest excess 2e-09"),
        ([SEEN], "1 claims on 1000 rows and points, samples alone, no proof"),
    ],
)
def test_a_sample_is_never_told_as_a_proof(claims: list[Claim], told: str) -> None:
    given = SimpleNamespace(name="tree", absent="", prove=lambda *_: claims, finding=None)
    proof = cast(Proof, given)
    found = proof_finding(proof, BENCH, Silent())
    assert (found.passed, found.summary) == (True, told)
