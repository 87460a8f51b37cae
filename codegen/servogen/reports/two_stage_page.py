"""The page of a two-stage machine."""

from __future__ import annotations

from servogen.reports.count_tables import wcet_parts
from servogen.reports.data import ReportData
from servogen.reports.evidence_tables import evidence_parts
from servogen.reports.iteration_tables import iteration_parts
from servogen.reports.page import Page, render
from servogen.reports.path_figure import path_figure
from servogen.reports.run_tables import (
    constraint_table,
    design_tables,
    status_table,
    study_table,
)
from servogen.reports.set_figure import set_figure
from servogen.reports.step_tables import build_parts, sil_parts
from servogen.reports.study_figure import study_figure
from servogen.reports.summary import key_figures, summary
from servogen.reports.tables import Missing, Section
from servogen.reports.time_figures import time_figures
from servogen.reports.two_stage_checks import all_checks


def make_report(data: ReportData) -> str:
    """See ``page.render``; the same data give the same bytes."""
    return render(
        Page(
            name=data.machine.project.name,
            digest=data.digest,
            summary=summary(data),
            tiles=key_figures(data),
            checks=all_checks(data),
            sections=_sections(data),
        )
    )


def _sections(data: ReportData) -> list[Section]:
    study: tuple[object, ...]
    if data.study:
        study = (study_figure(data.study), study_table(data.study))
    else:
        study = (Missing("The controllers have not been compared", f"servogen study {data.toml}"),)
    return [
        Section("path", "Path", (path_figure(data),)),
        Section("signals", "Motion", tuple(time_figures(data))),
        Section(
            "constraints",
            "Constraints",
            (constraint_table(data.row.bounds), status_table(data.row.statuses), set_figure(data)),
        ),
        Section("study", "Study", study),
        Section("sil", "Equivalence", tuple(sil_parts(data))),
        Section("wcet", "Counts and cycles", (*wcet_parts(data), *iteration_parts(data))),
        Section("evidence", "Evidence", tuple(evidence_parts(data))),
        Section("build", "Build", (*design_tables(data), *build_parts(data))),
    ]
