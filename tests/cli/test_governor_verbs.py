"""The verbs on the command governor, from ``init`` on."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from small_project import Outcome

from servogen.project.systems import load_any_project
from servogen.systems import command_governor_study
from servogen.systems.command_governor_sweeps import sweeps

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from governor_example import SVG, small_project

Command = Callable[..., Outcome]


def test_init_gives_a_project_that_is_a_good_one(tmp_path: Path, servogen_command: Command) -> None:
    outcome = servogen_command("init", "command_governor", tmp_path / "mine")
    assert (outcome.status, outcome.err) == (0, "")
    project = load_any_project(tmp_path / "mine" / "servogen.toml")
    assert (project.system, project.name) == ("command_governor", "etcher")
    names = {p.name for p in (tmp_path / "mine").iterdir()}
    assert names >= {"figures.svg", "servogen.toml"}
    assert "make_drawing.py" not in names


def test_the_closed_loop_and_the_comparison(
    tmp_path: Path, servogen_command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    toml = small_project(tmp_path).file
    found = servogen_command("simulate", toml, "--reference", "--json", tmp_path / "s.json")
    assert found.status == 0, found.err
    assert "Python reference inside" in found.out
    told = json.loads((tmp_path / "s.json").read_text())
    assert (told["passed"], told["complete"]) == (True, True)
    monkeypatch.setattr(command_governor_study, "sweeps", lambda machine: sweeps(machine)[3:])
    found = servogen_command("study", toml, "--json", "-")
    assert found.status == 0, found.err
    told = json.loads(found.out)
    assert (len(told["rows"]), len(told["sweeps"])) == (10, 1)


def test_the_build_says_what_its_user_should_know(
    tmp_path: Path, servogen_command: Command
) -> None:
    toml = small_project(tmp_path, ('"float64"', '"float32"')).file
    found = servogen_command("build", toml)
    assert found.status == 0, found.err
    assert "          note: controller.governor.weight_reference = 0.01 is small" in found.out
    assert (tmp_path / "build" / "etcher.c").is_file()


def test_the_sets_are_proved(tmp_path: Path, servogen_command: Command) -> None:
    found = servogen_command("check", "list")
    assert "extended_sets" in found.out


def test_a_drawing_that_is_not_admitted_is_one_line(
    tmp_path: Path, servogen_command: Command
) -> None:
    beyond = SVG.replace('cx="110" cy="-100"', 'cx="290" cy="-100"')
    found = servogen_command("simulate", small_project(tmp_path, drawing=beyond).file)
    assert found.status == 2
    assert "two.svg: point " in found.err
    assert found.err.count("\n") == 1
