"""The project file of a contour controller: what good ones become, and what is said of others."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from contour_example import CIRCLE, CURVE, DRAWN, EXAMPLE, SPACE, TABLE, contour_project

from servogen.errors import InputError
from servogen.plants.machining_centre import machining_centre
from servogen.project.contour_load import ContourProject
from servogen.project.systems import load_any_project
from servogen.systems.contour_machine import contour_design, contour_machine

DRIVE = '[machine.y.drive]\nmodel = "machining_centre"\naxis = "y"\n'
SERVO = '[machine.y.drive]\nmodel = "velocity_servo"\nbandwidth_rad_per_s = 400\ndamping = 0.6\n'
SERVO += "velocity_per_command_m_per_s = 0.022\n"
BETA = "contour_weight = 15.0 "


def test_the_example_is_the_machine_of_the_paper() -> None:
    project = load_any_project(EXAMPLE)
    assert isinstance(project, ContourProject)
    assert project.sources == (EXAMPLE,)
    machine = contour_machine(project)
    for own, paper in zip(machine.axes, machining_centre(), strict=True):
        np.testing.assert_array_equal(own.a, paper.a)
    # the facts': m/s per unit of the command, the integrators drifting by 4e-5 a sample
    assert machine.gains == pytest.approx((0.022607, 0.022338), rel=5e-3)


def test_a_part_program_is_a_source_and_a_contour(tmp_path: Path) -> None:
    project = contour_project(tmp_path, (CIRCLE, DRAWN))
    assert project.sources == (tmp_path / "servogen.toml", tmp_path / "corner.ngc")
    task = contour_machine(project).task
    assert task.motion.points[0] == pytest.approx((0.0, 0.0))
    assert task.motion.points[-1] == pytest.approx((0.5e-3, 1e-3), abs=1e-9)


def test_a_part_program_may_move_z(tmp_path: Path) -> None:
    """No faster than z can: the slope is steep and the feed of 40 mm/s is above its 18."""
    slow = "command_limit = 0.9\nposition_limit_m = 0.05\nencoder_m = 1e-7\ncommand_noise = 0.01\n"
    z = f"[machine.z]\n{slow}{SERVO.replace('machine.y', 'machine.z')}\n"
    project = contour_project(tmp_path, (CIRCLE, DRAWN), ("[sampling]", f"{z}[sampling]"))
    (tmp_path / "corner.ngc").write_text("G0 Z1\nG1 X1 Z-9 F2400\nG2 I1 Z-8\n", encoding="utf-8")
    machine = contour_machine(project)
    points = machine.task.motion.points
    assert points[0] == pytest.approx([0.0, 0.0, 1e-3])
    assert points[-1] == pytest.approx([1e-3, 0.0, -8e-3])
    fastest = np.max(np.abs(np.diff(points[:, 2]))) / 0.0005
    assert fastest == pytest.approx(0.9 * 0.9 * 0.022, rel=1e-3)
    flat = contour_project(tmp_path, (CIRCLE, DRAWN))
    (tmp_path / "corner.ngc").write_text("G1 X1\nG1 Z-1\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"corner.ngc: line 2 is a move of z to -0.001 m"):
        contour_machine(flat)


def test_models_of_an_axis_agree(tmp_path: Path) -> None:
    """A velocity servo, its transfer function, and the matrices of either."""
    servo = contour_machine(contour_project(tmp_path, (DRIVE, SERVO)))
    w, zeta, gain = 400.0, 0.6, 0.022
    text = f'[machine.y.drive]\nmodel = "transfer_function"\nnumerator = [{gain * w**2}]\n'
    text += f"denominator = [1, {2 * zeta * w}, {w**2}]\n"
    other = contour_machine(contour_project(tmp_path, (DRIVE, text)))
    axis = servo.axes[1]
    np.testing.assert_allclose(other.axes[1].a, axis.a, rtol=1e-12, atol=1e-15)
    assert servo.gains[1] == pytest.approx(gain, rel=1e-9)
    poles = np.roots([1.0, 2.0 * zeta * w, w**2])
    expected = np.sort_complex(np.exp(0.0005 * np.append(poles, 0.0)))
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(axis.a)), expected, rtol=1e-9)
    text = f'[machine.y.drive]\nmodel = "matrices"\na = {axis.a.tolist()}\n'
    text += f"b = {axis.b.tolist()}\nc = {axis.c.tolist()}\n"
    again = contour_machine(contour_project(tmp_path, (DRIVE, text)))
    np.testing.assert_array_equal(again.axes[1].a, axis.a)


def matrices(a: str, b: str = "[1, 0]") -> str:
    return f'[machine.y.drive]\nmodel = "matrices"\na = {a}\nb = {b}\nc = [1, 0]\n'


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (CIRCLE, "", "contour is missing, expected a table: a curve, or a drawing in"),
        (CIRCLE, CIRCLE + DRAWN, "path is a table, expected none beside [contour]"),
        (CURVE, 'kind = "square"\n', 'contour.kind is "square", expected "circle" or "butterfly"'),
        ("radius_m = 0.001", "radius_m = 0.06", "at most machine.x.position_limit_m = 0.05"),
        ("radius_m = 0.001", "size_m = 0.001", "size_m"),
        ("= 0.05                     # 3", "= 2.0 #", "contour.feed_m_per_s is 2.0, expected at"),
        ("= 0.05                     # 3", "= 1e-6 #", "a feed that ends within 1,000,000 samples"),
        ("repetitions = 4", "repetitions = 4\nrise_m = 0.001", "0 without a third axis"),
        ("sample_time_s = 0.0005", "sample_time_s = 0.001", "expected 0.0005, at which machine.x"),
        ("command_limit = 20.0 ", "command_limit = -1 ", "machine.x.command_limit is -1, expected"),
        ("command_limit = 20.0 ", "command_limit = 2.3 ", "machine.x.command_limit = 2.3 gives"),
        ("encoder_m = 0.8e-6", "encoder_m = 0.8e-6\nspeed = 3", "speed is an unknown key"),
        ("encoder_m = 0.8e-6", "encoder_um = 0.8", "the key encoder_m, in m"),
        ("encoder_m = 0.8e-6", "encoder_m = 0", "machine.x.encoder_m is 0, expected a"),
        ("tracking_weight = 0.25", "tracking_weight = 0", "expected a finite number above 0"),
        (BETA, "contour_weight = -1 ", "contour_weight is -1, expected a finite number at least 0"),
        ("preview = 10 ", "preview = 0 ", "controller.contour.preview is 0, expected a whole"),
        ("preview = 10 ", "preview = 1 ", 'is 1, expected at least 2 with terminal = "stationary"'),
        (DRIVE, matrices("[[1, 0.1]]"), "machine.y.drive.a[0] is [1.0, 0.1], expected 1 numbers"),
        (DRIVE, matrices("[[1, 1], [0, 1.2]]", "[0, 1]"), "every mode but its position's decays"),
        (DRIVE, matrices("[[1, 1], [0, 0.5]]", "[0, 0]"), "drive.b is [0.0, 0.0]"),
        (DRIVE, SERVO.replace("400", "0"), "bandwidth_rad_per_s is 0, expected a finite number"),
        (DRIVE, SERVO.replace("velocity_servo", "servo"), "machine.y.drive.model is"),
        ('name = "tms320c6678"', 'name = "tms320c6678"\nshare = 0.1', "servogen.toml"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_sentence(tmp_path: Path, old: str, new: str, told: str) -> None:
    with pytest.raises(InputError) as caught:
        contour_design(contour_machine(contour_project(tmp_path, (old, new))))
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ((TABLE, (BETA, "contour_weight = 0 ")), "whose gains have no angle"),
        (
            (("preview = 10 ", "entries = 32\npreview = 10 "),),
            "entries is 32, expected none with form",
        ),
        ((TABLE, SPACE), '"on_line" with three axes'),
        ((TABLE, ("preview = 10 ", "preview = 3 ")), "direction_at is 4, expected at most preview"),
        (
            ((CIRCLE, DRAWN.replace("corner.ngc", "corner.txt")),),
            'path.file is "corner.txt", expected a file ending in',
        ),
        (
            ((CIRCLE, f"{DRAWN}tangential_acceleration_m_per_s2 = 9\n"),),
            "at most acceleration_limit_m_per_s2 = 3.0",
        ),
        (
            ((CIRCLE, DRAWN), ("position_limit_m = 0.05", "position_limit_m = 0.0005")),
            "corner.ngc: line 3 is at x = 0.001 m, expected |x| of at most machine.x",
        ),
        ((SPACE, (CIRCLE, f"{CIRCLE}rise_m = 0.03\n")), "at most machine.z.position_limit_m"),
        (
            (("[sampling]", '[machine.z]\nsame_as = "y"\n[sampling]'),),
            'machine.z.same_as is "y", expected "x", or keys and a table drive of its own',
        ),
    ],
)
def test_a_contradiction_is_one_sentence(
    tmp_path: Path, changes: tuple[tuple[str, str], ...], told: str
) -> None:
    with pytest.raises(InputError) as caught:
        contour_machine(contour_project(tmp_path, *changes))
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("a", "b", "c", "told"),
    [
        ("[[0.5, 0.1], [0, 0.4]]", "[0, 1]", "[1, 0]", "drive.a is without an integrator, its"),
        ("[[1.3, 0.1], [0, 0.3]]", "[0, 1]", "[1, 0]", "eigenvalue nearest to 1 is 1.3"),
        ("[[1, 0.1], [0, 1.3]]", "[0, 1]", "[1, 0]", "drive.a is with a mode of eigenvalue 1.3 be"),
        ("[[1, 0.1], [0, 0.9999999]]", "[0, 1]", "[1, 0]", "with a mode of eigenvalue 0.9999999"),
        (
            "[[1, 0], [0, 0.4]]",
            "[1, 1]",
            "[0, 1]",
            "drive.c is [0.0, 1.0], expected an output that shows",
        ),
        (
            "[[1, 0], [0, 0.4]]",
            "[0, 1]",
            "[1, 1]",
            "drive.b is [0.0, 1.0], expected an input that moves",
        ),
    ],
)
def test_an_axis_is_one_integrator_that_is_driven_and_seen(
    tmp_path: Path, a: str, b: str, c: str, told: str
) -> None:
    text = f'[machine.y.drive]\nmodel = "matrices"\na = {a}\nb = {b}\nc = {c}\n'
    with pytest.raises(InputError) as caught:
        contour_machine(contour_project(tmp_path, (DRIVE, text)))
    assert "servogen.toml: machine.y.drive." in str(caught.value)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("= 400", "= 1e6", "bandwidth_rad_per_s is 1000000.0, expected at most 6283.19 rad/s, pi"),
        ("= 400", "= 0.01", "bandwidth_rad_per_s is 0.01, expected a velocity loop that settles"),
        ("= 0.6", "= 1e-6", "damping is 1e-06, expected a velocity loop that settles: its slowest"),
        ("= 0.022", "= 1e-9", "y.command_limit is 20.0, with which the axis goes 2e-08 m/s"),
        ("= 0.022", "= 1e5", "with which the axis goes 2e+06 m/s, expected a velocity from 1e-06"),
    ],
)  # fmt: skip
def test_a_velocity_servo_is_one(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert old in SERVO
    with pytest.raises(InputError) as caught:
        contour_machine(contour_project(tmp_path, (DRIVE, SERVO.replace(old, new))))
    assert told in str(caught.value)
