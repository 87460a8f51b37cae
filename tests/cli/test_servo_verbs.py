"""Every verb on the servo drive, from ``init`` on."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from small_project import Outcome

from servogen.project.systems import load_any_project

Command = Callable[..., Outcome]


@pytest.fixture
def drive(tmp_path: Path, servogen_command: Command) -> Path:
    """A copy of the example with a short motion."""
    folder = tmp_path / "mine"
    assert servogen_command("init", "servo_drive", folder).status == 0
    toml = folder / "servogen.toml"
    text = toml.read_text()
    assert "stroke_deg = 270.0" in text
    toml.write_text(text.replace("stroke_deg = 270.0", "stroke_deg = 4.0"))
    return toml


def test_init_gives_a_project_that_is_a_good_one(tmp_path: Path, servogen_command: Command) -> None:
    outcome = servogen_command("init", "servo_drive", tmp_path / "mine")
    assert (outcome.status, outcome.err) == (0, "")
    project = load_any_project(tmp_path / "mine" / "servogen.toml")
    assert (project.system, project.name) == ("servo_drive", "headstock")


def test_run_does_all_of_it(drive: Path, servogen_command: Command) -> None:
    outcome = servogen_command("run", drive)
    assert outcome.status == 0, outcome.err
    out = drive.parent / "out"
    assert (out / "c" / "headstock_mpc_lookup.c").is_file()
    assert (out / "report.html").read_text(encoding="utf-8").count('class="plot"') == 8
    found = {name: json.loads((out / f"{name}.json").read_text()) for name in
             ("build", "sil", "wcet", "simulate", "study", "certificate")}  # fmt: skip
    assert found["build"]["lookup"] == "clip tree, odd across hyperplane 4"
    assert len(found["sil"]["closed_loops"]) == 6
    assert found["sil"]["passed"]
    assert next(iter(found["wcet"]["budgets"])) == "0.5 ms"
    assert found["simulate"]["inside"] == "compiled C"
    states = {check["name"]: check["result"] for check in found["certificate"]["checks"]}
    assert [name for name, state in states.items() if state == "passed"] == [
        "regions", "tree", "sil", "wcet", "simulate",
    ]  # fmt: skip
    assert "terminal" not in states
    assert outcome.out.splitlines()[-1].startswith("run       all checks passed; not run: counts")


def test_the_verbs_one_by_one(drive: Path, servogen_command: Command) -> None:
    folder = drive.parent
    built = servogen_command("build", drive)
    assert (built.status, (folder / "build" / "headstock_pid.c").is_file()) == (0, True)
    sil = servogen_command("sil", drive, "--steps", "20", "--json", "-")
    assert {loop["periods"] for loop in json.loads(sil.out)["closed_loops"]} == {20}
    wcet = servogen_command("wcet", drive, "--target", "tms320vc33")
    assert "within 0.5 ms with headstock_pid" in wcet.out
    assert wcet.status == 0
    referenced = servogen_command("simulate", drive, "--reference")
    assert "with the Python reference inside" in referenced.out
    report = servogen_command("report", drive, "-o", folder / "report.html")
    assert report.status == 0
    assert "without what was not run: sil, study; servogen run does all of it" in report.out
    assert (folder / "report.html").stat().st_size > 1_000_000


def test_a_check_of_its_own_and_one_of_another_system(
    drive: Path, servogen_command: Command
) -> None:
    own = servogen_command("check", "regions", drive)
    assert own.status == 0
    assert "27 regions" in own.out
    other = servogen_command("check", "terminal", drive)
    assert other.status == 2
    assert "CHECK is terminal, expected one of regions, tree, sil" in other.err


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("weight_error = 1e6", "weight_error = nan", "controller.mpc.weight_error is nan"),
        ("speed_deg_per_s = 360.0", "speed_deg_per_s = 1e-3", "at most 5000000 samples"),
        ("motor_inertia_kg_m2 = 0.01", "motor_inertia_kg_m2 = 1e-300", "at least 1e-12"),
        ("[controller.estimator]", "[controller.lookup]\nmax_regions = 1\n[controller.estimator]",
         "controller.lookup.max_regions is 1"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("verb", ["build", "run"])
def test_what_is_refused_leaves_one_line_and_no_folder(
    drive: Path, servogen_command: Command, verb: str, old: str, new: str, told: str
) -> None:
    text = drive.read_text()
    assert old in text
    # 14 moves are too many for the form without regions, so max_regions may leave no form
    text = text.replace("\ncontrol_horizon = 3", "\ncontrol_horizon = 14")
    drive.write_text(text.replace(old, new))
    before = set(drive.parent.iterdir())
    outcome = servogen_command(verb, drive)
    assert outcome.status == 2
    assert told in outcome.err
    assert outcome.err.splitlines()[-1].count("servogen: ") == 1
    assert set(drive.parent.iterdir()) == before


def test_a_budget_that_does_not_hold_is_status_1(drive: Path, servogen_command: Command) -> None:
    drive.write_text(drive.read_text().replace("share = 0.2", "share = 0.001"))
    outcome = servogen_command("wcet", drive)
    assert outcome.status == 1
    assert "over the budget of 0.5 ms by fixed part of headstock_mpc_step" in outcome.out
