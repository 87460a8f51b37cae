"""The page of a command governor: same bytes, valid plots, its data's numbers, honest verdicts."""

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

from servogen.reports import GovernorReportData, browser, chromium, make_governor_report
from servogen.reports.checks import verdict
from servogen.reports.governor_figures import limits_figure, taken_figure
from servogen.reports.governor_page import governor_checks
from servogen.reports.numbers import number

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from governor_example import compared, simulated, small_system

# One worker: the small machine is compared once.
pytestmark = pytest.mark.xdist_group("governor example")
PLOTS = ("flow", "pattern", "tube", "path", "response", "stroke", "limits", "taken", "study")


@pytest.fixture(scope="module")
def bare() -> GovernorReportData:
    """Only the closed loop was run."""
    own, done = small_system(), simulated()
    return GovernorReportData(own.machine, own.design, done.run, done.row, tuple(done.faults))


@pytest.fixture(scope="module")
def full(bare: GovernorReportData) -> GovernorReportData:
    """With the comparison, and what the C was found to do."""
    figures = small_system().figures
    return replace(
        bare,
        study=compared().found,
        sil={"passed": True, "scenarios": []},
        wcet={"passed": True, "budgets": {"36 ms": {"utilisation": 0.012, "target": "generic"}}},
        build={"passed": True, "design_hash": bare.digest, "files": {"a.c": 1}, **figures},
    )


@pytest.fixture(scope="module")
def page(full: GovernorReportData) -> str:
    return make_governor_report(full)


def plots(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="plots">(.*?)</script>', page, re.DOTALL)
    assert found
    return dict(json.loads(found.group(1)))


def readable(page: str) -> str:
    body = re.sub(r"<(script|style)[^>]*>.*?</\1>", "", page, flags=re.DOTALL)
    return html.unescape(re.sub(r"<[^>]+>", " ", body)).replace("\u202f", "")


def test_same_data_same_bytes_and_no_folder(full: GovernorReportData, page: str) -> None:
    assert make_governor_report(full) == page
    assert str(full.machine.project.file.parent) not in page


def test_every_figure_is_there_and_valid(page: str) -> None:
    found = plots(page)
    assert list(found) == [f"plot-{n}" for n in PLOTS]
    for plot in found.values():
        plotly.graph_objects.Figure({"data": plot["data"], "layout": plot["layout"]})
        axes = [value for key, value in plot["layout"].items() if re.fullmatch(r"[xy]axis\d*", key)]
        titles = [axis["title"]["text"] for axis in axes if "title" in axis]
        assert all(re.search(r"\[.+\]$", title) for title in titles)


def test_the_motion_is_inside_its_envelope(full: GovernorReportData, page: str) -> None:
    traces = plots(page)["plot-tube"]["data"]
    upper, lower, pattern, motion = (np.array(trace["y"]) for trace in traces[:4])
    assert traces[3]["name"] == "minimal motion, x"
    assert np.max(upper) - np.max(pattern) == pytest.approx(0.024, abs=1e-6)
    assert np.max(motion) <= np.max(upper)
    assert np.min(motion) >= np.min(lower)
    assert np.ptp(motion) < np.ptp(pattern)


def test_peaks_of_the_run_are_in_the_plots(full: GovernorReportData, page: str) -> None:
    found, row = plots(page), full.row
    traces = [t for t in found["plot-limits"]["data"] if t["name"] in ("x", "y")]
    for trace, largest in zip(
        traces,
        (row.motion.largest_velocity[0], row.motion.largest_acceleration[0],
         row.motion.largest_velocity[1], row.motion.largest_acceleration[1]), strict=True,
    ):  # fmt: skip
        assert np.max(np.abs(trace["y"])) == pytest.approx(largest, rel=1e-5)
    fast = [t["y"] for t in found["plot-stroke"]["data"] if t["name"].startswith("fast")]
    worst = max(np.max(np.abs(values)) for values in fast)
    assert worst == pytest.approx(0.025 * (1.0 + row.between.stroke), rel=1e-5)


def test_the_slow_stage_is_between_the_bounds_of_its_points(
    full: GovernorReportData, page: str
) -> None:
    """At the ends of every period, by the points that were machined in it."""
    run, traces = full.run, plots(page)["plot-response"]["data"]
    upper, lower = (np.array(traces[i]["y"]) for i in (1, 0))
    position = run.slow_fine[:: full.machine.ratio, 0, 0]
    for ends in (position[:-1], position[1:]):
        assert np.all(ends <= upper[:-1] + 1e-6)
        assert np.all(ends >= lower[:-1] - 1e-6)
    assert np.min(np.minimum(upper[:-1] - ends, ends - lower[:-1])) < 1e-3
    first = full.machine.points[: int(run.taken[0]) + 1, 0]
    assert lower[0] == pytest.approx(np.max(first) - 0.025, abs=1e-6)


def test_axes_that_differ_have_limits_of_their_own(full: GovernorReportData) -> None:
    x, y = full.machine.sets
    other = replace(y.limits, velocity_m_per_s=0.07, acceleration_m_per_s2=1e-3)
    machine = replace(full.machine, sets=(x, replace(y, limits=other)))
    alike, unlike = limits_figure(full), limits_figure(replace(full, machine=machine))
    levels = [
        {(t["name"], t["y"][0]) for t in figure.traces if t["name"].startswith("limit")}
        for figure in (alike, unlike)
    ]
    assert levels[0] == {("limit", 0.1), ("limit", -0.1)}
    assert levels[1] == {
        ("limit, x", 0.1), ("limit, x", -0.1), ("limit, y", 0.07), ("limit, y", -0.07),
        ("limit, y", 0.001), ("limit, y", -0.001),
    }  # fmt: skip
    assert "10 m/s², is beyond" in unlike.caption


def test_iterations_that_are_all_zero_have_a_range(full: GovernorReportData) -> None:
    none = replace(full, run=replace(full.run, iterations=np.zeros_like(full.run.iterations)))
    assert taken_figure(none).layout["yaxis2"]["range"] == [-0.05, 1.0]
    assert "range" not in taken_figure(full).layout["yaxis2"]


def test_the_project_s_own_setting_is_marked(full: GovernorReportData, page: str) -> None:
    assert full.study is not None
    own = [[t.label for t in s.trials if t.is_project] for s in full.study.sweeps]
    assert own[0] == ["N = 3"]
    assert own[2:] == [["1 mm"], ["l + 1, the point after"]]
    text = readable(page)
    assert all(f"{label}, the project's" in text for labels in own for label in labels)


def test_the_options_are_told(full: GovernorReportData, page: str) -> None:
    text = readable(page)
    assert full.study is not None
    for sweep in full.study.sweeps:
        assert sweep.title in text
        for trial in sweep.trials:
            assert trial.label in text
            assert number(trial.rows[1].time_s) in text


def test_numbers_are_those_of_the_data(full: GovernorReportData, page: str) -> None:
    text = readable(page)
    assert full.study is not None
    for row in full.study.rows:
        assert row.name in text
        assert number(row.time_s) in text
    assert f"{len(full.machine.points)} points" in text


def test_what_was_not_run_is_said(bare: GovernorReportData) -> None:
    text = readable(make_governor_report(bare))
    for verb in ("sil", "wcet", "study", "build"):
        assert f"servogen {verb} servogen.toml" in text
    checks = governor_checks(bare)
    assert [check.passed for check in checks] == [True] + [None] * 5
    assert verdict(checks).state == "partly"


def test_a_controller_that_stood_still_is_told(full: GovernorReportData) -> None:
    assert full.study is not None
    rows = list(full.study.rows)
    rows[2] = replace(rows[2], complete=False, stopped="after 9 periods", time_s=float("nan"))
    text = readable(
        make_governor_report(replace(full, study=replace(full.study, rows=tuple(rows))))
    )
    assert "after 9 periods" in text
    assert "nan" not in text.lower().replace("nano", "")


def test_a_fault_anywhere_fails_the_page(full: GovernorReportData) -> None:
    assert full.study is not None
    first, *rest = full.study.rows
    over = replace(first, instants=replace(first.instants, velocity=0.5))
    for data in (
        replace(full, faults=("the path was not finished",)),
        replace(full, study=replace(full.study, rows=(over, *rest))),
        replace(full, sil={"passed": False}),
        replace(full, build={"passed": True, "design_hash": "of another"}),
    ):
        checks = governor_checks(data)
        assert [check.passed for check in checks].count(False) == 1
        assert verdict(checks).state == "failed"
    told = make_governor_report(replace(full, row=over))
    assert "broken" in readable(told)


def _chromium() -> bool:
    try:
        chromium.find_chromium()
    except chromium.BrowserError:
        return False
    return True


@pytest.mark.browser
@pytest.mark.skipif(not _chromium(), reason="apt-get install chromium")
def test_all_plots_are_drawn(page: str, tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    report.write_text(page, encoding="utf-8")
    seen = browser.look(report, tmp_path / "page.png", width=900)
    assert seen.faults == []
    assert seen.plots == len(PLOTS)
