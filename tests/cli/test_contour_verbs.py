"""The verbs on the contour controller, from ``init`` on."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from small_project import Outcome

from servogen.project.systems import load_any_project

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from contour_example import OUTPUT, contour_project, shortened

Command = Callable[..., Outcome]


def test_init_gives_projects_that_are_good_ones(tmp_path: Path, servogen_command: Command) -> None:
    outcome = servogen_command("init", "contour_lq", tmp_path / "mine")
    assert (outcome.status, outcome.err) == (0, "")
    project = load_any_project(tmp_path / "mine" / "servogen.toml")
    assert (project.system, project.name) == ("contour_lq", "centre")
    project = load_any_project(tmp_path / "mine" / "plate.toml")
    assert project.sources[1] == tmp_path / "mine" / "plate.ngc"


def test_a_whole_run_ends_with_a_page(
    tmp_path: Path, servogen_command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    shortened(monkeypatch)
    toml = contour_project(tmp_path).file
    found = servogen_command("run", toml, "-o", tmp_path / "out")
    assert found.status == 0, found.err
    out = tmp_path / "out"
    assert {p.name for p in out.iterdir()} >= {"c", "report.html", "certificate.json", "study.json"}
    told = json.loads((out / "simulate.json").read_text())
    assert (told["passed"], told["inside"], told["limited"]) == (True, "compiled C", 0)
    assert told["contour_rms_m"] == pytest.approx(0.6e-6, rel=0.09)
    told = json.loads((out / "wcet.json").read_text())
    assert told["passed"]
    assert "centre" in (out / "report.html").read_text(encoding="utf-8")


def test_a_warning_names_the_angle(tmp_path: Path, servogen_command: Command) -> None:
    toml = contour_project(tmp_path, OUTPUT, ("preview = 10 ", "preview = 1 ")).file
    found = servogen_command("build", toml)
    assert found.status == 0, found.err
    assert "note: controller.contour.terminal: without a guarantee" in found.out
    assert "degrees" in found.out
    proved = servogen_command("check", "contour_stability", toml)
    assert proved.status == 0, proved.err


def test_a_contour_that_is_missed_fails(tmp_path: Path, servogen_command: Command) -> None:
    toml = contour_project(tmp_path, ("limit_m = 5e-6", "limit_m = 5e-7")).file
    found = servogen_command("simulate", toml, "--reference")
    assert found.status == 1
    assert "target.contour_error_limit_m allows 0.5 um" in found.out
