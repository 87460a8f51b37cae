"""The verdict: every check, passed, failed or not run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from servogen.controllers.cascade_design import declare_parts
from servogen.controllers.design import design_hash
from servogen.evidence.certificate import FAILED, NOT_RUN, PASSED
from servogen.reports.data import ReportData
from servogen.reports.numbers import count, fixed, number, percent


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


def all_checks(data: ReportData) -> list[Check]:
    """In the order of the page."""
    row = data.row
    kept = [b for b in row.bounds if b.enforced]
    broken = [b for b in kept if not b.passed]
    worst_um, limit_um = 1e6 * row.contour_error_m, 1e6 * data.contour_limit_m
    return [
        Check(
            "Path finished",
            row.complete,
            f"{fixed(row.performance.time_s, 2)} s, {number(row.periods)} slow periods",
        ),
        Check(
            "Constraints kept",
            not broken,
            "broken: " + ", ".join(f"{b.name} at {b.where}" for b in broken)
            if broken
            else f"all {len(kept)} enforced constraints",
        ),
        Check(
            "Contour error",
            row.contour_error_m <= data.contour_limit_m,
            f"{number(worst_um)} µm of {number(limit_um)} µm",
        ),
        Check(
            "Backups",
            data.backup_share <= data.backup_share_limit,
            f"{number(row.backups)} of {number(2 * row.periods)} axis steps, "
            f"{percent(data.backup_share_limit)} allowed",
        ),
        _step(data, "C equals the reference", "sil", data.sil, _sil_detail),
        _step(data, "Fits the target", "wcet", data.wcet, _wcet_detail),
        _study(data),
        _build(data),
        _evidence(data),
    ]


def _step(
    data: ReportData,
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
            told.append(f"{entry} {percent(used)}")
    return f"of the budget: {', '.join(told)}" if told else "counted"


def _build(data: ReportData) -> Check:
    """Emitted, and from the design that this report is about."""
    name = "C emitted"
    if data.build is None:
        return Check(name, None, "not run", f"servogen build {data.toml}")
    own = design_hash(declare_parts(data.design))
    if data.build.get("design_hash", own) != own:
        return Check(name, False, "from another design than the one in this report")
    files = data.build.get("files")
    told = count(len(files), "file") if isinstance(files, Mapping | list) else "emitted"
    return Check(name, data.build.get("passed") is True, told)


def _evidence(data: ReportData) -> Check:
    """The certificate as one line; what it misses makes it one that was not run."""
    found, name = data.certificate, "Evidence about the C"
    if found is None:
        return Check(name, None, "not run", f"servogen run {data.toml}")
    missing, failed = found.having(NOT_RUN), found.having(FAILED)
    if failed:
        return Check(name, False, f"failed: {', '.join(entry.name for entry in failed)}")
    if missing:
        return Check(name, None, "not run", f"servogen {missing[0].command}")
    return Check(name, found.result == PASSED, f"{len(found.having(PASSED))} checks")


def _study(data: ReportData) -> Check:
    name = "Study of controllers"
    if data.study is None:
        return Check(name, None, "not run", f"servogen study {data.toml}")
    failed = [
        row.name
        for row in data.study
        if not row.passed or row.backups > data.backup_share_limit * 2 * row.periods
    ]
    told = f"failed: {', '.join(failed)}" if failed else f"{len(data.study)} controllers"
    return Check(name, bool(data.study) and not failed, told)


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
