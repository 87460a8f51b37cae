"""The project file of a command governor: what good ones become, and what is said of others."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from servogen.errors import InputError
from servogen.plants.build import slow_plant
from servogen.project.governor_load import GovernorProject, load_governor_project
from servogen.project.settings import centred_axis_limits, motion_limits, stage_settings
from servogen.project.systems import load_any_project
from servogen.resources import resource_dir
from servogen.systems.judgement import timed_path

FOLDER = resource_dir("examples") / "command_governor"
EXAMPLE = FOLDER / "servogen.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")
SLOW = """\
[machine.x.slow]
model = "equal_poles"
pole_rad_per_s = 20
position_limit_m = [0, 0.25]
velocity_limit_m_per_s = 0.1
acceleration_limit_m_per_s2 = 10
"""
FAST = """\
[machine.x.fast]
range_m = 0.025
velocity_limit_m_per_s = 0.8
acceleration_limit_m_per_s2 = 200
"""
LEAST = f"""\
schema = 1
name = "least"
system = "command_governor"
sampling = {{fast_sample_time_s = 0.0000712, slow_sample_time_s = 0.0356}}
path = {{file = "a.svg"}}
{SLOW}{FAST}
"""
Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(text: str) -> Path:
        path = tmp_path / "servogen.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_the_example_is_the_machine_of_the_paper() -> None:
    project = load_any_project(EXAMPLE)
    assert isinstance(project, GovernorProject)
    assert project.sampling.ratio == 500
    limits, middle = centred_axis_limits(project.machine.x)
    assert (limits.position_m, middle, limits.fast_range_m) == (0.125, 0.125, 0.025)
    assert (limits.velocity_m_per_s, limits.acceleration_m_per_s2) == (0.1, 10.0)
    assert project.machine.y == project.machine.x
    governor = project.controller.governor
    assert (governor.horizon, governor.sub_samples) == (40, 3)
    np.testing.assert_allclose(slow_plant(stage_settings(project.machine.x.slow)).poles, -20, 1e-3)
    assert project.sources == (EXAMPLE, FOLDER / "figures.svg")


def test_a_file_of_required_keys_alone_has_the_example_s_controller(write: Write) -> None:
    least, example = load_governor_project(write(LEAST)), load_governor_project(EXAMPLE)
    window = example.controller.governor.model_copy(update={"points_ahead": "all"})
    assert least.controller == example.controller.model_copy(update={"governor": window})
    assert least.output == example.output
    assert least.target == example.target
    assert least.machine == example.machine


def test_the_drawing_is_what_its_script_draws(tmp_path: Path) -> None:
    for seed in ("0", "1"):
        drawn = tmp_path / f"{seed}.svg"
        script = [sys.executable, str(FOLDER / "make_drawing.py"), str(drawn)]
        subprocess.run(script, check=True, env={**os.environ, "PYTHONHASHSEED": seed})
        assert drawn.read_bytes() == (FOLDER / "figures.svg").read_bytes()


def test_the_drawing_has_the_paper_s_size() -> None:
    timed = timed_path(load_governor_project(EXAMPLE))
    assert 140_000 < len(timed.points) < 160_000
    assert timed.points.min() == pytest.approx(0.005, abs=1e-5)
    assert timed.points.max() == pytest.approx(0.245, abs=1e-5)


def test_y_may_be_of_its_own_and_its_faults_are_told_as_y_s(write: Write) -> None:
    slow = SLOW.replace("machine.x", "machine.y").replace("[0, 0.25]", "0.2")
    fast = FAST.replace("machine.x", "machine.y").replace("0.8", "0.5")
    project = load_governor_project(write(LEAST + slow + fast))
    assert project.machine.y.slow.position_limit_m == (-0.2, 0.2)
    assert centred_axis_limits(project.machine.y)[1] == 0.0
    assert motion_limits(project).velocity_m_per_s == 0.5
    with pytest.raises(InputError, match=r"machine\.y\.fast\.range_m is 0\.3, expected less than"):
        load_governor_project(write(LEAST + slow + fast.replace("0.025", "0.3")))


@pytest.mark.parametrize(
    ("model", "kind"),
    [
        ('model = "servo"\nbandwidth_rad_per_s = 45\ndamping = 0.7', "ServoSettings"),
        (
            'model = "transfer_function"\nnumerator = [1]\ndenominator = [1, 3, 3, 1]',
            "TransferFunctionSettings",
        ),
        (
            'model = "state_space"\na = [[0, 1, 0], [0, 0, 1], [-1, -3, -3]]\nb = [0, 0, 1]\n'
            "c = [1, 0, 0]",
            "StateSpaceSettings",
        ),
        ('model = "python"\nfile = "m.py"\nfunction = "f"', "PythonSettings"),
    ],
)
def test_other_models(write: Write, model: str, kind: str) -> None:
    poles = 'model = "equal_poles"\npole_rad_per_s = 20'
    project = load_governor_project(write(LEAST.replace(poles, model)))
    assert type(stage_settings(project.machine.x.slow)).__name__ == kind
    assert len(project.sources) == (4 if "python" in model else 2)


def test_the_margin_follows_the_precision_unless_it_is_given(write: Write) -> None:
    def margin(more: str) -> float:
        found = load_governor_project(write(LEAST + more))
        return found.controller.solver.constraint_margin

    single = '[output]\nprecision = "float32"\n'
    assert margin("") == 1e-6
    assert margin(single) == 1e-5
    assert margin(single + "[controller.solver]\nconstraint_margin = 1e-4\n") == 1e-4
    with pytest.raises(InputError, match=r"constraint_margin is 1e-06, expected at least 1e-05"):
        margin(single + "[controller.solver]\nconstraint_margin = 1e-6\n")


GOVERNOR = "[controller.governor]\n"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"command_governor"', '"two_stage"', 'system is "two_stage", expected "command_governor"'),
        ('"equal_poles"', '"equal"', 'model is "equal", expected "equal_poles", "servo"'),
        ("pole_rad_per_s", "pole_hz", "the key pole_rad_per_s, in rad/s"),
        ("pole_rad_per_s = 20", "pole_rad_per_s = 0", "a finite number above 0"),
        ("pole_rad_per_s = 20", "damping = 1", 'the keys of model = "equal_poles"'),
        ("[0.0, 0.25]", "[0.25, 0.0]", "position_limit_m is [0.25, 0.0], expected"),
        ("[0.0, 0.25]", "[0.0, 0.25, 1.0]", "or two, [low, high]"),
        ("[0.0, 0.25]", "[0.0, 0.05]", "range_m is 0.025, expected less than half of what slow."
         "position_limit_m = [0.0, 0.05] leaves the slow stage, 0.025 m"),
        ("range_m = 0.025", "range_mm = 25", "the key range_m, in m"),
        ("_s2 = 200.0", "_s2 = 5.0", "at least the slow stage's acceleration_limit_m_per_s2"),
        ("tangential_acceleration_m_per_s2 = 100.0", "tangential_acceleration_m_per_s2 = 300.0",
         "at most machine.x.fast.acceleration_limit_m_per_s2 = 200.0"),
        ("0.0356", "0.0357", "a whole multiple, from 2 to 10000 times"),
        ('"minimal_motion"', '"least"', 'expected "minimal_motion" or "pattern"'),
        ("stroke_reserve_m = 0.001", "stroke_reserve_m = 0.0", "stroke_reserve_m is 0.0, expected"),
        ("stroke_reserve_m = 0.001", "stroke_reserve_m = 0.025",
         "less than machine.x.fast.range_m = 0.025"),
        ("stroke_margin_m = 0.0", "stroke_margin_m = 0.0245",
         "stroke_reserve_m is 0.001, expected less than machine.x.fast.range_m = 0.025 less"),
        ("stroke_margin_m = 0.0", "stroke_margin_m = 0.03", "stroke_margin_m is 0.03, expected"),
        ("horizon = 40", "horizon = 61", "horizon is 61, expected a whole number"),
        ("horizon = 40", "horizon = 0", "horizon is 0, expected a whole number"),
        ("horizon = 40", "horizon = 40.5", "horizon is 40.5, expected a whole number"),
        ("points_ahead = 8000", "points_ahead = 1e300", "points_ahead is 1e+300, expected a whole"),
        ("sub_samples = 3", "sub_samples = 21", "sub_samples is 21"),
        ('"after"', '"before"', 'expected "after" or "at"'),
        ("sub_step_stroke = false", "sub_step_stroke = 0", "is 0, expected true or false"),
        ('"target"  ', "0  ", "iteration_cap is 0, expected a whole number from 3 to 100000 or"),
        ("points_ahead = 8000", "points_ahead = 500",
         "points_ahead is 500, expected more than the 500 points that a slow period can take"),
        ("points_ahead = 8000", "points_ahead = 0", "points_ahead is 0, expected a whole number"),
        ("points_ahead = 8000", 'points_ahead = "some"', 'from 1 to 200000 or "all"'),
        (GOVERNOR, GOVERNOR + "weight = 1\n", "weight is an unknown key (1)"),
        ("figures.svg", "figures.png", 'path.file is "figures.png", expected a file ending in'),
        ("[controller.motion]", "[controller.motions]", "motions is an unknown key"),
        ('[machine.y]\nsame_as = "x"', '[machine.y]\nsame_as = "z"', '"x", or the tables slow'),
    ],
)  # fmt: skip
def test_faults_are_one_clear_sentence(write: Write, old: str, new: str, told: str) -> None:
    assert old in TEXT
    with pytest.raises(InputError) as caught:
        load_governor_project(write(TEXT.replace(old, new, 1)))
    message = str(caught.value)
    assert told in message
    assert "\n" not in message


def test_more_instants_than_fast_samples_are_refused(write: Write) -> None:
    few = TEXT.replace("0.0000712", "0.0178").replace("sub_samples = 3", "sub_samples = 4")
    with pytest.raises(InputError, match=r"sub_samples is 4, expected at most the 2 fast samples"):
        load_governor_project(write(few))


def test_a_window_of_too_many_points_is_refused(write: Write) -> None:
    fast = TEXT.replace("0.0000712", "0.00000356")
    told = r"points_ahead is 8000, expected more than the 10000 points"
    with pytest.raises(InputError, match=told):
        load_governor_project(write(fast))
    told = (
        r"horizon is 40, expected .* 200000 points, or points_ahead; with M = 10000 it has 410001"
    )
    with pytest.raises(InputError, match=told):
        load_governor_project(write(fast.replace("points_ahead = 8000", 'points_ahead = "all"')))


def test_coefficients_and_matrices_are_looked_at(write: Write) -> None:
    poles = 'model = "equal_poles"\npole_rad_per_s = 20'
    zero = 'model = "transfer_function"\nnumerator = [1]\ndenominator = [0, 3, 3, 1]'
    with pytest.raises(InputError, match=r"machine\.x\.slow\.denominator\[0\] is 0\.0"):
        load_governor_project(write(LEAST.replace(poles, zero)))
    row = 'model = "state_space"\na = [[0, 1], [0, 0, 1]]\nb = [0, 0, 1]\nc = [1, 0, 0]'
    with pytest.raises(InputError, match=r"machine\.x\.slow\.a\[1\] .* 2 numbers"):
        load_governor_project(write(LEAST.replace(poles, row)))


@settings(
    derandomize=True, deadline=None, max_examples=80,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(
    at=st.integers(0, len(TEXT) - 1),
    put=st.text(alphabet='0-9.="[]{}\n _azé#', max_size=4),
    skip=st.integers(0, 12),
)
def test_a_spoilt_file_is_good_or_one_sentence(
    tmp_path: Path, at: int, put: str, skip: int
) -> None:
    path = tmp_path / "servogen.toml"
    path.write_text(TEXT[:at] + put + TEXT[at + skip :], encoding="utf-8")
    try:
        load_governor_project(path)
    except InputError as error:
        message = str(error)
        assert message.startswith(f"{path}: ")
        assert ", expected " in message
        assert "\n" not in message
        assert len(message) < 500
