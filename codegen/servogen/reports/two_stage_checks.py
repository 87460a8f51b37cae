"""The checks of a two-stage machine's page."""

from __future__ import annotations

from servogen.reports.checks import Check, build_checks, step_checks
from servogen.reports.data import ReportData
from servogen.reports.numbers import fixed, number, percent


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
        *step_checks(data),
        _study(data),
        *build_checks(data),
    ]


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
