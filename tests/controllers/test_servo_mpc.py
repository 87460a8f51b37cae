"""The MPC of the headstock axis: first move, angles that come round, statuses and safe outputs."""

from __future__ import annotations

import daqp
import numpy as np
import pytest
from headstock_mpc import PLANT, headstock_design, headstock_mpc, headstock_problem
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.controllers.kalman import Noise, design_filter
from servogen.controllers.prediction import Horizons
from servogen.controllers.servo_mpc import ServoMpc, SolvedMove
from servogen.controllers.servo_mpc_design import ServoMpcDesign
from servogen.controllers.tracking_qp import (
    Bounds,
    Constraints,
    TrackingQp,
    Weights,
    tracking_qp,
)
from servogen.plants.sampled import Sampled
from servogen.precision import FLOAT64, PRECISIONS

GRID = 360.0 / 92_160  # 2^-8 degrees: multiples are float32 numbers up to 65,536 degrees


def parameters(problem: TrackingQp, count: int, seed: int) -> np.ndarray:
    """A third about the size of motions, a third on or next to facets, a third far outside."""
    generator = np.random.default_rng(seed)
    qp = problem.qp
    size = np.concatenate([[100.0, 100.0, np.pi, np.pi], [1000.0], np.full(qp.parameters - 5, 9.0)])
    theta = generator.normal(size=(count, qp.parameters)) * size
    optimum = qp.unconstrained()[0]
    inverse = np.linalg.pinv(optimum)
    for i in range(0, count, 3):
        # move the unconstrained optimum of some inputs onto their bound, or a rounding beside it
        z = optimum @ theta[i]
        bound = np.sign(z) * 1000.0 * (1.0 + generator.choice([0.0, 1e-15, -1e-15, 1e-9]))
        chosen = generator.random(z.size) < 0.5
        theta[i] += inverse @ np.where(chosen, bound - z, -0.9 * z)
    theta[1::3] *= 1e3
    return theta


@pytest.mark.parametrize("trajectory", [1, 2, 3, 5, 8])
def test_the_first_move_is_an_outside_solver_s(trajectory: int) -> None:
    extend = "zero_order" if trajectory == 1 else "first_order"
    problem = headstock_problem(trajectory, extend)
    law, qp = SolvedMove(problem, FLOAT64), problem.qp
    n = qp.variables
    scaled = qp.hessian / qp.hessian[0, 0]
    for theta in parameters(problem, 300, trajectory):
        z, _, flag, _ = daqp.solve(
            scaled,
            (qp.linear @ theta) / qp.hessian[0, 0],
            np.zeros((0, n)),
            np.full(n, 1000.0),
            np.full(n, -1000.0),
            np.zeros(n, dtype=np.int32),
            primal_tol=1e-10,
            dual_tol=1e-10,
        )
        assert flag == 1
        status, move = law(theta)
        assert status is Status.OK
        assert move[0] == pytest.approx(z[0], abs=1e-6)


def drive(controller: ServoMpc, references: np.ndarray, start: float = 0.0, shown=None):
    """Currents while the controller moves the headstock; ``shown`` makes of the motor's angle and
    the references what the controller is told, both relative to ``start``."""
    shown = shown or (lambda value: value)
    taken = controller.design.problem.horizons.trajectory
    controller.call("reset", {"position": shown(np.array(0.0))})
    state, currents = np.zeros(4), []
    for k in range(len(references) - taken):
        angle = np.round((PLANT.c @ state)[0] / GRID) * GRID
        status, out = controller.call(
            "step",
            {
                "position": shown(np.array(angle)),
                "reference": shown(references[k + 1 : k + 1 + taken]),
            },
        )
        assert status is Status.OK
        currents.append(float(out["current"]))
        state = PLANT.a @ state + PLANT.b[:, 0] * currents[-1]
    return np.array(currents), state


def sine(steps: int, amplitude: float = 2.0, hertz: float = 5.0) -> np.ndarray:
    time = np.arange(steps) * PLANT.sample_time_s
    return np.round(amplitude * np.sin(2 * np.pi * hertz * time) / GRID) * GRID


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("turn", [0.0, 360.0])
def test_at_36000_degrees_it_computes_the_same_bits(precision: str, turn: float) -> None:
    """References and encoder on a grid that float32 still holds there."""
    near, _ = drive(headstock_mpc(precision=precision, turn=turn), sine(400))
    far, _ = drive(
        headstock_mpc(precision=precision, turn=turn), sine(400), shown=lambda x: x + 36_000.0
    )
    assert np.ptp(near) > 500.0
    np.testing.assert_array_equal(near, far)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_turn_more_or_less_is_nothing(precision: str) -> None:
    """The axis goes on past 360 degrees; told modulo a turn, in turns of its own, or not at all."""
    references = sine(600) + np.arange(600) * 0.17578125 + 300.0
    references = np.concatenate([np.full(1, 300.0), references[1:]])
    plain, end = drive(headstock_mpc(precision=precision, turn=0.0), references - 300.0)
    assert np.rad2deg(end[2]) > 70.0
    for shown in (
        lambda x: np.mod(x + 300.0, 360.0),
        lambda x: np.mod(x + 300.0 + 180.0, 360.0) - 180.0,
        lambda x: np.where(x.ndim, np.mod(x + 300.0, 360.0), x + 300.0),
        lambda x: np.where(x.ndim, x + 300.0 + 3600.0, np.mod(x + 300.0, 360.0)),
    ):
        told, _ = drive(headstock_mpc(precision=precision), references - 300.0, shown=shown)
        np.testing.assert_array_equal(told, plain)


def test_float32_is_near_float64() -> None:
    """The same measurements for both; currents of up to 1 A. The encoder's grid is the same for
    both, and its steps are what a rounding of the estimate would otherwise be enlarged by."""
    one, other = headstock_mpc(), headstock_mpc(precision="float32")
    references, state, worst = sine(1000, amplitude=1.0), np.zeros(4), 0.0
    for controller in (one, other):
        controller.call("reset", {"position": 0.0})
    for k in range(997):
        angle = np.round((PLANT.c @ state)[0] / GRID) * GRID
        given = {"position": angle, "reference": references[k + 1 : k + 4]}
        currents = [float(c.call("step", given)[1]["current"]) for c in (one, other)]
        worst = max(worst, abs(currents[0] - currents[1]))
        state = PLANT.a @ state + PLANT.b[:, 0] * currents[0]
    assert 0.0 < worst < 0.05


def test_the_estimate_tracks_what_is_not_measured() -> None:
    controller = headstock_mpc()
    _, state = drive(controller, sine(800))
    expected = PLANT.a @ state + PLANT.b @ controller.previous - state
    size = np.array([1.0, 1.0, 1e-3, 1e-3])
    assert np.max(np.abs(controller.increment - expected) / size) < 0.1


def ready(**kwargs) -> ServoMpc:
    controller = headstock_mpc(**kwargs)
    assert controller.call("reset", {"position": 0.0})[0] is Status.OK
    return controller


BAD = [
    ("position", np.nan, Status.NOT_FINITE),
    ("position", -np.inf, Status.NOT_FINITE),
    ("position", 36_865.0, Status.OUT_OF_RANGE),
    ("reference", [0.0, np.nan, 0.0], Status.NOT_FINITE),
    ("reference", [0.0, 0.0, np.inf], Status.NOT_FINITE),
    ("reference", [-36_865.0, 0.0, 0.0], Status.OUT_OF_RANGE),
]


@pytest.mark.parametrize(("port", "value", "status"), BAD)
def test_unusable_inputs_are_told_and_take_the_current_away(port, value, status) -> None:
    controller = ready()
    good = {"position": 0.0, "reference": [0.1, 0.2, 0.3]}
    assert controller.call("step", good)[1]["current"] > 100.0
    assert controller.call("step", good | {port: value}) == (status, {"current": 0.0})
    assert controller.call("step", good)[0] is Status.OK


def test_with_a_bound_on_the_change_the_current_goes_to_zero_in_steps() -> None:
    controller = ready(problem=headstock_problem(change=150.0))
    good = {"position": 0.0, "reference": [1.0, 1.0, 1.0]}
    rising = [float(controller.call("step", good)[1]["current"]) for _ in range(4)]
    np.testing.assert_allclose(rising, [150.0, 300.0, 450.0, 600.0], rtol=1e-9)
    bad = good | {"position": np.nan}
    falling = [float(controller.call("step", bad)[1]["current"]) for _ in range(5)]
    np.testing.assert_allclose(falling, [450.0, 300.0, 150.0, 0.0, 0.0], atol=1e-9)


def test_the_axis_may_turn_on_while_nothing_is_measured() -> None:
    """Blind for a second it runs out over more than half a turn; the first measurement after that
    is understood as what it is."""
    controller = ready()
    state, angle = np.zeros(4), 0.0
    for k in range(3500):
        angle = float((PLANT.c @ state)[0])
        target = np.arange(1, 4) * 0.18 + 0.18 * k
        blind = 1000 <= k < 3000
        given = {
            "position": np.nan if blind else angle % 360.0,
            "reference": (target if k < 1000 else target - target[0] + angle) % 360.0,
        }
        status, out = controller.call("step", given)
        assert (status is Status.OK) != blind
        assert abs(controller.drift[0]) <= 180.0
        if k == 1000:
            begin = angle
        before, state = state, PLANT.a @ state + PLANT.b[:, 0] * float(out["current"])
        if k == 3000:
            assert 180.0 < angle - begin < 360.0
            # the pull of friction is not known to a tenth of a degree after a second
            np.testing.assert_allclose(controller.increment, state - before, atol=0.05)
    assert 100.0 < out["current"] < 150.0  # friction at a turn a second takes 126 mA
    expected = PLANT.a @ state + PLANT.b @ controller.previous - state
    assert abs(controller.increment[0] - expected[0]) < 0.05


def test_half_a_turn_on_either_side_is_one_place() -> None:
    """Foreseen at -179.9 degrees and seen at 179.8: an innovation of -0.3, not of 359.7."""
    one, other = ready(), ready()
    one.drift = np.array([-179.9])
    other.drift = np.array([0.3])
    one.call("step", {"position": 179.8, "reference": [179.8] * 3})
    other.call("step", {"position": 0.0, "reference": [0.0] * 3})
    np.testing.assert_allclose(one.increment, other.increment, rtol=1e-9)


def test_before_reset_and_after_a_refused_one_there_is_no_current() -> None:
    controller = headstock_mpc()
    given = {"position": 0.0, "reference": [1.0, 1.0, 1.0]}
    assert controller.call("step", given) == (Status.NOT_READY, {"current": 0.0})
    assert controller.call("reset", {"position": np.nan})[0] is Status.NOT_FINITE
    assert controller.call("step", given)[0] is Status.NOT_READY
    controller.call("reset", {"position": 10.0})
    assert controller.call("reset", {"position": 1e9})[0] is Status.OUT_OF_RANGE
    assert controller.call("step", given)[0] is Status.NOT_READY


def test_a_bound_on_the_position_is_kept_or_told() -> None:
    """(12) at 1 degree: the reference goes beyond, the axis does not; started beyond with speed,
    nothing can help."""
    problem = headstock_problem(trajectory=8, position=1.0)
    controller = headstock_mpc(problem=problem, turn=0.0)
    controller.call("reset", {"position": 0.0})
    state, reached = np.zeros(4), []
    for k in range(600):
        angle = float((PLANT.c @ state)[0])
        reached.append(angle)
        wanted = np.minimum(0.01 * (k + np.arange(1, 9)), 1.5)
        status, out = controller.call("step", {"position": angle, "reference": wanted})
        assert status is Status.OK
        state = PLANT.a @ state + PLANT.b[:, 0] * float(out["current"])
    assert max(reached) == pytest.approx(1.0, abs=1e-3)
    assert controller.call("step", {"position": 30.0, "reference": wanted}) == (
        Status.INFEASIBLE,
        {"current": 0.0},
    )


DESIGNS = {
    (name, turn): headstock_design(precision=name, turn=turn)
    for name in PRECISIONS
    for turn in (0.0, 360.0)
}
MOVES = {name: SolvedMove(headstock_problem(), p) for name, p in PRECISIONS.items()}
NUMBERS = st.one_of(
    st.floats(-400.0, 400.0), st.sampled_from([np.nan, np.inf, -np.inf, 1e30, 36_864.0, -36_864.0])
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    precision=st.sampled_from(["float32", "float64"]),
    turn=st.sampled_from([0.0, 360.0]),
    calls=st.lists(st.tuples(NUMBERS, st.lists(NUMBERS, min_size=3, max_size=3)), max_size=25),
)
def test_whatever_comes_in_the_current_is_within_its_bounds(precision, turn, calls) -> None:
    controller = ServoMpc(DESIGNS[precision, turn], MOVES[precision])
    controller.call("reset", {"position": 0.0})
    for position, reference in calls:
        status, out = controller.call("step", {"position": position, "reference": reference})
        assert abs(out["current"]) <= 1000.0
        usable = np.all(np.abs([position, *reference]) <= 36_864.0)
        assert (status is Status.OK) == bool(usable)
        for values in (controller.increment, controller.drift, controller.last):
            assert np.all(np.isfinite(values))
        assert not turn or abs(controller.drift[0]) <= 180.0
        bound = controller.design.filter.increment_bound.astype(controller.precision.dtype)
        assert np.all(np.abs(controller.increment) <= bound)
        # looked up without another look at it
        assert np.max(np.abs(controller.theta)) <= controller.design.parameter_bound


def test_the_declaration_names_what_the_step_takes_and_gives() -> None:
    design = headstock_design()
    declaration = ServoMpc(design, SolvedMove(design.problem, FLOAT64)).declaration
    step = declaration.operation("step")
    assert [port.name for port in step.inputs] == ["position", "reference"]
    assert step.inputs[1].size == 3
    assert (step.outputs[0].low, step.outputs[0].high) == (-1000.0, 1000.0)
    shapes = {table.name: table.values.shape for table in declaration.tables}
    assert shapes["gain_state"] == (1, 4)
    assert "change_low" not in shapes


@pytest.mark.parametrize(
    ("problem", "turn", "key"),
    [
        (headstock_problem(limit=np.inf), 0.0, "input"),
        (headstock_problem(position=1.0), 360.0, "signal"),
        (headstock_problem(), 0.5, "turn"),
    ],
)
def test_designs_that_cannot_be_are_refused(problem: TrackingQp, turn: float, key: str) -> None:
    found = headstock_design().filter
    with pytest.raises(DesignError) as caught:
        ServoMpcDesign("axis", FLOAT64, problem, found, 1000.0, turn)
    assert caught.value.key == key


def test_two_axes_that_pull_at_each_other_are_one_controller() -> None:
    """Two inputs, two outputs, each axis an integrator of its speed; both reach their places, one
    of them across the end of a turn, and no input leaves its own bounds."""
    a = np.eye(4)
    a[0, 2] = a[1, 3] = 0.1
    a[2:, 2:] = [[0.9, 0.05], [-0.04, 0.8]]
    b = np.array([[0.0, 0.0], [0.0, 0.0], [0.5, 0.1], [-0.1, 0.4]])
    plant = Sampled(a, b, np.eye(2, 4), 0.01)
    horizons = Horizons(25, 2, 3)
    weights = Weights.constant([50.0, 80.0], [1.0, 2.0], plant, horizons)
    limits = Bounds([-3.0, -5.0], [4.0, 6.0])
    problem = tracking_qp(plant, horizons, "first_order", weights, Constraints(limits))
    noise = Noise(np.full(2, 0.1), np.full(4, 0.01), np.full(2, 0.01))
    found = design_filter(plant, noise, [180.0, 180.0], limits.upper - limits.lower)
    design = ServoMpcDesign("axes", FLOAT64, problem, found, 360.0, 360.0)
    controller = ServoMpc(design, SolvedMove(problem, FLOAT64))
    state, target = np.array([350.0, 20.0, 0.0, 0.0]), np.array([10.0, 5.0])
    controller.call("reset", {"position": state[:2] % 360.0})
    currents = []
    for _ in range(400):
        given = {"position": state[:2] % 360.0, "reference": np.tile(target, 2)}
        status, out = controller.call("step", given)
        assert status is Status.OK
        currents.append(out["current"])
        state = a @ state + b @ currents[-1]
    np.testing.assert_allclose(state[:2], [370.0, 5.0], atol=1e-3)
    np.testing.assert_allclose(np.max(currents, axis=0)[0], 4.0)
    assert np.all((np.array(currents) >= limits.lower) & (np.array(currents) <= limits.upper))
    step = controller.declaration.operation("step")
    assert (step.inputs[0].size, step.inputs[1].size, step.outputs[0].size) == (2, 4, 2)
    assert controller.call("step", {"position": [0.0, np.nan], "reference": np.zeros(4)})[0] is (
        Status.NOT_FINITE
    )
