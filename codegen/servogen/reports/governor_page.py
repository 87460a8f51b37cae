"""The page of a command governor."""

from __future__ import annotations

from servogen.reports.checks import Check, build_checks, step_checks
from servogen.reports.count_tables import wcet_parts
from servogen.reports.evidence_tables import evidence_parts
from servogen.reports.governor_data import GovernorReportData
from servogen.reports.governor_figures import motion_figures
from servogen.reports.governor_study_parts import study_parts, used_cell
from servogen.reports.numbers import number, percent
from servogen.reports.page import Page, render
from servogen.reports.step_tables import build_parts, sil_parts
from servogen.reports.tables import (
    BAD,
    PLAIN,
    Section,
    Table,
    passed_cell,
    text,
)
from servogen.reports.tiles import KeyFigure, cycles_tile
from servogen.systems.command_governor_rows import NAMES, GovernorRow


def make_governor_report(data: GovernorReportData) -> str:
    """See ``page.render``; the same data give the same bytes."""
    return render(
        Page(
            name=data.machine.project.name,
            digest=data.digest,
            summary=_summary(data),
            tiles=_tiles(data),
            checks=governor_checks(data),
            sections=_sections(data),
        )
    )


def _summary(data: GovernorReportData) -> str:
    project, row = data.machine.project, data.row
    governor = project.controller.governor
    least = project.controller.motion.reference == "minimal_motion"
    return (
        f"Slow stage “{project.name}” under an extended command governor, n = {governor.horizon}, "
        f"N = {governor.sub_samples}, sent to {'the minimal motion' if least else 'the pattern'}. "
        f"It machines {number(len(data.machine.points))} points in {number(row.time_s)} s; an "
        f"ideal machine would take {number(row.ideal_s)} s."
    )


def _tiles(data: GovernorReportData) -> list[KeyFigure]:
    row = data.row
    return [
        KeyFigure(
            "Time", f"{number(row.time_s)} s", f"{number(row.time_s / row.ideal_s)} of ideal"
        ),
        KeyFigure(
            "Acceleration",
            f"{number(max(row.motion.largest_acceleration), 3)} m/s²",
            "largest of the slow stages",
        ),
        KeyFigure(
            "Velocity between instants",
            percent(1.0 + row.between.velocity),
            "of the limit, at every fast sample",
        ),
        KeyFigure(
            "Iterations", number(row.iterations[1]), f"{number(row.iterations[0])} on average"
        ),
        cycles_tile(data),
        KeyFigure("Design", data.digest[:8], f"{data.design.precision.name}, sha-256"),
    ]


def governor_checks(data: GovernorReportData) -> list[Check]:
    """In the order of the page."""
    told = "; ".join(data.faults) or f"{number(data.row.time_s)} s, every limit kept"
    return [
        Check("Closed loop", not data.faults, told),
        *step_checks(data),
        _study_check(data),
        *build_checks(data),
    ]


def _study_check(data: GovernorReportData) -> Check:
    name = "Comparison"
    if data.study is None:
        return Check(name, None, "not run", f"servogen study {data.toml}")
    swept = [row for sweep in data.study.sweeps for t in sweep.trials for row in t.rows]
    rows = dict.fromkeys([*data.study.rows, *swept])
    faults = [f"{row.name}: {fault}" for row in rows for fault in row.faults]
    return Check(name, not faults, "; ".join(faults) or f"{len(data.study.rows)} controllers")


def _sections(data: GovernorReportData) -> list[Section]:
    return [
        Section("motion", "Motion", (*motion_figures(data), limits_table(data.row))),
        Section("study", "Comparison", tuple(study_parts(data))),
        Section("sil", "Equivalence", tuple(sil_parts(data))),
        Section("wcet", "Counts and cycles", tuple(wcet_parts(data))),
        Section("evidence", "Evidence", tuple(evidence_parts(data))),
        Section("build", "Build", tuple(build_parts(data))),
    ]


def limits_table(row: GovernorRow) -> Table:
    """Every limit, where it is kept and at every fast sample."""
    rows = tuple(
        (
            text(name),
            used_cell(getattr(row.instants, name), row.tolerance, BAD),
            passed_cell(getattr(row.instants, name) <= row.tolerance, "kept", "broken"),
            used_cell(getattr(row.between, name), row.tolerance, PLAIN),
        )
        for name in NAMES
    )
    note = "Of the limit. What happens between the instants is told and not promised."
    columns = ("limit", "where it is kept", "verdict", "at every fast sample")
    return Table("Limits of the slow stages", columns, rows, note)
