"""The page of a servo drive: same bytes, valid plots, the numbers of its data, honest verdicts."""

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

from servogen.explicit.explore import solve
from servogen.qp.parametric import parametric_qp
from servogen.reports import ServoReportData, browser, chromium, make_servo_report
from servogen.reports.checks import verdict
from servogen.reports.law_names import law_names
from servogen.reports.numbers import MINUS
from servogen.reports.servo_page import servo_checks
from servogen.reports.servo_regions_figure import regions_figure, slice_of, tree_figure, tree_places
from servogen.reports.slice_polygons import area, cut, rectangle

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from servo_example import compared, example, simulated

pytestmark = pytest.mark.xdist_group("servo_drive")


@pytest.fixture(scope="module")
def bare() -> ServoReportData:
    """Only the tasks were run."""
    own = example()
    return ServoReportData(own.servo, own.parts, own.choice, simulated().runs)


@pytest.fixture(scope="module")
def full(bare: ServoReportData) -> ServoReportData:
    """With the study, and what the C was found to do."""
    own = example()
    return replace(
        bare,
        study=compared().found,
        sil={"passed": True, "scenarios": []},
        wcet={"passed": True, "budgets": {"0.5 ms": {"utilisation": 0.012, "target": "generic"}}},
        build={"passed": True, "design_hash": bare.digest, "files": {"a.c": 1}, **own.figures},
    )


@pytest.fixture(scope="module")
def page(full: ServoReportData) -> str:
    return make_servo_report(full)


def plots(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="plots">(.*?)</script>', page, re.DOTALL)
    assert found
    return dict(json.loads(found.group(1)))


def readable(page: str) -> str:
    body = re.sub(r"<(script|style)[^>]*>.*?</\1>", "", page, flags=re.DOTALL)
    return html.unescape(re.sub(r"<[^>]+>", " ", body)).replace("\u202f", "")


def test_same_data_same_bytes_and_no_folder(full: ServoReportData, page: str) -> None:
    assert make_servo_report(full) == page
    assert str(full.servo.project.file.parent) not in page
    assert len(page.encode()) < 10_000_000


def test_every_figure_of_the_paper_is_there_and_valid(page: str) -> None:
    found = plots(page)
    names = ("task0", "task1", "regions", "tree", "horizons", "sine", "waterfall", "laws")
    assert list(found) == [f"plot-{name}" for name in names]
    for plot in found.values():
        plotly.graph_objects.Figure({"data": plot["data"], "layout": plot["layout"]})
        axes = [value for key, value in plot["layout"].items() if re.fullmatch(r"[xy]axis\d*", key)]
        titles = [axis["title"]["text"] for axis in axes if "title" in axis]
        assert all(re.search(r"\[.+\]$", title) for title in titles)
    text = readable(page)
    for figures in ("Figures 5 and 6", "Figures 7 and 8", "Figures 9 and 10", "Figures 14 and 15"):
        assert figures in text
    assert text.count("Figure 16") == 2


def test_peaks_of_the_run_are_in_the_plots(full: ServoReportData, page: str) -> None:
    traces = plots(page)["plot-task0"]["data"]
    for row, run in full.runs[:3:2]:
        own = [trace for trace in traces if trace["name"] == row.controller]
        error, current = np.array(own[1]["y"]), np.array(own[2]["y"])
        assert np.max(np.abs(error)) == pytest.approx(row.largest_error_deg, rel=1e-5)
        assert np.max(np.abs(current)) == pytest.approx(np.max(np.abs(run.current)), rel=1e-5)


def test_numbers_are_those_of_the_data(full: ServoReportData, page: str) -> None:
    text = readable(page)
    assert full.study is not None
    for table in full.study.tables:
        assert f"{table.first_order[7]:.4f}" in text
    for told in ("0.0643", "0.5021", "2762 mA", "clip tree", "27 regions, 91 nodes"):
        assert told in text
    count = full.choice.chosen.count
    assert count is not None
    assert f"{count.multiply_adds} multiply-adds" in text
    assert text.count("chosen") >= 1


def test_what_was_not_run_is_said(bare: ServoReportData) -> None:
    text = readable(make_servo_report(bare))
    for verb in ("sil", "wcet", "study", "build"):
        assert f"servogen {verb} servogen.toml" in text
    checks = servo_checks(bare)
    assert [check.passed for check in checks] == [True] * 4 + [None] * 5
    assert verdict(checks).state == "partly"


def test_a_fault_anywhere_fails_the_page(full: ServoReportData) -> None:
    row, run = full.runs[0]
    over = replace(row.bounds[0], worst=2.0 * row.bounds[0].limit)
    bad = replace(row, bounds=(over, *row.bounds[1:]))
    lost = replace(row, statuses={"OK": 1, "NOT_READY": 2})
    for data in (
        replace(full, runs=((bad, run), *full.runs[1:])),
        replace(full, runs=((lost, run), *full.runs[1:])),
        replace(full, sil={"passed": False}),
        replace(full, build={"passed": True, "design_hash": "of another"}),
    ):
        checks = servo_checks(data)
        assert [check.passed for check in checks].count(False) == 1
        assert verdict(checks).state == "failed"
    assert "badge failed" in make_servo_report(replace(full, sil={"passed": False}))


def test_a_study_that_cannot_be_made_is_told(full: ServoReportData) -> None:
    assert full.study is not None
    absent = replace(
        full.study, tables=(), errors=(), tracks=None, waterfalls=(), absent="too short"
    )
    page = make_servo_report(replace(full, study=absent))
    assert "too short" in readable(page)
    assert "plot-horizons" not in plots(page)


def test_regions_on_the_slice_fill_the_frame_without_overlap(bare: ServoReportData) -> None:
    figure = regions_figure(bare)
    assert figure is not None
    corners = [np.column_stack([t["x"], t["y"]])[:-1] for t in figure.traces]
    frame = area(rectangle(*slice_of(bare)[1].tolist()))
    assert sum(area(own) for own in corners) == pytest.approx(frame, rel=1e-4)


def test_colours_of_the_slice_are_the_laws_that_apply(bare: ServoReportData) -> None:
    """Inside each polygon the law of its name gives the first move of the program's solver."""
    from servogen.qp.parametric_solver import ParametricSolver

    figure = regions_figure(bare)
    assert figure is not None
    solver = ParametricSolver(bare.parts.mpc.problem.qp)
    directions, _ = slice_of(bare)
    solution = next(
        form.solution
        for form in bare.choice.forms
        if form.solution is not None and len(form.solution.regions) == 27
    )
    for trace in figure.traces:
        middle = np.array([np.mean(trace["x"][:-1]), np.mean(trace["y"][:-1])])
        theta = directions @ middle
        law = _number(trace["name"]) - 1
        eta = solution.image.of(theta)
        move = solution.laws.gains[law, 0] @ eta + solution.laws.offsets[law, 0]
        assert move == pytest.approx(solver.solve(theta).z[0], abs=1e-6)


def _number(name: str) -> int:
    return int(name.partition(":")[0].removeprefix("law "))


def test_the_legends_say_what_holds_in_a_law_and_the_same_of_both(bare: ServoReportData) -> None:
    """At a point of each region the program's solver meets the limits that the legend names."""
    from servogen.qp.parametric_solver import ParametricSolver

    regions, tree = regions_figure(bare), tree_figure(bare)
    assert regions is not None
    assert tree is not None
    solver = ParametricSolver(bare.parts.mpc.problem.qp)
    directions, _ = slice_of(bare)
    told: dict[int, str] = {}
    for trace in regions.traces:
        middle = np.array([np.mean(trace["x"][:-1]), np.mean(trace["y"][:-1])])
        plan = solver.solve(directions @ middle).z
        meaning = trace["name"].partition(": ")[2]
        told[_number(trace["name"])] = meaning
        met = [f"u{i}{'+' if u > 0 else MINUS}" for i, u in enumerate(plan) if abs(u) > 999.9999]
        own = met[:1] if met and met[0].startswith("u0") else met
        assert meaning == (" ".join(own) or "free")
        assert trace["text"].endswith(meaning)
    shared = [t["name"] for t in tree.traces if _told(t["name"]) and _number(t["name"]) in told]
    assert len(shared) == 5  # of the six in half a tree
    assert all(name.partition(": ")[2] == told[_number(name)] for name in shared)


def _told(name: str) -> bool:
    return name.startswith("law ")


def test_a_plan_beyond_other_limits_says_how_many() -> None:
    program = parametric_qp(
        np.eye(2), np.eye(2), rows=[[1.0, 1.0]], bounds=[1.0], lower=[-4.0, -4.0], upper=[4.0, 4.0]
    )
    names = law_names(solve(program, 50))
    assert {"free", "1 limit", "u0+", f"u0{MINUS}"} <= set(names)


def test_errors_of_both_controllers_have_axes_of_their_own(
    full: ServoReportData, page: str
) -> None:
    plot = plots(page)["plot-task0"]
    titles = [plot["layout"][f"yaxis{i}"]["title"]["text"] for i in ("2", "3")]
    assert titles == ["MPC error [deg]", "PID error [deg]"]
    most = {}
    for trace in plot["data"]:
        if trace["yaxis"] in ("y2", "y3") and trace["name"] != "limit":
            most[trace["yaxis"]] = (trace["name"], max(abs(v) for v in trace["y"]))
    assert most["y2"][0] == "MPC"
    assert most["y2"][1] < 0.01 * most["y3"][1]
    levels = {t["y"][0] for t in plot["data"] if t["name"] == "limit" and t["yaxis"] == "y2"}
    assert levels == {0.2, -0.2}
    alone = replace(full, runs=full.runs[:2])
    drawn = plots(make_servo_report(alone))["plot-task0"]["layout"]
    assert "yaxis4" not in drawn


def test_the_currents_of_the_study_are_said_not_to_be_the_project_s(page: str) -> None:
    told = "within 1 A at 1 Hz and 12 A at 10 Hz, whatever the project's own current limit"
    assert readable(page).count(told) == 2
    assert readable(page).count("within 12 A at 10 Hz, whatever the project's own") == 2


def test_a_study_whose_loop_is_lost_fails_its_check(full: ServoReportData) -> None:
    study = full.study
    assert study is not None
    lost = replace(study.tables[0], zero_order=np.full(8, np.nan))
    names = {check.name: check for check in servo_checks(full)}
    assert names["Study of horizons"].passed is True
    bad = replace(full, study=replace(study, tables=(lost, *study.tables[1:])))
    check = {check.name: check for check in servo_checks(bad)}["Study of horizons"]
    assert check.passed is False
    assert check.detail == "at 1 Hz a controller does not hold the axis"
    none = replace(full, study=replace(study, tables=(), absent="too short"))
    check = {check.name: check for check in servo_checks(none)}["Study of horizons"]
    assert (check.passed, check.hint) == (None, "")


def test_half_planes_cut_polygons() -> None:
    square = rectangle(2.0, 1.0)
    assert area(square) == 8.0
    half = cut(square, np.array([1.0, 0.0]), 0.0)
    assert area(half) == pytest.approx(4.0)
    assert np.max(half[:, 0]) == 0.0
    assert area(cut(square, np.array([1.0, 1.0]), 2.0)) == pytest.approx(8.0 - 0.5)
    assert cut(square, np.array([1.0, 0.0]), -2.5).shape == (0, 2)
    np.testing.assert_array_equal(cut(square, np.array([0.0, 1.0]), 1.0), square)


def test_the_tree_is_drawn_leaf_by_leaf(bare: ServoReportData) -> None:
    tree = bare.choice.chosen.tree
    figure = tree_figure(bare)
    assert tree is not None
    assert figure is not None
    spots, leaves = tree_places(tree)
    assert len(leaves) == tree.leaves
    assert len(spots) == tree.nodes
    assert max(depth for _, depth in spots.values()) == tree.depth
    drawn = sum(len(t["x"]) for t in figure.traces if t["mode"] == "markers")
    assert drawn == tree.nodes
    # of the nine laws with the first move free, those of the half that the tree is for
    names = {t["name"] for t in figure.traces if t["name"].startswith("law")}
    held = {-1 - int(child) for child in tree.children.ravel() if child < 0}
    assert len(names) == len(held) == 6
    assert {_number(name) for name in names} < set(range(1, 12))


def _chromium() -> bool:
    try:
        chromium.find_chromium()
    except chromium.BrowserError:
        return False
    return True


@pytest.mark.browser
@pytest.mark.skipif(not _chromium(), reason="apt-get install chromium")
def test_all_plots_are_drawn_and_nothing_is_said(page: str, tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    report.write_text(page, encoding="utf-8")
    seen = browser.look(report, width=900, dark=True)
    assert seen.faults == []
    assert seen.plots == 8
