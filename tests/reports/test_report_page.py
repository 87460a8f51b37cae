"""The page: self-contained, the same bytes each time, escaped, honest about what was not run."""

from __future__ import annotations

import html
import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import plotly.graph_objects
import pytest

from servogen.reports import ReportData, make_report
from servogen.reports.checks import verdict
from servogen.reports.two_stage_checks import all_checks

SCRIPT = re.compile(r"<script[^>]*>.*?</script>", re.DOTALL)


def markup(page: str) -> str:
    """The page without its scripts."""
    return SCRIPT.sub("", page)


def readable(page: str) -> str:
    """What a person reads: no tags, thousands unspaced."""
    text = re.sub(r"<style>.*?</style>", "", markup(page), flags=re.DOTALL)
    return html.unescape(re.sub(r"<[^>]+>", " ", text)).replace("\u202f", "")


def plots(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="plots">(.*?)</script>', page, re.DOTALL)
    assert found
    return dict(json.loads(found.group(1)))


@pytest.fixture(scope="module")
def page(full: ReportData) -> str:
    return make_report(full)


@pytest.fixture(scope="module")
def bare_page(bare: ReportData) -> str:
    return make_report(bare)


def test_same_data_same_bytes(full: ReportData, page: str) -> None:
    assert make_report(full) == page


def test_it_is_under_ten_megabytes_with_the_longest_signals(full: ReportData) -> None:
    """The paper's 232,100 points: what decimation leaves of them must fit."""
    rng = np.random.default_rng(7)
    m, k = full.machine.ratio, 8000
    rows = rng.integers(0, full.run.periods, k)
    fine = (rows[:, None] * m + np.arange(m)).ravel()
    run = replace(
        full.run,
        status=full.run.status[rows],
        status_axis=full.run.status_axis[rows],
        iterations=full.run.iterations[rows],
        interval_points=full.run.interval_points[rows],
        first_point=full.run.first_point[rows],
        slow=full.run.slow[rows],
        command=full.run.command[rows],
        slow_fine=full.run.slow_fine[fine],
        fast_command=full.run.fast_command[fine],
        reference=full.run.reference[fine],
        along=full.run.along[fine],
        fast_position=full.run.fast_position[fine],
    )
    text = make_report(replace(full, run=run, contour_error=full.contour_error[fine]))
    assert run.reference.shape[0] > 232_100
    assert len(text.encode()) < 10_000_000


def test_nothing_is_asked_from_elsewhere(page: str) -> None:
    own = markup(page)
    assert not re.findall(r"https?:|//[a-z]|@import|\burl\(", own)
    assert not re.findall(r"\bsrc=|<link(?! rel=\"icon\" href=\"data:,\")|<iframe|<img", own)
    assert "default-src 'none'" in own
    assert len(re.findall(r"plotly\.js v\d", page)) == 1


def test_no_folder_of_the_machine_it_was_made_on(full: ReportData, page: str) -> None:
    assert str(full.machine.project.file.parent) not in page


def test_every_figure_is_valid_plotly_with_axis_titles_and_units(page: str) -> None:
    found = plots(page)
    assert list(found) == [
        f"plot-{name}"
        for name in ("path", "positions", "motion", "fast", "feed", "contour", "sets", "study")
    ]
    for name, plot in found.items():
        assert f'id="{name}"' in page
        plotly.graph_objects.Figure({"data": plot["data"], "layout": plot["layout"]})
        layout = plot["layout"]
        used = {t.get("xaxis", "x") for t in plot["data"]}
        axes = [layout[key] for key in layout if "axis" in key]
        titles = [axis["title"]["text"] for axis in axes if "title" in axis]
        assert len(titles) >= 2
        assert all(re.search(r"\[.+\]$", title) for title in titles)
        assert {f"xaxis{axis[1:]}" for axis in used} <= set(layout)


def test_peaks_of_the_run_are_in_the_plots(full: ReportData, page: str) -> None:
    found = plots(page)
    contour = max(v for v in found["plot-contour"]["data"][0]["y"])
    assert contour == pytest.approx(1e6 * full.row.contour_error_m, rel=1e-5)
    for i in range(2):
        drawn = np.array(found["plot-fast"]["data"][i]["y"])
        peak = np.max(np.abs(full.run.fast_position[:, i]))
        assert np.max(np.abs(drawn)) == pytest.approx(1e3 * peak, rel=1e-5)


def test_limits_are_where_the_project_puts_them(page: str) -> None:
    fast = plots(page)["plot-fast"]["data"]
    dashed = {t["y"][0] for t in fast if t["line"].get("dash") == "dash"}
    assert dashed == {10.0, -10.0}


def test_slowed_places_are_those_with_less_than_all_points(full: ReportData, page: str) -> None:
    run = full.run
    short = run.interval_points < run.machine.ratio
    short &= run.first_point + run.interval_points < len(run.machine.timed.points) - 1
    assert short.any()
    marks = next(t for t in plots(page)["plot-path"]["data"] if t["mode"] == "markers")
    ratios = set(np.round(run.interval_points[short] / run.machine.ratio, 4).tolist())
    assert {round(r, 4) for r in marks["marker"]["color"]} == ratios


def test_what_was_not_run_is_said_and_never_passed(bare_page: str) -> None:
    text = readable(bare_page)
    for verb in ("sil", "wcet", "study", "build"):
        assert f"servogen {verb} servogen.toml" in text
    assert text.count("Not run.") == 6
    assert "servogen check counts servogen.toml" in text
    states = re.findall(r'<li class="([a-z-]+)">', bare_page)
    assert states == ["passed"] * 4 + ["not-run"] * 5
    assert "badge partly" in bare_page
    assert "All 9 checks" not in text


def test_all_passed_only_if_all_passed(full: ReportData, page: str) -> None:
    assert "All 9 checks passed" in readable(page)
    worse = [
        replace(full, sil={**(full.sil or {}), "passed": False}),
        replace(full, wcet={**(full.wcet or {}), "passed": False}),
        replace(full, wcet={"schema": "servogen.wcet/1"}),
        replace(full, build={**(full.build or {}), "design_hash": "of something else"}),
        replace(full, row=replace(full.row, complete=False)),
        replace(full, row=replace(full.row, contour_error_m=float("nan"))),
        replace(full, row=replace(full.row, contour_error_m=1.01 * full.contour_limit_m)),
        replace(full, row=replace(full.row, statuses={"OK": 1, "BACKUP": full.row.periods})),
        replace(full, study=[replace(full.row, complete=False)]),
        replace(full, study=[replace(full.row, statuses={"BACKUP": full.row.periods})]),
    ]
    assert full.certificate is not None
    failed = replace(full.certificate.entries[0], state="failed")
    worse.append(replace(full, certificate=replace(full.certificate, entries=(failed,))))
    broken = replace(full.row.bounds[0], worst=full.row.bounds[0].limit * 1.001)
    worse.append(replace(full, row=replace(full.row, bounds=(broken, *full.row.bounds[1:]))))
    for data in worse:
        checks = all_checks(data)
        assert [check.passed for check in checks].count(False) == 1
        assert verdict(checks).state == "failed"
    text = make_report(worse[0])
    assert "badge failed" in text
    assert text.count('<li class="failed">') == 1


def test_the_certificate_says_what_was_not_run(full: ReportData, page: str) -> None:
    assert "91 answers equal" in readable(page)
    assert "qemu: 7.2.22" in readable(page)
    assert full.certificate is not None
    missing = replace(full.certificate.entries[0], state="not run", summary="")
    data = replace(full, certificate=replace(full.certificate, entries=(missing,)))
    text = make_report(data)
    assert "badge partly" in text
    assert "Certificate: incomplete" in readable(text)
    assert text.count("servogen check pil") == 2  # in the list of checks and in the table
    faulty = replace(missing, state="failed", faults=("call 3 <differs>",))
    data = replace(full, certificate=replace(full.certificate, entries=(faulty,)))
    assert "call 3 <differs>" in readable(make_report(data))


def test_numbers_of_the_tables_are_those_of_the_data(full: ReportData, page: str) -> None:
    text = readable(page)
    p = full.row.performance
    assert f"{p.time_s:.2f} s" in text
    assert f"{p.ratio:.4f}" in text
    assert f"{p.work[0]:.2f}, {p.work[1]:.2f}" in text
    assert "50.38" in text  # the paper's MPC-20-B
    rows = re.findall(r"<tr>(.*?)</tr>", page, re.DOTALL)
    cells = [
        [html.unescape(c).replace("\u202f", "") for c in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in rows
    ]
    for bound in full.row.bounds:
        factor = 1e3 if bound.unit == "m" else 1.0
        own = next(c for c in cells if c[:2] == [bound.name, bound.where])
        assert float(own[2]) == pytest.approx(factor * bound.worst, rel=1e-4)
        assert float(own[3]) == pytest.approx(factor * bound.limit, rel=1e-9)
        assert own[-1] == ("kept" if bound.enforced else own[-1])
        assert own[-1].startswith("reported") is not bound.enforced
    assert ["float64", "1", "413", "826", "0", "all agree"] in cells
    assert ["float32", "1", "587", "826", "0", "all agree"] in cells
    assert ["corner_step", "fixed part", "1234567", "7654", "3", "11", "21", "31"] in cells
    assert ["corner.c", "4711"] in cells
    assert "37.4%" in text
    assert "1369" in text


def test_a_difference_of_reference_and_c_is_shown(full: ReportData) -> None:
    told = "call 3 (step): status is 'OK' in the reference and 'BACKUP' in the C"
    scenario = {**(full.sil or {})["scenarios"][0], "passed": False, "difference": told}
    data = replace(full, sil={"passed": False, "scenarios": [scenario]})
    text = readable(make_report(data))
    assert told in text
    assert "1 differ" in text


def test_names_are_escaped(full: ReportData) -> None:
    evil = "</script><img src=x onerror=alert(1)>&\"'"
    bounds = (replace(full.row.bounds[0], name=evil), *full.row.bounds[1:])
    data = replace(
        full,
        row=replace(full.row, bounds=bounds, statuses={evil: 3}),
        study=[replace(full.row, name=evil)],
        sil={"passed": True, evil: evil, "scenarios": [{"controller": evil, "passed": True}]},
        wcet={"passed": True, "entry_points": {evil: {"fixed": {evil: 1}}}},
        build={"passed": True, "files": {evil: 1}},
    )
    page = make_report(data)
    assert "<img" not in markup(page)
    assert evil in readable(page)
    assert plots(page)["plot-study"]["data"][0]["text"] == [evil]


def test_a_run_that_is_not_finite_still_makes_a_page(full: ReportData) -> None:
    lost = full.run.fast_position.copy()
    lost[5] = np.nan
    page = make_report(replace(full, run=replace(full.run, fast_position=lost)))
    assert None in plots(page)["plot-fast"]["data"][0]["y"]


def test_the_governor_alone_has_no_solver_plot(full: ReportData) -> None:
    page = make_report(replace(full, design=replace(full.design, mpc=None), build=None))
    assert "yaxis2" not in plots(page)["plot-feed"]["layout"]


def test_unknown_json_is_shown_as_it_stands(full: ReportData) -> None:
    data = replace(full, wcet={"passed": True, "worst_s": 0.00123, "odd": {"a": [1, 2]}})
    text = readable(make_report(data))
    assert "worst [s]" in text
    assert "0.00123" in text
    assert "a 1, 2" in text


def test_static_count_and_run_side_by_side(full: ReportData, page: str) -> None:
    assert "servogen check counts" in readable(page)  # the entry of the fixture is another check's
    assert full.certificate is not None
    static = {"add": 1200, "mul": 700, "div": 0}
    entry = {
        "calls": 77123,
        "static": static,
        "largest_run": static | {"mul": 699},
        "held": True,
        "equal": False,
        "ratio_of_turns_done": 0.983,
    }
    early = entry | {"held": False}  # a call that stopped early did too much for its turns
    equal = entry | {"largest_run": static, "equal": True}
    above = entry | {"largest_run": static | {"div": 1}}
    figures = {
        "float32": {
            "entry_points": {
                "corner_plan": entry,
                "corner_init": equal,
                "bad": above,
                "worse": early,
            }
        }
    }
    kept = replace(full.certificate.entries[0], name="counts", figures=figures)
    told = make_report(replace(full, certificate=replace(full.certificate, entries=(kept,))))
    text = readable(told)
    assert "servogen check counts" not in text
    assert "699 / 700" in text
    assert "77123" in text
    for told_as in ("covered", "always equal", "above: div", "not held"):
        assert text.count(told_as) == 1, told_as


def test_targets_and_memory(full: ReportData) -> None:
    memory = {
        "data_bytes": 900, "data_limit_bytes": 1000, "table_bytes": 70, "table_limit_bytes": 60,
        "state": {"corner_t": 800}, "arguments": {}, "stack": {"corner_plan": 100},
    }  # fmt: skip
    budget = {"total_cycles": 4711.0, "utilisation": 1.7, "fits": False, "culprit": "X_CAP"}
    targets = {
        "fast": {"memory": memory, "budgets": {"30 ms": budget}, "faults": ["over"]},
        "poor": {"memory": memory, "budgets": {}, "faults": ["poor has no cycles for float64"]},
    }
    wcet = {**(full.wcet or {}), "memory": memory, "targets": targets}
    text = readable(make_report(replace(full, wcet=wcet)))
    for told in (
        "stack of corner_plan",
        "too small",
        "over: X_CAP",
        "170",
        "no cycles for float64",
    ):
        assert told in text
