"""The extended command governor around its machine: whole paths, with and without a solver."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

from governed_machine import EPSILON, STROKE, figures, least_motion, machine, stage

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_design import CommandGovernorDesign, GovernorSettings
from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.controllers.mpc_solver import ActiveSetSolver, Answer
from servogen.errors import InputError
from servogen.precision import FLOAT32
from servogen.systems.closed_loop import STALLED, Stalled
from servogen.systems.command_governor_loop import (
    GovernedRun,
    _longest_wait,
    check_drawing,
    excess,
    run_governed,
)

HORIZON, M = 12, 48
PATH = figures(3, 5, 400)
MOTION = least_motion(PATH)
STAGES = (stage(), stage())
# What a plan may miss of a limit at its instants: nothing, but for the sums of two simulations.
ROUNDING = 1e-9


def design(settings: GovernorSettings | None = None, sub_samples: int = 3) -> CommandGovernorDesign:
    return machine(HORIZON, settings or GovernorSettings(), M, sub_samples)


def run(
    chosen: CommandGovernorDesign, reference: np.ndarray = MOTION, periods: int | None = None
) -> GovernedRun:
    return run_governed(chosen, STAGES, PATH, reference, CommandGovernor(chosen), periods)


def keeps_its_limits(chosen: CommandGovernorDesign, done: GovernedRun, sub_samples: int) -> None:
    """(a): position, velocity and acceleration at the N instants, the stroke at the ends."""
    at_instants, at_ends = excess(chosen, done, M // sub_samples), excess(chosen, done, M)
    for name in ("position", "velocity", "acceleration"):
        assert getattr(at_instants, name) <= ROUNDING
    assert at_ends.stroke <= ROUNDING


@pytest.mark.parametrize("reference", [MOTION, PATH], ids=["minimal motion", "pattern"])
@pytest.mark.parametrize("after", [True, False])
def test_whole_path_within_its_limits(reference: np.ndarray, after: bool) -> None:
    chosen = design(GovernorSettings(after=after))
    done = run(chosen, reference)
    assert done.complete
    assert set(done.status) <= {Status.OK, Status.BACKUP}
    assert done.taken.sum() == len(PATH) - 1
    assert done.taken.max() <= M
    np.testing.assert_array_equal(done.first, np.cumsum(done.taken) - done.taken)
    keeps_its_limits(chosen, done, 3)
    assert excess(chosen, done, 1).velocity < 0.03
    assert excess(chosen, done, 1).stroke < 0.02
    ideal = (len(PATH) - 1) / M * done.period_s
    assert ideal < done.time_s < 4.0 * ideal


def test_the_first_point_after_is_the_faster_reference() -> None:
    times = [run(design(GovernorSettings(after=after))).time_s for after in (True, False)]
    assert times[0] < times[1]


def test_fewer_points_ahead_are_enough_and_slower() -> None:
    """An eighth of the points that a plan can machine."""
    chosen = design(GovernorSettings(points_ahead=80))
    assert chosen.window == 80
    done = run(chosen, PATH)
    assert done.complete
    keeps_its_limits(chosen, done, 3)
    assert done.time_s > run(design(), PATH).time_s
    assert design(GovernorSettings(points_ahead=10**6)).window == (HORIZON + 1) * M + 1
    with pytest.raises(DesignError, match="points_ahead"):
        design(GovernorSettings(points_ahead=M))


def test_more_instants_leave_less_between_them() -> None:
    """Facts of the machine at a longer horizon: 2.5, 0.63, 0.28 % of velocity for N = 1, 2, 3."""
    between = []
    for sub_samples in (1, 2, 3):
        chosen = design(sub_samples=sub_samples)
        done = run(chosen, PATH)
        keeps_its_limits(chosen, done, sub_samples)
        between.append(excess(chosen, done, 1).velocity)
    assert between[0] > between[1] > between[2] > 0.0
    assert between[2] < 0.5 * between[0]


def test_margin_and_sub_step_rows_keep_the_stroke_between_the_samples() -> None:
    chosen = design(GovernorSettings(stroke_margin_m=0.0005, sub_step_stroke=True))
    done = run(chosen, PATH)
    assert done.complete
    assert excess(chosen, done, M // 3).stroke <= -0.0005 / STROKE + ROUNDING
    assert excess(chosen, done, 1).stroke <= 0.0


class Unlucky(ActiveSetSolver):
    """Ends at its cap three times in four, by lot."""

    def __init__(self, solver: ActiveSetSolver, seed: int) -> None:
        super().__init__(solver.tables)
        self.lot = np.random.default_rng(seed)

    def solve(self, *program: np.ndarray, **more: bool) -> Answer:
        answer = super().solve(*program, **more)
        return Answer(None, Status.BACKUP, 150) if self.lot.random() < 0.75 else answer


@pytest.mark.parametrize("reference", [MOTION, PATH], ids=["minimal motion", "pattern"])
def test_recursive_feasibility_over_a_path_whatever_the_solver_does(reference: np.ndarray) -> None:
    """(b): the moved plan is always there to fall back on, the path is finished all the same."""
    chosen = design()
    governor = CommandGovernor(chosen)
    for i, axis in enumerate(governor.axes):
        axis.solver = Unlucky(axis.solver, i)
    done = run_governed(chosen, STAGES, PATH, reference, governor)
    assert done.complete
    assert np.count_nonzero(done.status_axis == Status.BACKUP) > 100
    # by lot some of the waits at rest are longer than the governor's patience
    assert set(done.status_axis.ravel()) <= {Status.OK, Status.BACKUP, Status.SUBOPTIMAL}
    keeps_its_limits(chosen, done, 3)


def test_points_once_planned_are_machined_in_their_period_or_before() -> None:
    """No plan takes back what the one before it gave to a period."""
    chosen = design()
    governor = CommandGovernor(chosen)

    class Watched:
        declaration = governor.declaration
        planned_ahead = 0

        def call(self, operation, inputs=None):  # type: ignore[no-untyped-def]
            before = governor.planned.copy()
            status, out = governor.call(operation, inputs)
            if operation == "step":
                indices = governor.planned + out["points_taken"]
                assert np.all(indices[:-1] >= before[1:])
                assert before[0] == 0
                self.planned_ahead += int(before[-1] > M)
            return status, out

    watched = Watched()
    assert run_governed(chosen, STAGES, PATH, MOTION, watched).complete
    assert watched.planned_ahead > 20


def test_a_cap_of_one_iteration_is_never_infeasible() -> None:
    chosen = design(GovernorSettings(cap=1))
    done = run(chosen, PATH, 150)
    assert np.count_nonzero(done.status_axis == Status.BACKUP) > 30
    # by lot some of the waits at rest are longer than the governor's patience
    assert set(done.status_axis.ravel()) <= {Status.OK, Status.BACKUP, Status.SUBOPTIMAL}
    keeps_its_limits(chosen, done, 3)


def test_a_push_holds_the_tool_until_the_stage_is_back() -> None:
    """No points while the plan is not to be kept; then the path goes on and is finished."""
    chosen = design()
    governor = CommandGovernor(chosen)
    push = {20: 0.004, 30: -0.003}

    class Pushed:
        declaration = governor.declaration
        period, infeasible = 0, 0

        def call(self, operation, inputs=None):  # type: ignore[no-untyped-def]
            if operation != "step":
                return governor.call(operation, inputs)
            pushed = dict(inputs)
            pushed["x_position"] += push.get(self.period, 0.0)
            self.period += 1
            status, out = governor.call("step", pushed)
            if status is Status.INFEASIBLE:
                self.infeasible += 1
                assert out["points_taken"] == 0
                assert not np.any(governor.planned)
            return status, out

    pushed = Pushed()
    done = run_governed(chosen, STAGES, PATH, PATH, pushed)
    assert done.complete
    assert pushed.infeasible > 0


def test_statuses_of_the_whole() -> None:
    chosen = design()
    governor = CommandGovernor(chosen)
    inputs = {port.name: 0.05 for port in governor.declaration.operation("step").inputs}
    for name in ("points_x", "points_y", "slow_x", "slow_y"):
        inputs[name] = np.full(chosen.window, 0.05)
    for axis in "xy":
        inputs[f"{axis}_velocity"] = inputs[f"{axis}_acceleration"] = 0.0
    inputs["n_points"] = 10
    assert governor.call("step", inputs)[0] is Status.NOT_READY
    assert governor.call("reset", {"position_x": 0.05, "position_y": 0.05})[0] is Status.OK
    status, out = governor.call("step", inputs)
    assert (status, out["points_taken"]) == (Status.OK, 10)
    # points that are not valid are not read
    inputs["points_x"][5:] = np.nan
    status, out = governor.call("step", {**inputs, "n_points": 5})
    assert (status, out["points_taken"]) == (Status.OK, 5)
    status, out = governor.call("step", {**inputs, "n_points": 6})
    assert (status, out["points_taken"]) == (Status.NOT_FINITE, 0)
    status, out = governor.call("step", {**inputs, "n_points": chosen.window + 1})
    assert (status, out["points_taken"]) == (Status.OUT_OF_RANGE, 0)
    status, out = governor.call("step", {**inputs, "n_points": 0})
    assert (status, out["points_taken"]) == (Status.FINISHED, 0)
    assert out["command_x"] == pytest.approx(0.05)


def test_prediction_of_both_axes() -> None:
    """From what each axis measures, and from its own model where that is no number."""
    governor = CommandGovernor(design())
    governor.call("reset", {"position_x": 0.05, "position_y": 0.06})
    names = [port.name for port in governor.declaration.operation("predict").inputs]
    inputs = dict(zip(names, [0.051, 0.0, 0.0, float("nan"), 0.0, 0.0], strict=True))
    status, out = governor.call("predict", inputs)
    assert CommandGovernor(design()).call("predict", inputs)[0] is Status.NOT_READY
    assert status is Status.NOT_FINITE
    assert list(out) == names
    assert 0.05 < out["x_position"] < 0.051
    assert (out["y_position"], out["y_velocity"]) == (0.06, 0.0)


def test_single_precision_finishes_too() -> None:
    chosen = machine(HORIZON, GovernorSettings(), M, 3, FLOAT32)
    done = run(chosen, PATH)
    assert done.complete
    assert set(done.status) <= {Status.OK, Status.BACKUP}
    assert excess(chosen, done, M // 3).velocity <= 1e-5
    assert excess(chosen, done, M).stroke <= 1e-5


def test_a_reference_out_of_reach_stalls_and_is_refused_beforehand() -> None:
    """A reference 30 mm from its points: the tool waits for ever, and the check names the point."""
    chosen = design()
    away = MOTION.copy()
    away[700:, 0] += 0.03
    governor, told = CommandGovernor(chosen), []

    class Heard:
        declaration = governor.declaration

        def call(self, operation, inputs=None):  # type: ignore[no-untyped-def]
            status, out = governor.call(operation, inputs)
            told.append(status)
            return status, out

    with pytest.raises(Stalled):
        run_governed(chosen, STAGES, PATH, away, Heard())
    assert told[-1] is Status.UNREACHABLE
    assert set(told) == {Status.OK, Status.UNREACHABLE}
    with pytest.raises(InputError, match=r"point 7\d\d.*within 0.024 m of it in x"):
        check_drawing(chosen, PATH, away, EPSILON)
    check_drawing(chosen, PATH, MOTION, EPSILON)
    check_drawing(chosen, PATH, PATH, EPSILON)


def test_a_slow_machine_waits_longer_before_it_counts_as_stalled() -> None:
    """Many times what it takes for a step of twice the stroke."""
    chosen = design()
    x = chosen.axes[0]
    assert 500 < _longest_wait(chosen) < 800
    crawling = replace(x, reach=replace(x.reach, velocity_m_per_s=1e-3))
    weak = replace(x, reach=replace(x.reach, acceleration_m_per_s2=1e-3))
    step = 4.0 * STROKE / x.plant.sample_time_s
    assert _longest_wait(replace(chosen, axes=(x, crawling))) > STALLED * step / 1e-3
    assert _longest_wait(replace(chosen, axes=(weak, x))) > STALLED * step / (STROKE * 2e-3) ** 0.5


@pytest.mark.parametrize(
    ("at", "move", "expected"),
    [(0, (-0.05, 0.0), "point 0.*start"), (9, (0.0, 0.3), "point 9.*middle of y")],
)
def test_drawings_outside_the_axes_are_refused(
    at: int, move: tuple[float, float], expected: str
) -> None:
    chosen, points = design(), PATH.copy()
    points[at:] += np.array(move)
    with pytest.raises(InputError, match=expected):
        check_drawing(chosen, points, points, EPSILON)


def test_a_jump_beyond_the_stroke_is_refused() -> None:
    points = np.full((4, 2), 0.1)
    points[2:, 1] += 0.0495
    with pytest.raises(InputError, match=r"point 2.*step of at most 0.0489\d* m to it in y"):
        check_drawing(design(), points, points, EPSILON)
