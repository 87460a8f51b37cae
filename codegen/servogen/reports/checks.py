"""The verdict: every check, passed, failed or not run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from servogen.evidence.certificate import FAILED, MEASURED, NOT_RUN, PASSED
from servogen.reports.data import Found
from servogen.reports.numbers import count, number, percent


@dataclass(frozen=True)
class Check:
    """``passed`` None: not run. ``hint`` is the command that would run it."""

    name: str
    passed: bool | None
    detail: str
    hint: str = ""

    @property
    def state(self) -> str:
        return {True: "passed", False: "failed", None: "not run"}[self.passed]


def step_checks(data: Found) -> list[Check]:
    """What the emitted C has to stand, whatever the system."""
    return [
        _step(data, "C equals the reference", "sil", data.sil, _sil_detail),
        _step(data, "Fits the target", "wcet", data.wcet, _wcet_detail),
    ]


def build_checks(data: Found) -> list[Check]:
    """That it was emitted, and the evidence about it."""
    return [_build(data), _evidence(data)]


def _step(
    data: Found,
    name: str,
    verb: str,
    found: Mapping[str, Any] | None,
    detail: Callable[[Mapping[str, Any]], str],
) -> Check:
    """A verb's own judgement; a result that does not say that it passed has not."""
    hint = f"servogen {verb} {data.toml}"
    if found is None:
        return Check(name, None, "not run", hint)
    return Check(name, found.get("passed") is True, detail(found))


def _sil_detail(found: Mapping[str, Any]) -> str:
    scenarios = [s for s in found.get("scenarios") or () if isinstance(s, Mapping)]
    failed = sum(s.get("passed") is not True for s in scenarios)
    told = count(len(scenarios), "scenario")
    precisions = dict.fromkeys(str(s.get("precision")) for s in scenarios)
    if precisions:
        told += f" in {' and '.join(precisions)}"
    return f"{told}, {number(failed)} differ" if failed else told


def _wcet_detail(found: Mapping[str, Any]) -> str:
    budgets = found.get("budgets")
    told = []
    for entry, budget in budgets.items() if isinstance(budgets, Mapping) else ():
        used = budget.get("utilisation")
        if isinstance(used, int | float):
            told.append(f"{percent(used)} of the budget of {entry}")
    return ", ".join(told) or "counted"


def _build(data: Found) -> Check:
    """Emitted, and from the design that this report is about."""
    name = "C emitted"
    if data.build is None:
        return Check(name, None, "not run", f"servogen build {data.toml}")
    if data.build.get("design_hash", data.digest) != data.digest:
        return Check(name, False, "from another design than the one in this report")
    files = data.build.get("files")
    told = count(len(files), "file") if isinstance(files, Mapping | list) else "emitted"
    return Check(name, data.build.get("passed") is True, told)


def _evidence(data: Found) -> Check:
    """The certificate as one line; what it misses makes it one that was not run."""
    found, name = data.certificate, "Evidence about the C"
    if found is None:
        return Check(name, None, "not run", f"servogen run {data.toml}")
    missing, failed = found.having(NOT_RUN), found.having(FAILED)
    if failed:
        return Check(name, False, f"failed: {', '.join(entry.name for entry in failed)}")
    if missing:
        return Check(name, None, "not run", f"servogen {missing[0].command}")
    told = f"{len(found.having(PASSED))} checks"
    if measured := [entry.name for entry in found.having(MEASURED)]:
        told += f"; measured, not proved: {', '.join(measured)}"
    return Check(name, found.result == PASSED, told)


@dataclass(frozen=True)
class Verdict:
    """``state``: passed, partly (something was not run) or failed."""

    state: str
    text: str


def verdict(checks: list[Check]) -> Verdict:
    """One line for all checks."""
    failed = [check.name for check in checks if check.passed is False]
    missing = [check.name for check in checks if check.passed is None]
    if failed:
        count = f"{len(failed)} check{'s' if len(failed) > 1 else ''} failed"
        return Verdict("failed", f"{count}: {', '.join(failed)}")
    if missing:
        done = len(checks) - len(missing)
        return Verdict("partly", f"{done} checks passed; not run: {', '.join(missing)}")
    return Verdict("passed", f"All {len(checks)} checks passed")
