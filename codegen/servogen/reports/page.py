"""The page: sections, figures and styles into one HTML text."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from servogen import __version__
from servogen.reports.checks import Check, verdict
from servogen.reports.style import Figure
from servogen.reports.tables import Missing, Section, Table
from servogen.reports.tiles import KeyFigure

_HERE = Path(__file__).parent


@dataclass(frozen=True)
class Page:
    """What a page says.

    Attributes:
        name: of the project; digest: of its design.
        summary: for somebody who reads nothing else; the verdict is added.
        tiles, checks, sections: in the order of the page.
    """

    name: str
    digest: str
    summary: str
    tiles: list[KeyFigure]
    checks: list[Check]
    sections: list[Section]


def render(page: Page) -> str:
    """One HTML file with everything in it: no other file, no network, no clock.

    The same page gives the same bytes.
    """
    told = verdict(page.checks)
    figures = [part for s in page.sections for part in s.parts if isinstance(part, Figure)]
    return _template().render(
        name=page.name,
        version=__version__,
        digest=page.digest,
        verdict=told,
        summary=f"{page.summary} {told.text}.",
        tiles=page.tiles,
        checks=page.checks,
        sections=page.sections,
        kind=_kind,
        css=Markup((_HERE / "page.css").read_text(encoding="utf-8")),
        javascript=Markup((_HERE / "page.js").read_text(encoding="utf-8")),
        plotly=Markup(_plotly()),
        plots=Markup(_plots(figures)),
    )


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
