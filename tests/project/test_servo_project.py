"""A servo drive's project file: what good ones become, and what is said of others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.errors import InputError
from servogen.project.load import Project
from servogen.project.servo_load import ServoProject, load_servo_project
from servogen.project.servo_schema import MatricesDrive, TwoMassDrive
from servogen.project.systems import load_any_project
from servogen.resources import resource_dir

EXAMPLE = resource_dir("examples") / "servo_drive" / "servogen.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")
MATRICES = """\
[drive]
model = "matrices"
a = [[1, 0.0005], [0, 0.9]]
b = [0, 0.001]
c = [1, 0]
"""
LEAST = f"""\
schema = 1
name = "least"
system = "servo_drive"
axis = {{encoder_resolution_deg = 0.001}}
sampling = {{sample_time_s = 0.0005, current_sample_time_s = 0.0005}}
reference = {{shape = "sine", amplitude_deg = 2, frequency_hz = 10}}
{MATRICES}
"""
Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(text: str) -> Path:
        path = tmp_path / "servogen.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_the_example_is_the_headstock_axis() -> None:
    project = load_servo_project(EXAMPLE)
    assert isinstance(project.drive, TwoMassDrive)
    drive, inertia = project.drive, project.drive.motor_inertia_kg_m2
    assert drive.stiffness_n_m_per_rad / inertia == pytest.approx(5.95e6)
    assert inertia / drive.load_inertia_kg_m2 == pytest.approx(0.285)
    assert project.ratio == 8
    assert project.controller.pid is not None
    assert project.controller.pid.notch is not None


def test_a_file_of_required_keys_alone_has_the_example_s_controller(write: Write) -> None:
    least, example = load_servo_project(write(LEAST)), load_servo_project(EXAMPLE)
    assert isinstance(least.drive, MatricesDrive)
    assert least.controller.mpc == example.controller.mpc
    assert least.controller.estimator == example.controller.estimator
    assert least.output == example.output
    assert (least.target.name, least.target.share) == (example.target.name, example.target.share)
    assert least.target.tracking_error_limit_deg is None
    assert least.controller.pid is None


def test_weights_are_a_number_or_one_for_every_step(write: Write) -> None:
    text = LEAST + "[controller.mpc]\nweight_change = [1, 2.5, 3]\nweight_error = 7\n"
    mpc = load_servo_project(write(text)).controller.mpc
    assert mpc.weight_change == (1.0, 2.5, 3.0)
    assert mpc.weight_error == (7.0,)


MPC = "[controller.mpc]\n"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"servo_drive"', '"two_stage"', 'system is "two_stage", expected "servo_drive"'),
        ('"two_mass"', '"three"', 'drive.model is "three", expected "two_mass" or "matrices"'),
        ("= 0.01\n", "= 0\n", "drive.motor_inertia_kg_m2 is 0"),
        ("motor_inertia_kg_m2", "motor_inertia_g_cm2", "the key motor_inertia_kg_m2, in kg m^2"),
        ("current_limit_ma = 1000.0", "current_limit_a = 1.0", "the key current_limit_ma, in mA"),
        ("stroke_deg = 270.0", "stroke_rad = 1.0", "the key stroke_deg, in deg"),
        ("turn_deg = 360 ", "turn_deg = 360.5 ", "a whole number at least 0 and at most 4096"),
        ("= 0.0000625", "= 0.00007", "sampling.sample_time_s is 0.0005, expected a whole multiple"),
        ("trajectory_horizon = 3", "trajectory_horizon = 1", 'at least 2 with reference_extension'),
        ("control_horizon = 3", "control_horizon = 20\nprediction_horizon = 9",
         "valid TOML"),
        ("prediction_horizon = 50", "prediction_horizon = 2", "at most prediction_horizon = 2"),
        ("weight_error = 1e6", "weight_error = [1, 2]", "one number or 50"),
        ("weight_error = 1e6", "weight_error = -1", "weight_error is -1.0, expected a number"),
        ("weight_error = 1e6", "weight_error = 0", "expected one above 0"),
        ("weight_error = 1e6", "weight_error = nan", "weight_error is nan, expected a finite"),
        ("weight_change = 1.0", "weight_change = [1, 0, 1]", "weight_change[1] is 0.0"),
        ("weight_change = 1.0", 'weight_change = "a"', "number or a list of H_u numbers"),
        (MPC, MPC + "position_bound_deg = 90\n", "none on an axis that comes round"),
        (MPC, MPC + "horizon = 3\n", "controller.mpc.horizon is an unknown key (3)"),
        ("[1.0, -1.8492, 0.8651]", "[0.0, 1.0, 2.0]", "a leading coefficient that is not zero"),
        ("[1.0, -1.8492, 0.8651]", "[1.0]", "a list of three numbers"),
        ("position_range_deg = 36000.0", "position_range_deg = 100.0", "at least one turn"),
        ("position_range_deg = 36000.0", "position_range_deg = 1e6", "so many turns of 360"),
        ("speed_deg_per_s = 360.0", "speed_deg_per_s = 4e5", "less than half of axis.turn_deg"),
        ('shape = "trapezoid"', 'shape = "sinus"', 'reference.shape is "sinus", expected "sine"'),
        ("[reference]", "[[reference]]", "an array of tables"),
        ("[axis]", "[axes]", "axes is an unknown key"),
        ("schema = 1", "schema = true", "schema is true, expected 1"),
        ("current_limit_ma = 1000.0", "current_limit_ma = [100, 200]",
         "current_limit_ma is [100, 200], expected a finite number from 1e-09 to 1e+06, or two"),
        ("current_limit_ma = 1000.0", "current_limit_ma = [0, -1]", "is [0, -1], expected"),
        (MPC, MPC + "current_step_limit_ma = [0, 5]\n", "with 0 between them (mA)"),
        (MPC, MPC + "position_bound_deg = [5, 5]\n", "is [5, 5], expected a finite number from"),
        ("speed_deg_per_s = 360.0", "speed_deg_per_s = 0.008",
         "reference.speed_deg_per_s is 0.008, expected a reference of at most 5000000 samples of "
         "sampling.current_sample_time_s = 6.25e-05, 312.5 s, not 33750 s"),
        ("acceleration_deg_per_s2 = 1000.0", "acceleration_deg_per_s2 = 1e-9",
         "reference.acceleration_deg_per_s2 is 1e-09, expected a reference of at most"),
        ('"two_mass"', '"matrices"', 'drive.motor_inertia_kg_m2 is a key of model = "two_mass" '
         '(0.01), expected the keys of model = "matrices": model, a, b, c'),
        ("[0.9352, -1.84926448, 0.9352]", "[0, 0, 0]", "notch.numerator is [0.0, 0.0, 0.0]"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_sentence(write: Write, old: str, new: str, told: str) -> None:
    assert old in TEXT
    path = write(TEXT.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_servo_project(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert told in message
    assert ", expected " in message


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[0, 0.9]]", "[0.9]]", "drive.a[1] is [0.9], expected 2 numbers"),
        ("c = [1, 0]", "c = [1]", "drive.c is [1.0], expected 2 numbers"),
        ("current_sample_time_s = 0.0005", "current_sample_time_s = 0.00025", "say nothing of"),
        ("0.001}", "0.001, turn_deg = 0, position_range_deg = 1}", "reference.amplitude_deg is 2"),
    ],
)
def test_a_mistake_about_matrices_too(write: Write, old: str, new: str, told: str) -> None:
    assert old in LEAST
    with pytest.raises(InputError) as caught:
        load_servo_project(write(LEAST.replace(old, new)))
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "more"),
    [
        ("weight_error = 1e6", 'weight_error = ["a", "b", "c"]', ""),
        ('"two_mass"', '"matrices"', ""),
        ("weight_error = 1e6\nweight_change = 1.0", "weight_error = nan\nweight_change = inf",
         " (and 1 more wrong key)"),
        ("[1.0, -1.8492, 0.8651]", '["a", "b"]', ""),
    ],
)  # fmt: skip
def test_a_list_or_a_table_that_is_wrong_counts_once(
    write: Write, old: str, new: str, more: str
) -> None:
    assert old in TEXT
    with pytest.raises(InputError) as caught:
        load_servo_project(write(TEXT.replace(old, new, 1)))
    told = str(caught.value)
    assert told.partition(" (and ")[1:] == more.partition(" (and ")[1:], told


def test_limits_are_a_number_or_two(write: Write) -> None:
    text = TEXT.replace("turn_deg = 360 ", "turn_deg = 0 ").replace(
        "current_limit_ma = 1000.0",
        "current_limit_ma = [-800, 1200]\ncurrent_step_limit_ma = 50\n"
        "position_bound_deg = [2, 300]",
    )
    text = text.replace("stroke_deg", "start_deg = 3\nstroke_deg")
    mpc = load_servo_project(write(text)).controller.mpc
    assert mpc.current_limit_ma == (-800.0, 1200.0)
    assert mpc.current_step_limit_ma == (-50.0, 50.0)
    assert mpc.position_bound_deg == (2.0, 300.0)
    with pytest.raises(InputError, match=r"reference.start_deg is 1.0, expected a place within"):
        load_servo_project(write(text.replace("start_deg = 3", "start_deg = 1")))
    with pytest.raises(InputError, match=r"start_deg is -36001.0, expected within axis.position_r"):
        load_servo_project(write(text.replace("start_deg = 3", "start_deg = -36001")))


def test_a_sine_that_is_too_long_says_why(write: Write) -> None:
    slow = LEAST.replace("frequency_hz = 10", "frequency_hz = 1e-6")
    many = LEAST.replace("frequency_hz = 10", "frequency_hz = 1.0, cycles = 1000")
    assert load_servo_project(write(many)).reference.lasts_s == 1000.0
    often = many.replace("0.0005", "1e-5")
    for text, key in ((slow, "frequency_hz is 1e-06"), (often, "cycles is 1000")):
        with pytest.raises(InputError, match=rf"reference.{key}, expected a reference of at most"):
            load_servo_project(write(text))


def test_a_model_of_the_controller_s_own_must_fit_itself(write: Write) -> None:
    model = "[controller.mpc.model]\na = [[1]]\nb = [1, 2]\nc = [1]\n"
    with pytest.raises(InputError, match=r"controller.mpc.model.b is \[1.0, 2.0\]"):
        load_servo_project(write(LEAST + model))


LINES = TEXT.splitlines()
SPOILS = ("", "nan", "-1", "0", '"a"', "[[]]", "{}", "[", "1e999", "true", "\\", "a.b")


@settings(derandomize=True, deadline=None, max_examples=150)
@given(
    number=st.integers(0, len(LINES) - 1),
    spoil=st.one_of(st.sampled_from(SPOILS), st.text(max_size=12)),
    key_too=st.booleans(),
)
def test_whatever_a_line_becomes_it_is_a_project_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, number: int, spoil: str, key_too: bool
) -> None:
    path = tmp_path_factory.getbasetemp() / "spoilt_servo.toml"
    line = spoil if key_too else f"{LINES[number].split('=')[0]}= {spoil}"
    text = "\n".join([*LINES[:number], line, *LINES[number + 1 :]])
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        load_servo_project(path)
    except InputError as error:
        message = str(error)
        assert message.startswith(f"{path}: ")
        assert ", expected " in message
        assert "\n" not in message
        assert len(message) < 500


def test_any_system_s_file_is_read_as_what_it_says(write: Write) -> None:
    other = resource_dir("examples") / "two_stage" / "servogen.toml"
    assert isinstance(load_any_project(EXAMPLE), ServoProject)
    assert isinstance(load_any_project(other), Project)
    for system in ('"gantry"', "3", "{a = 1}"):
        with pytest.raises(
            InputError, match=r'system is .*, expected "two_stage", "servo_drive", '
        ):
            load_any_project(write(TEXT.replace('"servo_drive"', system)))
    with pytest.raises(InputError, match=r"schema is missing"):
        load_any_project(write(""))
    with pytest.raises(InputError, match=r"a few levels deep"):
        load_any_project(write("a = " + "[" * 5000 + "]" * 5000))
