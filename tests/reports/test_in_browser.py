"""Headless Chromium sees what a reader sees. Skipped where there is none; ``make browser`` fails
there instead."""

from __future__ import annotations

from pathlib import Path

import pytest

from servogen.reports import ReportData, browser, chromium, make_report

pytestmark = pytest.mark.browser


def _chromium() -> bool:
    try:
        chromium.find_chromium()
    except chromium.BrowserError:
        return False
    return True


needs_chromium = pytest.mark.skipif(not _chromium(), reason="apt-get install chromium")


@needs_chromium
def test_all_plots_are_drawn_and_nothing_is_said(full: ReportData, tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    report.write_text(make_report(full), encoding="utf-8")
    picture = tmp_path / "page.png"
    seen = browser.look(report, picture, width=900, dark=True)
    assert seen.faults == []
    assert seen.plots == 8
    assert picture.read_bytes().startswith(b"\x89PNG")


# Where the page's own script begins; plotly has strict functions of its own before it.
OWN_SCRIPT = '"use strict";\n(function () {\n  const plots'


@needs_chromium
def test_a_spoilt_page_is_found_out(full: ReportData, tmp_path: Path) -> None:
    said = 'console.error("oh"); fetch("http://127.0.0.1:9/").catch(() => {});'
    spoilt = {
        '"type":"scatter"': '"type":"scatter","visible":false',
        "height: 320px": "height: 320px; display: none",
        "default-src 'none'": "default-src *",
        OWN_SCRIPT: said + OWN_SCRIPT,
    }
    faults = " | ".join(browser.look(_written(full, tmp_path, spoilt)).faults)
    assert "plot-path: 2 of 3 traces drawn" in faults
    assert "plot-contour: only 0 by 0 pixels" in faults
    assert "console error: oh" in faults
    assert "asked for http://127.0.0.1:9/" in faults


@needs_chromium
def test_a_script_that_fails_is_found_out(full: ReportData, tmp_path: Path) -> None:
    broken = {OWN_SCRIPT: f'throw new Error("no");{OWN_SCRIPT}'}
    faults = " | ".join(browser.look(_written(full, tmp_path, broken), patience_s=3.0).faults)
    assert "exception: Error: no" in faults
    assert "did not finish" in faults


def _written(data: ReportData, folder: Path, changes: dict[str, str]) -> Path:
    page = make_report(data)
    for old, new in changes.items():
        assert old in page
        page = page.replace(old, new, 1)
    report = folder / "report.html"
    report.write_text(page, encoding="utf-8")
    return report


def test_without_a_browser_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    report = tmp_path / "report.html"
    report.write_text("<p>")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert browser.main([str(report)]) == 2
    assert "apt-get install chromium" in capsys.readouterr().err


def test_without_a_report_it_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert browser.main([str(tmp_path / "none.html")]) == 2
    assert "no report" in capsys.readouterr().err
