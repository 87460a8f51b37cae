"""Findings of the line's own steps, in the form of every other check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from servogen.evidence.bench import Bench
from servogen.evidence.finding import Finding
from servogen.evidence.tools import version_of
from servogen.progress import Progress
from servogen.steps.count import WcetResult, count
from servogen.steps.equivalence import SilResult, equivalence
from servogen.steps.prepare import Prepared, proof_titles
from servogen.steps.system import Proof, Simulated, Simulation, Studied
from servogen.systems.claims import Claim

# The steps that `servogen run` does by itself besides the proofs; name -> title, in the order of
# the certificate.
STEPS = {
    "sil": "C equals the reference",
    "wcet": "Fits the target",
    "simulate": "Closed loop within its limits",
}

# They run what is shipped; the others examine both precisions.
OF_ONE_PRECISION = ("wcet", "simulate", "iterations")


def step_titles() -> dict[str, str]:
    """The proofs of every system and the steps, name -> title."""
    return proof_titles() | STEPS


def step_finding(
    prepared: Prepared[Simulated, Studied], name: str, bench: Bench, progress: Progress
) -> Finding:
    """Do a proof of the system or one of ``STEPS`` and put what it found into the common form.

    Raises:
        KeyError: the system has no such proof.
    """
    match name:
        case "sil":
            return sil_finding(equivalence(prepared, None, progress), bench)
        case "wcet":
            return wcet_finding(count(prepared, None), bench)
        case "simulate":
            found = prepared.system.simulate(prepared.package, progress)
            return simulate_finding(found, bench)
    proofs = {proof.name: proof for proof in prepared.system.proofs}
    return proof_finding(proofs[name], bench, progress)


def proof_finding(proof: Proof, bench: Bench, progress: Progress) -> Finding:
    """Claims proved; where there is nothing to claim, the reason."""
    if proof.absent:
        summary = f"does not apply: {proof.absent}"
        return Finding(proof.name, True, summary, {}, bench.digests, applies=False)
    packages = [subject.package for subject in bench.subjects]
    if proof.finding is not None:
        return proof.finding(bench, progress)
    return _of_claims(proof.name, proof.prove(packages, progress), bench)


def _of_claims(check: str, claims: Sequence[Claim], bench: Bench) -> Finding:
    broken = tuple(
        f"{c.name}: {c.excess:.3g} where {c.tolerance:.3g} is allowed, on {c.cases}"
        for c in claims
        if not c.holds
    )
    cases = sum(c.cases for c in claims)
    proved = [c.excess for c in claims if c.kind == "proof"]
    # a lookup without a tree, and the like: what stands there was seen, not proved
    told = f"largest excess {max(proved):.2g}" if proved else "samples alone, no proof"
    return Finding(
        check=check,
        passed=not broken,
        summary=f"{len(claims)} claims on {cases} rows and points, {told}",
        tools=_scipy(),
        subjects=bench.digests,
        figures={"claims": [c.to_json() for c in claims]},
        faults=broken,
        details=tuple(f"{c.name}: {c.cases} {c.kind}s, excess {c.excess:.2g}" for c in claims),
    )


def sil_finding(result: SilResult, bench: Bench) -> Finding:
    """C against reference."""
    found = result.to_json()
    calls = sum(s.agreement.calls for s in result.scenarios)
    decisions = sum(s.agreement.decisions for s in result.scenarios)
    worst = max((s.agreement.worst for s in result.scenarios), default=float("nan"))
    return Finding(
        check="sil",
        passed=result.passed,
        summary=f"{calls} calls, {decisions} decisions, largest difference {worst:g}",
        tools={"gcc": version_of(["gcc", "--version"])},
        subjects=bench.digests,
        figures=_without(found, "schema", "passed"),
        faults=() if result.passed else tuple(result.lines()),
    )


def wcet_finding(result: WcetResult, bench: Bench) -> Finding:
    """Counts and budget."""
    return Finding(
        check="wcet",
        passed=result.passed,
        summary=result.summary,
        tools={"pycparser": version("pycparser"), "gcc": version_of(["gcc", "--version"])},
        subjects=bench.own_digest,
        figures=_without(result.to_json(), "schema", "passed", "faults"),
        faults=tuple(result.fit.faults),
    )


def simulate_finding(result: Simulation, bench: Bench) -> Finding:
    """The closed loop with the compiled C inside."""
    return Finding(
        check="simulate",
        passed=result.passed,
        summary=result.lines()[0].removeprefix("simulate").strip(),
        tools={"gcc": version_of(["gcc", "--version"])},
        subjects=bench.own_digest,
        figures=_without(result.to_json(), "schema", "passed"),
        faults=tuple(result.faults),
    )


def _scipy() -> dict[str, str]:
    return {"scipy (HiGHS)": version("scipy")}


def _without(found: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in found.items() if key not in keys}
