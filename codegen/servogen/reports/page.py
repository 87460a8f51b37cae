"""The page: sections, figures and styles into one HTML text."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from servogen import __version__
from servogen.controllers.cascade_design import declare_parts
from servogen.controllers.design import design_hash
from servogen.reports.checks import all_checks, verdict
from servogen.reports.count_tables import wcet_parts
from servogen.reports.data import ReportData
from servogen.reports.evidence_tables import evidence_parts
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
from servogen.reports.style import Figure
from servogen.reports.summary import key_figures, summary
from servogen.reports.tables import Missing, Section, Table
from servogen.reports.time_figures import time_figures

_HERE = Path(__file__).parent


def make_report(data: ReportData) -> str:
    """One HTML file with everything in it: no other file, no network, no clock.

    The same data give the same bytes.
    """
    checks = all_checks(data)
    told = verdict(checks)
    digest = design_hash(declare_parts(data.design))
    sections = _sections(data)
    figures = [part for s in sections for part in s.parts if isinstance(part, Figure)]
    return _template().render(
        name=data.machine.project.name,
        version=__version__,
        digest=digest,
        verdict=told,
        summary=summary(data, told),
        tiles=key_figures(data, digest),
        checks=checks,
        sections=sections,
        kind=_kind,
        css=Markup((_HERE / "page.css").read_text(encoding="utf-8")),
        javascript=Markup((_HERE / "page.js").read_text(encoding="utf-8")),
        plotly=Markup(_plotly()),
        plots=Markup(_plots(figures)),
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
        Section("wcet", "Counts and cycles", tuple(wcet_parts(data))),
        Section("evidence", "Evidence", tuple(evidence_parts(data))),
        Section("build", "Build", (*design_tables(data), *build_parts(data))),
    ]


def _kind(part: object) -> str:
    """What the template does with a part."""
    match part:
        case Figure():
            return "figure"
        case Table():
            return "table"
        case Missing():
            return "missing"
    raise TypeError(f"not a part of a page: {part!r}")


def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_HERE),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("page.html.jinja")


def _plotly() -> str:
    from plotly.offline import get_plotlyjs  # half a second that other verbs need not wait

    return str(get_plotlyjs())


def _plots(figures: list[Figure]) -> str:
    """All figures as JSON that may stand inside a script element."""
    content: dict[str, Any] = {
        f"plot-{figure.name}": {
            "data": figure.traces,
            "layout": {**figure.layout, "height": figure.height},
            "linked": figure.linked,
            "square": figure.square,
        }
        for figure in figures
    }
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
