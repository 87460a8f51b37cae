"""predict, plan and start: the cascade one period ahead of the machine."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from core_designs import Variant, design
from core_loop import zigzag

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Status, Value

AHEAD = Variant(horizon=3)
ALONE = Variant(horizon=0)
STATE = ("position", "velocity", "acceleration")


def points_of(path: np.ndarray, given: int, most: int) -> dict[str, Value]:
    count = min(most, len(path) - 1 - given)
    window = np.zeros((2, most))
    window[:, :count] = path[given + 1 : given + 1 + count].T
    return {"points_x": window[0], "points_y": window[1], "n_points": count}


def named(states: np.ndarray) -> dict[str, Value]:
    return {f"{a}_{n}": states[i, k] for i, a in enumerate("xy") for k, n in enumerate(STATE)}


def at_start(v: Variant, path: np.ndarray) -> tuple[Cascade, np.ndarray]:
    cascade = Cascade(design(v))
    cascade.call("reset", {"position_x": path[0, 0], "position_y": path[0, 1]})
    state = np.zeros((2, 3))
    state[:, 0] = path[0]
    return cascade, state


def fill(cascade: Cascade, state: np.ndarray, path: np.ndarray, most: int) -> tuple[int, Status]:
    """Plan until the horizon is full; the points taken and the last status."""
    given = 0
    while True:
        status, out = cascade.call("plan", {**named(state), **points_of(path, given, most)})
        given += int(np.asarray(out["points_taken"]))
        if status is not Status.PRIMING:
            return given, status


@pytest.mark.parametrize("v", [AHEAD, ALONE], ids=["mpc", "sprg"])
def test_plan_and_start_are_step(v: Variant) -> None:
    path = zigzag(seconds=3.0)
    split, state = at_start(v, path)
    whole, _ = at_start(v, path)
    given = 0
    for _ in range(40):
        inputs = {**named(state), **points_of(path, given, v.points)}
        planned, first = split.call("plan", inputs)
        started, then = split.call("start")
        status, out = whole.call("step", inputs)
        given += int(np.asarray(out["points_taken"]))
        assert first["points_taken"] == out["points_taken"]
        if status is Status.PRIMING:
            assert planned is Status.PRIMING
            assert started is Status.NOT_READY
            continue
        assert status is planned
        assert started is Status.OK
        for name in ("command_x", "command_y", "interval_points", "pending"):
            assert then[name] == out[name]
        assert np.array_equal(
            split.repeat("fast_step", v.points), whole.repeat("fast_step", v.points)
        )
        plants = design(v).plants
        for i, axis in enumerate("xy"):
            command = float(np.asarray(out[f"command_{axis}"]))
            state[i] = plants[i].a @ state[i] + plants[i].b * command


@pytest.mark.parametrize("v", [AHEAD, ALONE], ids=["mpc", "sprg"])
def test_start_without_a_plan_changes_nothing(v: Variant) -> None:
    path = zigzag(seconds=3.0)
    cascade, state = at_start(v, path)
    assert cascade.call("start")[0] is Status.NOT_READY
    fill(cascade, state, path, v.points)
    assert cascade.call("start")[0] is Status.OK
    cascade.repeat("fast_step", v.points)
    command = cascade.command.copy()
    held = cascade.repeat("fast_step", 3)
    status, out = cascade.call("start")
    assert status is Status.NOT_READY
    assert out["interval_points"] == 0
    assert cascade.command == command
    again = cascade.repeat("fast_step", 3)
    assert np.array_equal(held[:, 2:], again[:, 2:])  # the tool stands at the interval's last point


def test_predict_is_the_sampled_model_from_the_command_in_force() -> None:
    path = zigzag(seconds=3.0)
    cascade, state = at_start(AHEAD, path)
    fill(cascade, state, path, AHEAD.points)
    cascade.call("start")
    measured = np.array([[0.01, -0.2, 1.5], [-0.02, 0.3, -2.0]])
    status, ahead = cascade.call("predict", named(measured))
    assert status is Status.OK
    for i, (axis, plant) in enumerate(zip("xy", design(AHEAD).plants, strict=True)):
        expected = plant.a @ measured[i] + plant.b * float(cascade.command[i])
        got = [float(np.asarray(ahead[f"{axis}_{name}"])) for name in STATE]
        assert got == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("value", "expected"), [(np.nan, Status.NOT_FINITE), (1e6, Status.OUT_OF_RANGE)]
)
def test_predict_without_a_usable_measurement_goes_on_from_the_last_state(
    value: float, expected: Status
) -> None:
    path = zigzag(seconds=3.0)
    cascade, state = at_start(AHEAD, path)
    fill(cascade, state, path, AHEAD.points)
    cascade.call("start")
    good: Mapping[str, Value] = named(np.array(cascade.state))
    bad = {**good, "y_velocity": value}
    status, ahead = cascade.call("predict", bad)
    assert status is expected
    assert ahead == cascade.call("predict", good)[1]
