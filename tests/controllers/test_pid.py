"""The cascaded PID: notch against scipy, anti-windup, the headstock at two rates, statuses."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.signal
from headstock_mpc import HEADSTOCK
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.controllers.pid import Pid
from servogen.controllers.pid_design import Notch, PidDesign
from servogen.precision import FLOAT64, PRECISIONS

PRINTED_NOTCH = Notch(0.9352, -0.9352 * 1.9774, 0.9352, -1.8492, 0.8651)
RPM = 6.0  # deg/s
DESIGN = PidDesign(
    prefix="pid",
    precision=FLOAT64,
    position_gain_per_s=3.6111 * RPM,
    velocity_gain=444.4 / RPM,
    integral_time_s=2e-3,
    notch=PRINTED_NOTCH,
    sample_time_s=500e-6,
    ratio=8,
    current_low=-1000.0,
    current_high=1000.0,
    reach=36_864.0,
    turn=360.0,
)


def ready(**changes: object) -> Pid:
    pid = Pid(dataclasses.replace(DESIGN, **changes))
    assert pid.call("reset", {"position": 0.0})[0] is Status.OK
    return pid


def test_table_i_in_the_loops_own_units() -> None:
    assert pytest.approx(21.67, abs=5e-3) == DESIGN.position_gain_per_s
    assert PRINTED_NOTCH.dc_gain == pytest.approx(1.33, abs=5e-3)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    precision=st.sampled_from(["float32", "float64"]),
    length=st.integers(1, 200),
)
def test_the_notch_is_scipy_s(seed: int, precision: str, length: int) -> None:
    pid = ready(precision=PRECISIONS[precision], current_low=-1e6, current_high=1e6)
    wanted = np.random.default_rng(seed).normal(size=length) * 100.0
    found = []
    for value in wanted:
        pid.wanted = PRECISIONS[precision].dtype.type(value)
        found.append(float(pid.call("filter_step")[1]["current"]))
    n = PRINTED_NOTCH
    expected = scipy.signal.lfilter([n.b0, n.b1, n.b2], [1.0, n.a1, n.a2], wanted)
    np.testing.assert_allclose(found, expected, atol=1e-9 if precision == "float64" else 0.05)


def test_one_step_is_the_formula() -> None:
    pid = ready(notch=None)
    for position, reference in ((0.0, 0.01), (0.002, 0.03)):
        pid.call("step", {"position": position, "reference": reference})
    gain, kp = 444.4 / 6.0, 3.6111 * 6.0
    one = kp * 0.01
    two = kp * (0.03 - 0.002) - 0.002 / 500e-6
    integral = gain * 500e-6 / 2e-3 * (one + two)
    assert pid.wanted == pytest.approx(gain * two + integral, rel=1e-12)
    assert pid.call("filter_step")[1]["current"] == pid.wanted


def run(pid: Pid, reference, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles and currents (K,) of the headstock, sampled exactly at the filter's rate."""
    period = pid.design.sample_time_s / pid.design.ratio
    plant = HEADSTOCK.sampled(period)
    state, angles, currents = np.zeros(4), [], []
    pid.call("reset", {"position": 0.0})
    for k in range(round(seconds / period)):
        angle = float((plant.c @ state)[0])
        if k % pid.design.ratio == 0:
            given = {"position": angle, "reference": reference(k * period)}
            assert pid.call("step", given)[0] is Status.OK
        currents.append(float(pid.call("filter_step")[1]["current"]))
        state = plant.a @ state + plant.b[:, 0] * currents[-1]
        angles.append(angle)
    return np.array(angles), np.array(currents)


def test_the_printed_notch_needs_the_current_loop_s_rate() -> None:
    """At 62.5 us the axis comes to rest; once a sample, its phase is lost and it swings on."""
    for ratio, swings in ((8, False), (1, True)):
        _, currents = run(ready(ratio=ratio, turn=0.0), lambda _: 1.0, 0.6)
        end = currents[-round(0.1 / (500e-6 / ratio)) :]
        assert (np.ptp(end) > 500.0) == swings


def test_the_integral_does_not_wind_up() -> None:
    """A step of 20 degrees asks for more current than there is; the axis settles without passing
    it, where an integral that runs on takes it to more than twice that and back."""
    pid = ready(turn=0.0)
    angles, currents = run(pid, lambda _: 20.0, 1.0)
    assert np.max(np.abs(currents)) == 1000.0
    assert np.max(angles) < 20.0 + 1e-6
    assert angles[-1] == pytest.approx(20.0, abs=1e-6)

    def running_on(error: float) -> None:
        pid.integral += DESIGN.velocity_gain * 500e-6 / 2e-3 * error
        pid.wanted = float(np.clip(DESIGN.velocity_gain * error + pid.integral, -1000.0, 1000.0))

    pid._speed_loop = running_on
    assert np.max(run(pid, lambda _: 20.0, 1.0)[0]) > 40.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_at_the_limit_the_integral_only_comes_back(sign: float) -> None:
    pid = ready(notch=None, turn=0.0)
    pid.call("step", {"position": 0.0, "reference": sign * 0.1})
    before = pid.integral
    assert before * sign > 0.0
    pid.call("step", {"position": 0.0, "reference": sign * 50.0})
    assert (pid.wanted, pid.integral) == (sign * 1000.0, before)
    pid.integral = sign * 990.0
    pid._speed_loop(-sign * 0.01)
    assert 0.0 < pid.integral * sign < 990.0


def test_the_short_way_round() -> None:
    pid = ready(notch=None)
    pid.call("reset", {"position": 359.0})
    pid.call("step", {"position": 359.0, "reference": 1.0})
    assert pid.wanted > 0.0
    pid.call("reset", {"position": 1.0})
    pid.call("step", {"position": 1.0, "reference": 359.0})
    assert pid.wanted < 0.0


@pytest.mark.parametrize(
    ("port", "value", "status"),
    [
        ("position", np.nan, Status.NOT_FINITE),
        ("reference", np.inf, Status.NOT_FINITE),
        ("reference", 4e4, Status.OUT_OF_RANGE),
    ],
)
def test_unusable_inputs_are_told_and_take_the_current_away(port, value, status) -> None:
    pid = ready()
    good = {"position": 0.0, "reference": 0.1}
    assert pid.call("step", good)[1]["wanted"] > 0.0
    assert pid.integral > 0.0
    assert pid.call("step", good | {port: value}) == (status, {"wanted": 0.0})
    assert pid.integral == 0.0
    for _ in range(400):
        code, out = pid.call("filter_step")
        assert code is Status.OK
    assert abs(out["current"]) < 1e-6
    assert pid.call("step", good)[0] is Status.OK


def test_before_reset_there_is_no_current() -> None:
    pid = Pid(DESIGN)
    assert pid.call("step", {"position": 0.0, "reference": 1.0}) == (
        Status.NOT_READY,
        {"wanted": 0.0},
    )
    assert pid.call("filter_step") == (Status.NOT_READY, {"current": 0.0})
    assert pid.call("reset", {"position": np.nan})[0] is Status.NOT_FINITE
    assert pid.call("filter_step")[0] is Status.NOT_READY


NUMBERS = st.one_of(
    st.floats(-400.0, 400.0), st.sampled_from([np.nan, np.inf, -np.inf, 1e30, 36_864.0, -36_864.0])
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    precision=st.sampled_from(["float32", "float64"]),
    calls=st.lists(st.tuples(NUMBERS, NUMBERS), max_size=25),
)
def test_whatever_comes_in_the_current_is_within_its_limit(precision, calls) -> None:
    pid = ready(precision=PRECISIONS[precision])
    for position, reference in calls:
        status, out = pid.call("step", {"position": position, "reference": reference})
        usable = abs(position) <= 36_864.0 and abs(reference) <= 36_864.0
        assert (status is Status.OK) == usable
        assert abs(out["wanted"]) <= 1000.0
        for _ in range(8):
            current = pid.call("filter_step")[1]["current"]
            assert abs(current) <= 1000.0


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"position_gain_per_s": 0.0}, "position_gain_per_s"),
        ({"integral_time_s": float("nan")}, "integral_time_s"),
        ({"current_high": -1.0}, "current_low"),
        ({"current_low": 0.5}, "current_low"),
        ({"current_low": float("nan")}, "current_low"),
        ({"ratio": 0}, "ratio"),
        ({"turn": 0.3}, "turn"),
    ],
)
def test_designs_that_cannot_be_are_refused(change: dict[str, object], key: str) -> None:
    with pytest.raises(DesignError) as caught:
        dataclasses.replace(DESIGN, **change)
    assert caught.value.key == key


def test_a_notch_that_grows_is_refused() -> None:
    with pytest.raises(DesignError, match="notch"):
        Notch(1.0, 0.0, 0.0, -2.1, 1.05)
