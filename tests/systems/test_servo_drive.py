"""The headstock axis in closed loop: the table of errors, the paper's charts in kind, faults."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from servogen.controllers.design import Status
from servogen.errors import InputError
from servogen.precision import FLOAT32
from servogen.progress import Silent
from servogen.project.servo_load import load_servo_project
from servogen.project.servo_reference import TrapezoidReference
from servogen.resources import resource_dir
from servogen.systems.servo_drive import (
    ServoDrive,
    mpc_design,
    pid_design,
    servo_drive,
    tracking_problem,
)
from servogen.systems.servo_figures import (
    disturbance_run,
    law_numbers,
    profile_run,
    waterfall,
)
from servogen.systems.servo_loop import run_drive
from servogen.systems.servo_motion import reference_motion, sine, trapezoid
from servogen.systems.servo_study import (
    AS_PRINTED,
    FAST,
    SLOW,
    current_needed,
    ideal_track,
    largest_error,
    mpc_loop,
    pid_loop,
    pid_track,
    printed_comparison,
    tracking_table,
)

EXAMPLE = resource_dir("examples") / "servo_drive" / "servogen.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")
PRINTED = """
a = [[0.36, 0.64, -2100, 2100], [0.18, 0.82, 590, -590],
     [3.8e-4, 1.2e-4, 0.37, 0.63], [3.3e-5, 4.7e-4, 0.18, 0.82]]
b = [8.6e-5, 7.5e-6, 2.5e-8, 9.9e-10]
c = [0, 0, 57, 0]
"""
Write = Callable[[str], Path]


@pytest.fixture(scope="module")
def servo() -> ServoDrive:
    return servo_drive(load_servo_project(EXAMPLE))


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(text: str) -> Path:
        path = tmp_path / "servogen.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


# Computed apart from this package, from the same data and conditions.
TABLE = {
    SLOW: (
        (1, 0.926, 0.829, 0.731, 0.643, 0.566, 0.501, 0.445),
        (0.0556, 0.0467, 0.0381, 0.0307, 0.0246, 0.0198, 0.0159),
        2.40,
    ),
    FAST: (
        (1, 0.962, 0.900, 0.820, 0.733, 0.648, 0.572, 0.505),
        (0.497, 0.443, 0.380, 0.317, 0.260, 0.211, 0.172),
        0.825,
    ),
}


@pytest.mark.parametrize("case", [SLOW, FAST], ids=["1 Hz", "10 Hz"])
def test_the_table_of_errors(servo: ServoDrive, case) -> None:
    zero_order, first_order, pid = TABLE[case]
    found = tracking_table(servo, case, Silent())
    np.testing.assert_allclose(found.zero_order, zero_order, rtol=0.02)
    np.testing.assert_allclose(found.first_order[1:], first_order, rtol=0.02)
    assert np.isnan(found.first_order[0])
    assert found.pid == pytest.approx(pid, rel=0.02)
    # what the paper says of its Figures 7 and 8
    assert np.all(np.diff(found.zero_order) < 0.0)
    assert np.all(np.diff(found.first_order[1:]) < 0.0)
    assert np.all(found.first_order[1:] < found.zero_order[1:])
    assert np.all(found.first_order[1:] < found.pid)


def test_a_further_cycle_changes_nothing(servo: ServoDrive) -> None:
    for case in (SLOW, FAST):
        more = dataclasses.replace(case, cycles=case.cycles + 1)
        last = case.last(servo.drive.sample_time_s)
        for horizon, extension in ((1, "zero_order"), (8, "first_order")):
            sums = [
                np.sum(np.abs(ideal_track(servo, c, horizon, extension).error[-last:]))
                for c in (case, more)
            ]
            assert sums[0] == pytest.approx(sums[1], rel=1e-3)


def test_the_largest_errors(servo: ServoDrive) -> None:
    fast, slow = largest_error(servo, FAST), largest_error(servo, SLOW)
    assert fast.mpc == pytest.approx((0.641, 0.390), rel=0.02)
    assert slow.mpc[0] == pytest.approx(0.0676, rel=0.02)
    assert slow.pid is not None
    assert slow.pid[0] == pytest.approx(0.557, rel=0.02)
    assert fast.reachable


def test_why_the_printed_errors_are_not_found(servo: ServoDrive) -> None:
    """The current that a rigid axis needs for the sine, from inertia and friction alone."""
    drive = servo.project.drive
    inertia = drive.motor_inertia_kg_m2 + drive.load_inertia_kg_m2
    friction = drive.motor_friction_n_m_s_per_rad + drive.load_friction_n_m_s_per_rad
    w = 2.0 * np.pi * 10.0
    torque = np.deg2rad(2.0) * abs(-inertia * w**2 + 1j * friction * w)
    rigid = 1000.0 * torque / drive.torque_constant_n_m_per_a
    assert current_needed(servo.drive, 10.0, 2.0) == pytest.approx(rigid, rel=0.01)
    rows, reason = printed_comparison(servo)
    assert [row.case for row in rows] == [AS_PRINTED, FAST, SLOW]
    assert not rows[0].reachable
    assert rows[0].mpc[0] > 1.0
    assert f"{rows[0].needed_ma:.0f} mA" in reason


def test_plans_come_nearer_to_what_is_given_with_the_first_order_hold(servo: ServoDrive) -> None:
    zero, first = waterfall(servo, "zero_order"), waterfall(servo, "first_order")
    assert first.gap < 0.75 * zero.gap
    assert first.plan.shape == (200, 4)
    np.testing.assert_array_equal(first.plan[:, 0], first.current)


def test_a_turn_a_second_stays_linear_and_leaves_the_pid_far_behind(servo: ServoDrive) -> None:
    """Figures 14, 15: through the encoder, modulo 360 degrees, within 1 A."""
    mpc, pid = profile_run(servo, mpc_loop(servo)), profile_run(servo, pid_loop(servo))
    assert not np.any(mpc.status)
    assert not np.any(pid.status)
    assert np.max(np.abs(mpc.current)) < 600.0
    assert np.max(np.abs(mpc.error)) < 0.2
    assert np.max(np.abs(pid.error)) > 50.0 * np.max(np.abs(mpc.error))
    assert np.max(np.abs(mpc.error[-20:])) < 0.005


def test_the_axis_returns_when_it_is_let_go(servo: ServoDrive) -> None:
    """Figure 16: pulled with more than the limit holds; overshoot, then rest where it was."""
    found = disturbance_run(servo)
    run, pulled = found.run, round(0.25 / servo.drive.sample_time_s)
    assert np.max(np.abs(run.output[:pulled])) < 1e-3
    assert np.min(run.output) < -5.0
    assert np.max(run.output) > 0.5
    assert abs(run.output[-1]) < 0.005
    assert np.max(np.abs(run.current)) == 1000.0
    assert np.all(found.law[:pulled] == 1)
    assert 3 <= np.unique(found.law).size <= 11
    bound = np.abs(run.current[:: servo.ratio]) >= 1000.0 * (1.0 - 1e-9)
    np.testing.assert_array_equal(bound, found.pattern[:, 0] != 0)


def test_eleven_laws_of_27_patterns() -> None:
    patterns = np.array(np.meshgrid(*[[-1, 0, 1]] * 3)).reshape(3, -1).T
    numbers = law_numbers(patterns)
    assert np.unique(numbers).size == 11
    assert numbers[np.flatnonzero(~patterns.any(axis=1))[0]] == 1


def test_where_the_axis_stands_makes_no_difference(servo: ServoDrive) -> None:
    """The same motion from 359.5 degrees on; the encoder's steps fall alike, 360 being 2^20."""
    wave = sine(2.0, 5.0)
    start = 359.5  # whole steps of the encoder but for a rounding
    here = run_drive(servo, mpc_loop(servo), wave, 300)
    there = run_drive(servo, mpc_loop(servo), lambda t: wave(t) + start, 300)
    assert np.max(there.output) > 360.0
    assert np.min(there.output) < 359.0
    np.testing.assert_allclose(there.output - start, here.output, atol=2e-3)
    assert not np.any(there.status)


class Listener:
    """A loop that gives no current and keeps what it is told."""

    taken = 2

    def __init__(self) -> None:
        self.told: list[np.ndarray] = []

    def reset(self, position: float) -> Status:
        self.told.append(np.array([position]))
        return Status.OK

    def sample(self, position: float, ahead: np.ndarray) -> Status:
        self.told.append(np.append(position, ahead))
        return Status.OK

    def current(self) -> float:
        return 0.0


def test_what_a_controller_is_told_is_modulo_a_turn_and_in_steps(servo: ServoDrive) -> None:
    loop = Listener()
    run = run_drive(servo, loop, lambda t: 359.9995 + 360.0 * t, 50, lambda _: 100.0)
    assert run.output[-1] > 360.0
    told = np.concatenate(loop.told)
    assert np.all((told >= 0.0) & (told < 360.0))
    seen = np.array([values[0] for values in loop.told]) / servo.project.axis.encoder_resolution_deg
    assert np.all(seen == np.round(seen))
    assert len({values.size for values in loop.told[1:]}) == 1
    assert loop.told[1].size == 1 + 1 + loop.taken


def test_designed_on_the_printed_matrices_it_tracks_the_model(write: Write) -> None:
    table = f"[controller.mpc.model]{PRINTED}\n[controller.estimator]"
    text = TEXT.replace("[controller.estimator]", table)
    own = servo_drive(load_servo_project(write(text)))
    assert own.plant.a[0, 0] == 0.36
    assert own.drive.a[0, 0] != 0.36
    run = profile_run(own, mpc_loop(own))
    assert np.max(np.abs(run.error)) < 0.3
    assert np.max(np.abs(run.error[-20:])) < 0.01


def test_a_drive_of_matrices_alone(write: Write) -> None:
    head, tail = TEXT.split("[drive]")[0], TEXT[TEXT.index("[axis]") :]
    text = head + f'[drive]\nmodel = "matrices"{PRINTED}\n' + tail
    own = servo_drive(load_servo_project(write(text.replace("0.0000625", "0.0005"))))
    run = profile_run(own, mpc_loop(own))
    assert np.max(np.abs(run.error)) < 0.2
    with pytest.raises(InputError, match=r"drive.model"):
        disturbance_run(own)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("denominator = [1.0, -1.8492, 0.8651]", "denominator = [1.0, -2.1, 1.05]", "pid.notch"),
        (
            "[controller.estimator]",
            "[controller.mpc.model]\na = [[1.2, 0], [0, 0.5]]\nb = [1, 1]\nc = [0, 1]\n"
            "[controller.estimator]",
            "controller.mpc.model.c is blind to the mode at z = 1.2",
        ),
    ],
)
def test_what_the_plant_does_not_allow_is_one_sentence(write: Write, old, new, told) -> None:
    own = servo_drive(load_servo_project(write(TEXT.replace(old, new))))
    design = pid_design if told == "pid.notch" else mpc_design
    with pytest.raises(InputError) as caught:
        design(own)
    assert told in str(caught.value)
    assert ", expected " in str(caught.value)


def test_a_project_without_pid_has_none(write: Write) -> None:
    head, tail = TEXT.split("[controller.pid]")[0], TEXT[TEXT.index("[reference]") :]
    own = servo_drive(load_servo_project(write(head + tail)))
    assert pid_design(own) is None
    assert pid_track(own, FAST) is None
    assert largest_error(own, FAST).pid is None
    with pytest.raises(InputError, match=r"controller.pid is missing, expected a table"):
        pid_loop(own)


def test_horizons_of_the_table_need_one_weight(write: Write) -> None:
    text = TEXT.replace("weight_change = 1.0", "weight_change = [1, 2, 3]")
    own = servo_drive(load_servo_project(write(text)))
    assert tracking_problem(own).qp.hessian[2, 2] != tracking_problem(own).qp.hessian[1, 1]
    with pytest.raises(InputError, match="weight_change"):
        tracking_table(own, FAST, Silent())


def test_the_example_s_design_is_in_its_precision(servo: ServoDrive) -> None:
    design = mpc_design(servo)
    assert design.precision is FLOAT32
    assert design.problem.qp.is_box
    assert design.problem.layout.size == 4 + 1 + 3


@pytest.mark.parametrize(("stroke", "peak"), [(270.0, 360.0), (50.0, np.sqrt(50_000.0))])
def test_the_trapezoid_is_one(stroke: float, peak: float) -> None:
    wanted = TrapezoidReference(
        shape="trapezoid", stroke_deg=stroke, speed_deg_per_s=360.0, acceleration_deg_per_s2=1000.0
    )
    motion, lasts = trapezoid(wanted), wanted.lasts_s
    time = np.linspace(0.0, lasts, 20_001)
    position = motion(time)
    speed = np.gradient(position, time)
    assert position[0] == 0.0
    assert position[-1] == pytest.approx(stroke)
    assert np.max(speed) == pytest.approx(peak, rel=1e-3)
    acceleration = np.gradient(speed, time)
    assert np.max(np.abs(acceleration)) < 1001.0
    again = cumulative_trapezoid(speed, time, initial=0.0)
    np.testing.assert_allclose(again, position, atol=1e-3)
    assert motion(np.array([-1.0, 99.0])).tolist() == pytest.approx([0.0, stroke])


def test_a_project_s_reference(servo: ServoDrive, write: Write) -> None:
    motion, lasts = reference_motion(servo.project.reference)
    assert lasts == pytest.approx(270.0 / 360.0 + 0.36)
    assert motion(np.array([lasts]))[0] == pytest.approx(270.0)
    text = TEXT[: TEXT.index("[reference]")] + (
        '[reference]\nshape = "sine"\namplitude_deg = 2\nfrequency_hz = 10\ncycles = 3\n'
    )
    motion, lasts = reference_motion(load_servo_project(write(text)).reference)
    assert lasts == pytest.approx(0.3)
    assert motion(np.array([0.025]))[0] == pytest.approx(2.0)
