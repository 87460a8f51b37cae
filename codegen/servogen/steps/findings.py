"""Findings of the line's own steps, in the form of every other check."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from servogen.evidence.bench import Bench
from servogen.evidence.finding import Finding
from servogen.evidence.tools import version_of
from servogen.progress import Progress
from servogen.steps.count import WcetResult, count
from servogen.steps.equivalence import SilResult, equivalence
from servogen.steps.prepare import Prepared
from servogen.steps.simulate import SimulateResult, simulate
from servogen.systems.design_proofs import Claim, set_claims, terminal_claims

# The steps that `servogen run` does by itself; name -> title, in the order of the certificate.
STEPS = {
    "sets": "Admissible sets proved",
    "terminal": "Terminal condition",
    "sil": "C equals the reference",
    "wcet": "Fits the target",
    "simulate": "Closed loop within its limits",
}

# They run what is shipped; the others examine both precisions.
OF_ONE_PRECISION = ("wcet", "simulate")


def step_finding(prepared: Prepared, name: str, bench: Bench, progress: Progress) -> Finding:
    """Do one of ``STEPS`` and put what it found into the common form."""
    match name:
        case "sets":
            return sets_finding(prepared, bench)
        case "terminal":
            return terminal_finding(prepared, bench)
        case "sil":
            return sil_finding(equivalence(prepared, None, progress), bench)
        case "wcet":
            return wcet_finding(count(prepared, None), bench)
        case "simulate":
            return simulate_finding(simulate(prepared, False, progress), bench)
    raise KeyError(name)


def sets_finding(prepared: Prepared, bench: Bench) -> Finding:
    """Invariance and admissibility of O-infinity, and points just outside of it."""
    machine = prepared.machine
    sets = (machine.sets.x, machine.sets.y)
    inter = machine.project.controller.governor.inter_sample_rows
    claims = [
        claim
        for i, axis in enumerate("xy")
        for claim in set_claims(
            axis, sets[i], machine.slow[i], machine.slow_period_s, machine.limits[i], inter
        )
    ]
    return _of_claims("sets", claims, bench)


def terminal_finding(prepared: Prepared, bench: Bench) -> Finding:
    """(16g) and (17) of every program; a governor alone has none, and nothing to be proved."""
    machine, mpc = prepared.machine, prepared.design.mpc
    if mpc is None:
        summary = "does not apply: this controller solves no program"
        return Finding("terminal", True, summary, {}, bench.digests, applies=False)
    sets = (machine.sets.x, machine.sets.y)
    claims = [
        claim
        for i, axis in enumerate("xy")
        for claim in terminal_claims(
            axis, mpc[i], sets[i], prepared.tuning.weights, machine.limits[i]
        )
    ]
    return _of_claims("terminal", claims, bench)


def _of_claims(check: str, claims: list[Claim], bench: Bench) -> Finding:
    broken = tuple(
        f"{c.name}: {c.excess:.3g} where {c.tolerance:.3g} is allowed, on {c.cases}"
        for c in claims
        if not c.holds
    )
    cases = sum(c.cases for c in claims)
    worst = max(c.excess for c in claims if c.kind == "proof")
    return Finding(
        check=check,
        passed=not broken,
        summary=f"{len(claims)} claims on {cases} rows and points, largest excess {worst:.2g}",
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


def simulate_finding(result: SimulateResult, bench: Bench) -> Finding:
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
