"""From the project file to a Project: what good files become."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from servogen.errors import InputError
from servogen.project import load_project
from servogen.project.settings import axis_limits, motion_limits, path_settings, stage_settings
from servogen.resources import resource_dir

EXAMPLE = resource_dir("examples") / "two_stage" / "servogen.toml"
SERVO = """\
[machine.x.slow]
model = "servo"
bandwidth_rad_per_s = 45
damping = 0.7
position_limit_m = 0.4
velocity_limit_m_per_s = 0.7
acceleration_limit_m_per_s2 = 14.71
"""
LEAST = f"""\
schema = 1
name = "least"
system = "two_stage"
sampling = {{fast_sample_time_s = 0.0002, slow_sample_time_s = 0.03}}
path = {{file = "a.dxf"}}
{SERVO}
[machine.x.fast]
model = "servo"
bandwidth_rad_per_s = 2250
damping = 0.7
range_m = 0.035
velocity_limit_m_per_s = 0.6
acceleration_limit_m_per_s2 = 49.05
"""


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    def write(text: str) -> Path:
        path = tmp_path / "servogen.toml"
        path.write_text(text)
        return path

    return write


def test_the_example_is_the_papers_machine() -> None:
    project = load_project(EXAMPLE)
    slow, fast = project.machine.x.slow, project.machine.x.fast
    assert slow.model == fast.model == "servo"
    assert fast.bandwidth_rad_per_s == 50 * slow.bandwidth_rad_per_s
    assert project.sampling.ratio == 150
    assert project.machine.y == project.machine.x
    assert project.path.file == EXAMPLE.parent / "batch.dxf"


def test_a_file_of_required_keys_alone_has_the_example_s_controller(
    write: Callable[[str], Path],
) -> None:
    least, example = load_project(write(LEAST)), load_project(EXAMPLE)
    assert least.controller == example.controller
    assert least.output == example.output
    assert least.target == example.target
    assert least.machine.x.slow == example.machine.x.slow
    assert least.machine.x.fast.range_m == example.machine.x.fast.range_m


def test_y_may_be_of_its_own(write: Callable[[str], Path]) -> None:
    own = SERVO.replace("machine.x", "machine.y").replace("45", "60")
    fast = LEAST[LEAST.index("[machine.x.fast]") :].replace("machine.x", "machine.y")
    project = load_project(write(LEAST + own + fast.replace("0.6", "0.5")))
    assert project.machine.y.slow.bandwidth_rad_per_s == 60.0
    assert project.machine.x.slow.bandwidth_rad_per_s == 45.0
    assert motion_limits(project).velocity_m_per_s == 0.5


def test_a_fault_of_y_is_told_as_y_s(write: Callable[[str], Path]) -> None:
    fast = LEAST[LEAST.index("[machine.x.fast]") :].replace("machine.x", "machine.y")
    own = SERVO.replace("machine.x", "machine.y") + fast.replace("0.035", "0.5")
    with pytest.raises(InputError, match=r"machine\.y\.fast\.range_m is 0\.5"):
        load_project(write(LEAST + own))


@pytest.mark.parametrize(
    ("model", "kind"),
    [
        (
            'model = "transfer_function"\nnumerator = [1]\ndenominator = [1, 3, 3, 1]',
            "TransferFunctionSettings",
        ),
        (
            'model = "state_space"\na = [[0, 1, 0], [0, 0, 1], [-1, -3, -3]]\nb = [0, 0, 1]\n'
            "c = [1, 0, 0]",
            "StateSpaceSettings",
        ),
        (
            'model = "python"\nfile = "m.py"\nfunction = "f"\nparameters = {mass_kg = 2}',
            "PythonSettings",
        ),
    ],
)
def test_other_models(write: Callable[[str], Path], model: str, kind: str) -> None:
    servo = 'model = "servo"\nbandwidth_rad_per_s = 45\ndamping = 0.7'
    project = load_project(write(LEAST.replace(servo, model)))
    made = stage_settings(project.machine.x.slow)
    assert type(made).__name__ == kind
    assert axis_limits(project.machine.x).fast_range_m == 0.035
    match kind:
        case "TransferFunctionSettings":
            assert made.denominator == (1.0, 3.0, 3.0, 1.0)
        case "StateSpaceSettings":
            assert np.array(made.a).shape == (3, 3)
        case "PythonSettings":
            assert made.file == project.file.parent / "m.py"
            assert made.parameters == {"mass_kg": 2.0}


def test_the_margin_follows_the_precision_unless_it_is_given(write: Callable[[str], Path]) -> None:
    def margin(more: str) -> float:
        return load_project(write(LEAST + more)).controller.solver.constraint_margin

    single = '[output]\nprecision = "float32"\n'
    assert margin("") == 1e-6
    assert margin(single) == 1e-5
    assert margin(single + "[controller.solver]\nconstraint_margin = 3e-5\n") == 3e-5


@pytest.mark.parametrize("method", ["pqp", "active_set"])
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_a_solver_may_be_its_method_alone(
    write: Callable[[str], Path], method: str, precision: str
) -> None:
    rest = f'\n[output]\nprecision = "{precision}"\n'
    alone = load_project(write(LEAST + f'[controller]\nsolver = "{method}"' + rest))
    table = load_project(write(LEAST + f'[controller.solver]\nmethod = "{method}"' + rest))
    assert alone.controller == table.controller
    assert alone.controller.solver.method == method


def test_the_path_settings_are_the_table_s(write: Callable[[str], Path]) -> None:
    table = 'path = {file = "a.dxf", feed_scale = 1.5, layer_feeds_m_per_s = {CUT = 0.25}}'
    project = load_project(write(LEAST.replace('path = {file = "a.dxf"}', table)))
    made = path_settings(project)
    assert made.feed_scale == 1.5
    assert made.layer_feeds_m_per_s == {"CUT": 0.25}
    assert dataclasses.asdict(made).keys() == (project.path.model_dump().keys() - {"file"})


def test_a_project_cannot_be_changed() -> None:
    project = load_project(EXAMPLE)
    with pytest.raises(dataclasses.FrozenInstanceError):
        project.name = "other"  # type: ignore[misc]
    with pytest.raises(ValidationError, match="frozen"):
        project.controller.mpc.horizon = 3  # type: ignore[misc]


def test_a_byte_order_mark_and_other_newlines_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "servogen.toml"
    path.write_bytes(b"\xef\xbb\xbf" + LEAST.replace("\n", "\r\n").encode())
    assert load_project(path).name == "least"


LINES = EXAMPLE.read_text().splitlines()
SPOILS = (
    "",
    "nan",
    "-1",
    "0",
    '"a"',
    "[[]]",
    "{}",
    "[",
    "1e999",
    "true",
    "\\",
    "a.b",
    "1979-05-27",
)


@settings(derandomize=True, deadline=None, max_examples=300)
@given(
    number=st.integers(0, len(LINES) - 1),
    spoil=st.one_of(st.sampled_from(SPOILS), st.text(max_size=12)),
    key_too=st.booleans(),
)
def test_whatever_a_line_becomes_it_is_a_project_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, number: int, spoil: str, key_too: bool
) -> None:
    path = tmp_path_factory.getbasetemp() / "spoilt.toml"
    key = LINES[number].split("=")[0]
    line = spoil if key_too else f"{key}= {spoil}"
    text = "\n".join([*LINES[:number], line, *LINES[number + 1 :]])
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        load_project(path)
    except InputError as error:
        message = str(error)
        assert message.startswith(f"{path}: ")
        assert ", expected " in message
        assert "\n" not in message
        assert len(message) < 500
