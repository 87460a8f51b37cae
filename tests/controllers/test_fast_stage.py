"""The fast stage: feed along the points, compensation (22) and (23), queue."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from core_designs import FAST, Variant, design, slow_stage
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.design import Status
from servogen.controllers.fast_design import compensation
from servogen.controllers.fast_stage import FastStage
from servogen.plants.errors import PlantError
from servogen.plants.statespace import StateSpace, discretise

FAST_PERIOD = 0.0002
COUNTS = st.lists(st.integers(0, 150), min_size=1, max_size=12)


def fast_stage(**changes) -> FastStage:
    return FastStage(design(Variant(**changes)).fast)


def at_rest(stage: FastStage, **values):
    inputs = {port.name: 0.0 for port in stage.declaration.operation("begin").inputs}
    return inputs | values


def push(stage: FastStage, points: np.ndarray, count: int) -> Status:
    full = stage.design.points
    padded = np.zeros((full, 2))
    padded[:count] = points[:count]
    inputs = {"points_x": padded[:, 0], "points_y": padded[:, 1], "n_points": count}
    return stage.call("push", inputs)[0]


def feed(stage: FastStage, counts: list[int], ahead: int) -> list[np.ndarray]:
    """``along`` (M + 1,) of every interval; ``ahead`` intervals are known in advance."""
    full = stage.design.points
    stage.call("reset", {"position_x": 0.0, "position_y": 0.0})
    points = np.zeros((full, 2))
    waiting = list(counts)
    for _ in range(ahead):
        if waiting:
            push(stage, points, waiting.pop(0))
    found = []
    for _ in counts:
        if waiting:
            push(stage, points, waiting.pop(0))
        stage.call("begin", at_rest(stage))
        found.append(np.array([float(stage.step()["along"]) for _ in range(full)]))
        found[-1] = np.append(found[-1], float(stage.along))
    return found


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    counts=COUNTS,
    ahead=st.integers(0, 4),
    ramp=st.sampled_from([0, 1, 50, 75]),
    precision=st.sampled_from(["float64", "float32"]),
)
def test_feed_conserves_points_and_keeps_to_rates_from_zero_to_one(counts, ahead, ramp, precision):
    stage = fast_stage(ramp=ramp, horizon=5, precision=precision)
    small = 1e-9 if precision == "float64" else 2e-4
    for count, along in zip(counts, feed(stage, counts, ahead), strict=True):
        rates = np.diff(along)
        assert along[0] == 0.0
        assert along[-1] == count
        assert np.all(rates >= -small)
        assert np.all(rates <= 1.0 + small)
        # the last step may only mend rounding: the plan itself covers the points
        assert abs(rates[-1] - rates[-2]) <= 2.0 / max(ramp, 1) + small if ramp else True


@settings(derandomize=True, deadline=None, max_examples=40)
@given(counts=st.lists(st.integers(40, 110), min_size=4, max_size=10))
def test_feed_does_not_jump_between_intervals_that_are_known(counts):
    """Moderate changes: the feed is continuous, its steps are those of a ramp of 50 samples."""
    stage = fast_stage(ramp=50, horizon=5)
    rates = np.concatenate([np.diff(along) for along in feed(stage, counts, 4)])
    steps = np.abs(np.diff(rates))[149:-150]  # the first interval starts from rest
    assert np.max(steps) <= 1.5 / 50


def test_without_ramp_the_feed_is_constant():
    stage = fast_stage(ramp=0, horizon=5)
    for count, along in zip([30, 150, 0], feed(stage, [30, 150, 0], 3), strict=True):
        assert np.allclose(np.diff(along), count / 150.0, atol=1e-9)


def test_ramp_lowers_the_acceleration_of_the_tool():
    """Facts, 9: along a straight line at 0.1 mm per point, a step in eta is a step in speed."""
    largest = {}
    for ramp in (0, 50):
        stage = fast_stage(ramp=ramp, horizon=5)
        along, first = [], 0.0
        for part in feed(stage, [75, 90, 60, 75, 75], 4):
            along.append(first + part[:-1])
            first += part[-1]
        position = 1e-4 * np.concatenate(along)
        second = np.abs(np.diff(position, 2)) / FAST_PERIOD**2
        largest[ramp] = np.max(second[160:-160])
    assert largest[0] > 200.0
    assert largest[50] < 49.05


def closed_loop_contour(matching: bool, order: int = 3, seconds: float = 0.9):
    """Tool and r_f (k, 2) while the slow stage wanders under commands of its own."""
    v = Variant(matching=matching, horizon=5, order=order)
    stage = FastStage(design(v).fast)
    slow = discretise(slow_stage(order), FAST_PERIOD)
    periods = round(seconds / 0.03)
    t = np.arange(periods * 150 + 1) * FAST_PERIOD
    path = np.stack([0.02 * (1 - np.cos(8.0 * t)), 0.02 * np.sin(6.0 * t) - 0.12 * t], axis=1)
    rng = np.random.default_rng(0)
    stage.call("reset", {"position_x": 0.0, "position_y": 0.0})
    state, commands, references, slow_y = np.zeros((2, order)), [], [], []
    names = ["position", "velocity", "acceleration", "state_3"][:order]
    for k in range(periods):
        push(stage, path[k * 150 + 1 : k * 150 + 151], 150)
        u = path[k * 150] + 0.003 * rng.normal(size=2)
        inputs = {
            f"{a}_{name}": state[i, j] for i, a in enumerate("xy") for j, name in enumerate(names)
        }
        inputs |= {f"slow_command_{a}": u[i] for i, a in enumerate("xy")}
        assert stage.call("begin", inputs)[0] is Status.OK
        for _ in range(150):
            out = stage.step()
            commands.append([out["command_x"], out["command_y"]])
            references.append([out["reference_x"], out["reference_y"]])
            slow_y.append(state[:, 0].copy())
            for i in range(2):
                state[i] = slow.a @ state[i] + slow.b * u[i]
    fast = discretise(FAST, FAST_PERIOD)
    system = scipy.signal.dlti(fast.a, fast.b[:, None], fast.c[None, :], 0.0, dt=FAST_PERIOD)

    def through(signal):
        columns = [scipy.signal.dlsim(system, column)[1][:, 0] for column in np.array(signal).T]
        return np.stack(columns, axis=1)

    tool = np.array(slow_y) + through(commands)
    return tool, through(references), np.array(references)


@pytest.mark.parametrize("order", [3, 4])
def test_matching_makes_the_tool_follow_g_f_of_the_reference(order):
    """(23): y = G_f r_f, as if there were no slow stage at all; simulated by scipy."""
    tool, ideal, references = closed_loop_contour(True, order)
    assert np.max(np.abs(references)) > 0.03
    error = np.max(np.abs(tool - ideal))
    assert error < 3e-6
    plain_tool, plain_ideal, _ = closed_loop_contour(False, order)
    assert np.max(np.abs(plain_tool - plain_ideal)) > 100.0 * error


def test_ideal_machine_has_lag_but_hardly_any_contour_error():
    """Facts, 8: G_f r_f lags by almost a millimetre at speed and stays on the contour."""
    _, ideal, references = closed_loop_contour(matching=True)
    lag = np.linalg.norm(ideal - references, axis=1)[500:]
    distance = np.array(
        [np.min(np.linalg.norm(references - point, axis=1)) for point in ideal[500:-50:25]]
    )
    assert np.max(lag) > 2e-4
    assert np.max(distance) < 4e-5  # half a step of the reference is 20 um


def test_matching_row_is_the_derivative_form():
    """y_s + (a1/a0) v + (a2/a0) a + jerk / a0, written out for the third-order servo."""
    slow, w, zeta = slow_stage(), 2250.0, 0.7
    a1, a2, a0 = (1 + 2 * zeta) * w**2, (1 + 2 * zeta) * w, w**3
    part = compensation(slow, FAST, FAST_PERIOD, True)
    half = discretise(slow, FAST_PERIOD / 2)
    jerk = slow.a[2]
    row = np.array([1.0, a1 / a0, a2 / a0]) + jerk / a0
    direct = slow.b[2] / a0
    assert np.allclose(part.row, row @ half.a, rtol=1e-9)
    assert np.isclose(part.direct, row @ half.b + direct, rtol=1e-9)
    plain = compensation(slow, FAST, FAST_PERIOD, False)
    assert list(plain.row) == [1.0, 0.0, 0.0]
    assert plain.direct == 0.0


def test_matching_refuses_a_fast_stage_with_zeros():
    # a zero at -3000 rad/s beside the poles of the servo: c b and c a b are no longer zero
    fast = StateSpace(FAST.a, FAST.b + np.array([0.0, 1e-3 * FAST.b[2], 0.0]), FAST.c)
    with pytest.raises(PlantError):
        compensation(slow_stage(), fast, FAST_PERIOD, True)
    compensation(slow_stage(), fast, FAST_PERIOD, False)


def test_queue_overflows_runs_dry_and_is_forgotten_by_reset():
    stage = fast_stage(horizon=2)
    line = np.linspace(0, 0.01, 150)[:, None] * np.ones(2)
    assert push(stage, line, 3) is Status.NOT_READY
    assert stage.call("begin", at_rest(stage)) == (Status.NOT_READY, {"interval_points": 0})
    assert stage.call("reset", {"position_x": 0.0, "position_y": 0.0})[0] is Status.OK
    assert push(stage, line, 10) is Status.OK
    assert push(stage, line, 150) is Status.OK
    assert push(stage, line, 1) is Status.OVERFLOW
    assert stage.call("begin", at_rest(stage))[1]["interval_points"] == 10
    assert push(stage, line, 7) is Status.OK
    counts = [stage.call("begin", at_rest(stage))[1]["interval_points"] for _ in range(3)]
    assert counts == [150, 7, 0]
    push(stage, line, 5)
    stage.call("reset", {"position_x": 0.1, "position_y": 0.0})
    assert stage.call("begin", at_rest(stage))[1]["interval_points"] == 0
    assert stage.step()["reference_x"] == 0.1
    assert push(stage, np.full((150, 2), np.nan), 5) is Status.NOT_FINITE
    assert push(stage, np.full((150, 2), 0.41), 5) is Status.OUT_OF_RANGE
    assert push(stage, np.full((150, 2), np.nan), 0) is Status.OK


def test_samples_beyond_the_interval_wait_at_its_last_point():
    stage = fast_stage(horizon=2)
    stage.call("reset", {"position_x": 0.0, "position_y": 0.0})
    line = np.linspace(0, 0.01, 150)[:, None] * np.ones(2)
    push(stage, line, 100)
    stage.call("begin", at_rest(stage))
    for _ in range(150):
        stage.step()
    for _ in range(10):
        out = stage.step()
        assert out["along"] == 100.0
        assert out["reference_x"] == line[99, 0]


@pytest.mark.parametrize(("points", "ramp"), [(2, 0), (3, 1), (5, 1)])
def test_few_fast_samples(points, ramp):
    stage = fast_stage(points=points, ramp=ramp, horizon=2)
    for counts in ([1, 0, points], [points, points, 1], [0, 0, 1]):
        for count, along in zip(counts, feed(stage, counts, 1), strict=True):
            assert along[-1] == count
            assert np.all(np.diff(along) >= -1e-12)
            assert np.all(np.diff(along) <= 1.0 + 1e-12)


def test_command_is_clamped_to_the_range_it_declares():
    stage = fast_stage(horizon=2)
    stage.call("reset", {"position_x": 0.3, "position_y": 0.0})
    stage.call("begin", at_rest(stage, x_velocity=2.0))
    out = stage.step()
    assert out["command_x"] == pytest.approx(0.035 * 1.2)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.lists(st.integers(0, 150), min_size=1, max_size=6))
def test_an_interval_of_no_more_points_than_there_is_room_for_starts_without_a_step(counts):
    # one interval at a time, as the governor alone queues them: the next one is never known
    stage = fast_stage(horizon=0)
    stage.call("reset", {"position_x": 0.0, "position_y": 0.0})
    line = np.linspace(0, 0.01, 150)[:, None] * np.ones(2)
    for count in counts:
        room = stage.call("room")[1]["points"]
        assert 0 < room <= 150
        before = stage.rate_end
        push(stage, line, min(count, room))
        stage.call("begin", at_rest(stage))
        assert stage.rate_begin <= before + 1e-12  # a step up never; down where the points are few
        if count >= room:
            assert stage.rate_begin == pytest.approx(before, abs=1e-12)


def test_without_ramp_there_is_room_for_all_points():
    assert fast_stage(ramp=0).call("room")[1]["points"] == 150
