"""The page of a contour controller: same bytes, valid plots, its data, honest verdicts."""

from __future__ import annotations

import html
import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects
import pytest

from servogen.progress import Silent
from servogen.reports import ContourReportData, browser, chromium, make_contour_report
from servogen.reports.checks import verdict
from servogen.reports.contour_figures import contour_figure, magnification, side_figures
from servogen.reports.contour_page import contour_checks, theorem_table
from servogen.reports.contour_study_parts import spectrum_figure
from servogen.reports.numbers import number

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from contour_example import CIRCLE, OUTPUT, SPACE, compared, contour_system, simulated, small_system

# One worker: the example is compared once.
pytestmark = pytest.mark.xdist_group("contour example")
PLOTS = ("contour", "errors", "commands", "spectrum", "trade", "previews", "weights")


@pytest.fixture(scope="module")
def bare() -> ContourReportData:
    """Only the closed loop was run."""
    own, done = small_system(), simulated()
    return ContourReportData(own.machine, own.design, done.run, done.row, tuple(done.faults))


@pytest.fixture(scope="module")
def full(bare: ContourReportData) -> ContourReportData:
    """With the comparison, and what the C was found to do."""
    return replace(
        bare,
        study=compared().found,
        sil={"passed": True, "scenarios": []},
        wcet={"passed": True, "budgets": {"0.5 ms": {"utilisation": 0.024, "target": "generic"}}},
        build={"passed": True, "design_hash": bare.digest, "files": {"a.c": 1}},
    )


@pytest.fixture(scope="module")
def page(full: ContourReportData) -> str:
    return make_contour_report(full)


def plots(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="plots">(.*?)</script>', page, re.DOTALL)
    assert found
    return dict(json.loads(found.group(1)))


def test_every_plot_is_there_and_valid(page: str, full: ContourReportData) -> None:
    found = plots(page)
    assert list(found) == [f"plot-{name}" for name in PLOTS]
    for figure in found.values():
        plotly.graph_objects.Figure(data=figure["data"], layout=figure["layout"])
    assert make_contour_report(full) == page


def test_the_magnified_error_is_the_contour_error(bare: ContourReportData) -> None:
    figure = contour_figure(bare)
    traces = {trace["name"]: trace for trace in figure.traces}
    # a run of about 1 um on a circle of 2 mm: 6 % of it are a hundred times as much
    drawn = traces["tool, error 100 times"]
    radius = np.hypot(np.array(drawn["x"]), np.array(drawn["y"]))
    largest = 100.0 * 1e3 * bare.row.contour_max_m
    assert np.max(np.abs(radius - 1.0)) == pytest.approx(largest, rel=0.05)


def test_a_contour_that_rises_is_seen_from_the_side(bare: ContourReportData) -> None:
    assert side_figures(bare) == []
    own = contour_system(SPACE, (CIRCLE, f"{CIRCLE}rise_m = 0.0005\n"))
    done = own.simulate(None, Silent())
    data = ContourReportData(own.machine, own.design, done.run, done.row)
    (figure,) = side_figures(data)
    seen = figure.traces[0]
    counted = done.run.wanted[own.machine.task.first : own.machine.task.last]
    assert (min(seen["y"]), max(seen["y"])) == pytest.approx(
        (1e3 * counted[0, 2], 1e3 * counted[-1, 2]), abs=1e-3
    )
    assert max(seen["x"]) == pytest.approx(1.0, abs=1e-3)
    assert done.row.contour_rms_m < 1e-6


@pytest.mark.parametrize(
    ("wanted", "largest", "factor"),
    [(1.0, 0.0, 1.0), (1.0, 2.0, 1.0), (1.0, 0.1, 10.0), (1.0, 0.19, 5.0), (1.0, 3e-3, 200.0)],
)
def test_magnifications_are_round(wanted: float, largest: float, factor: float) -> None:
    assert magnification(wanted, largest) == factor


def test_the_spectrum_s_figure_shows_both_end_weights(full: ContourReportData) -> None:
    figure = spectrum_figure(full)
    assert len(figure.traces) == 4
    by_preview = {t["name"]: t["y"] for t in figure.traces if t["xaxis"] == "x2"}
    assert max(by_preview["C'QC at the end"]) == pytest.approx(0.9996, abs=1e-4)
    assert max(by_preview["H_s(Q_max) at the end"]) < 0.877
    assert "No choice made here" in figure.caption
    assert len(spectrum_figure(replace(full, study=None)).traces) == 2


def test_a_warning_and_what_is_not_asked_for_stand_on_the_page() -> None:
    own = contour_system(OUTPUT, ("preview = 10 ", "preview = 1 "))
    done = own.simulate(None, Silent())
    data = ContourReportData(
        own.machine, own.design, done.run, done.row, tuple(done.faults), own.notes
    )
    assert "degrees" in spectrum_figure(data).caption
    assert [row[1].text for row in theorem_table(data).rows][-1] == "not asked for"
    assert not contour_checks(data)[0].passed


def test_verdicts_are_of_the_data(full: ContourReportData, bare: ContourReportData) -> None:
    checks = {check.name: check for check in contour_checks(full)}
    assert checks["Closed loop"].passed
    assert checks["Comparison"].passed
    told = {check.name: check.passed for check in contour_checks(bare)}
    assert told["Comparison"] is None
    failed = replace(full, faults=("contour error 9 um",))
    assert "failed" in verdict(contour_checks(failed)).text


def test_numbers_are_the_run_s(page: str, full: ContourReportData) -> None:
    text = html.unescape(re.sub(r"<[^>]+>", " ", page))
    for value in (full.row.contour_rms_m, full.row.tracking_rms_m):
        assert number(1e6 * value, 3) in text
    assert full.study
    for row in full.study.rows:
        assert row.name in text


def _chromium() -> bool:
    try:
        chromium.find_chromium()
    except chromium.BrowserError:
        return False
    return True


@pytest.mark.browser
@pytest.mark.skipif(not _chromium(), reason="apt-get install chromium")
def test_a_browser_draws_it(page: str, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    seen = browser.look(tmp_path / "report.html")
    assert (seen.plots, seen.faults) == (len(PLOTS), [])
