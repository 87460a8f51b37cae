"""The controller step by step: statuses, safe outputs, its filter, odd contours."""

import numpy as np
import pytest
from contour_machine import OUTPUT, STATIONARY, design, of_case
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_table_design import direction_gains, tabulate
from servogen.controllers.design import Status, Value
from servogen.plants.machining_centre import machining_centre
from servogen.plants.statespace import Discrete
from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.systems.contour_loop import run_contour
from servogen.systems.contour_motion import ContourMotion, circle

PLAIN = Discrete(np.array([[1.0]]), np.array([1.1e-5]), np.array([1.0]), 0.0005)
REST = np.zeros(2)
AHEAD = np.outer(np.arange(11), [2e-5, 1e-5]).ravel()


def ready(controller: ContourLq | None = None) -> ContourLq:
    made = controller or ContourLq(of_case("IV"))
    assert made.call("reset", {"position": REST})[0] is Status.OK
    return made


def step(
    controller: ContourLq, position: np.ndarray = REST, reference: np.ndarray = AHEAD
) -> tuple[Status, dict[str, Value]]:
    return controller.call("step", {"position": position, "reference": reference})


def test_before_reset_nothing_moves() -> None:
    made = ContourLq(of_case("II"))
    for operation, extra in (("step", {}), ("follow", {"hidden": np.zeros(6)})):
        status, out = made.call(operation, {"position": REST, "reference": AHEAD, **extra})
        assert status is Status.NOT_READY
        assert not np.any(out["command"])
    assert made.call("reset", {"position": np.array([0.0, np.nan])})[0] is Status.NOT_FINITE
    assert step(made)[0] is Status.NOT_READY


@pytest.mark.parametrize(
    ("value", "status"),
    [(np.nan, Status.NOT_FINITE), (-np.inf, Status.NOT_FINITE), (0.06, Status.OUT_OF_RANGE)],
)
def test_what_cannot_be_used_stops_the_axes(value: float, status: Status) -> None:
    """And only for as long as it comes; a usable measurement beside it is not lost."""
    made, twin = ready(), ready()
    bad = AHEAD.copy()
    bad[13] = value
    found, out = step(made, np.array([3e-6, 0.0]), bad)
    assert (found, out["known"], out["limited"]) == (status, 0, 0)
    assert not np.any(out["command"])
    assert made.filters[0].last == 3e-6
    assert step(made)[0] is Status.OK
    found, out = step(twin, np.array([0.0, value]))
    assert found is status
    assert not np.any(out["command"])
    assert step(twin)[0] is Status.OK
    hidden = np.zeros(6)
    hidden[4] = value if not np.isfinite(value) else 2.1
    found, out = made.call("follow", {"position": REST, "hidden": hidden, "reference": AHEAD})
    assert found is status
    assert not np.any(out["command"])


def test_a_machine_that_stands_has_no_direction_yet() -> None:
    made = ready()
    status, out = step(made, REST, np.zeros(22))
    assert (status, out["known"]) == (Status.PRIMING, 0)
    assert not np.any(out["command"])
    assert step(made)[0] is Status.OK


def test_a_point_out_of_reach_is_approached_at_the_limit() -> None:
    found, out = step(ready(), REST, AHEAD + 0.01)
    assert found is Status.OK
    assert out["limited"] == 2
    assert np.array_equal(out["command"], [20.0, 20.0])


@pytest.mark.parametrize("precision", [FLOAT64, FLOAT32])
@pytest.mark.parametrize("orders", [(3, 5, 1), (1, 1), (1, 3)])
def test_any_axes_follow_a_helix(orders: tuple[int, ...], precision: Precision) -> None:
    """Three of them, each of its own order, and such as are an integrator alone."""
    plants = {1: PLAIN, **{axis.order: axis for axis in machining_centre()}}
    axes = tuple(plants[n] for n in orders)
    made = design(1.2, 20.0, OUTPUT, precision=precision, axes=axes)
    motion = helix(len(axes))
    found = run_contour(made, ContourLq(made), axes, motion, 200)
    assert np.all(found.status == Status.OK)
    assert 1e6 * found.contour_rms_m(60) < 0.8
    assert 1e6 * found.tracking_rms_m(60) > 5.0  # beta has the errors go along the contour
    seen = run_contour(made, ContourLq(made), axes, motion, 200, encoder_m=0.1e-6)
    assert 1e6 * seen.contour_rms_m(60) < 1.0


def helix(axes: int) -> ContourMotion:
    """A circle, and rising where there is a third axis; errors are those of the circle."""
    flat = circle(1e-3, 0.05, 0.0005, 220)
    rise = 1e-5 * np.arange(220)[:, None] * np.ones(axes - 2)
    return ContourMotion(np.hstack([flat.points, rise]), flat.distance)


def test_the_filter_finds_the_state() -> None:
    """From a wrong start, under commands that it is told of."""
    made, axes = ready(ContourLq(of_case("I"))), machining_centre()
    states = [np.array([1e-6, -2e-6, 0.0]), np.zeros(5)]
    for k in range(200):
        position = np.array([axis.c @ x for axis, x in zip(axes, states, strict=True)])
        path = 5e-4 * np.sin(0.02 * np.arange(k, k + 11))
        _, out = step(made, position, np.column_stack([path, 0.0 * path]).ravel())
        command = np.asarray(out["command"])
        states = [axis.a @ x + axis.b * u for axis, x, u in zip(axes, states, command, strict=True)]
    for filtered, axis, x in zip(made.filters, made.design.axes, states, strict=True):
        own = axis.model.from_state @ x
        assert filtered.last + filtered.ahead == pytest.approx(own[0], abs=1e-10)
        assert np.allclose(filtered.hidden, own[1:], atol=1e-6)
    assert all(0.0 < axis.observer.decay < 0.95 for axis in made.design.axes)


STEPS = np.arange(30)


def kalman_gain(axis: Discrete) -> np.ndarray:
    p, gain = np.zeros((axis.order, axis.order)), np.zeros(axis.order)
    for _ in range(3000):
        p = axis.a @ p @ axis.a.T + 0.01**2 * np.outer(axis.b, axis.b)
        gain = p @ axis.c / (axis.c @ p @ axis.c + (0.8e-6) ** 2 / 12.0)
        p = p - np.outer(gain, axis.c @ p)
    return gain


def test_the_filter_is_kalmans() -> None:
    """Against the covariance recursion run until it stands, in the identified coordinates, on an
    axis that something else moves too."""
    made, axes = ready(ContourLq(of_case("II"))), machining_centre()
    generator = np.random.default_rng(11)
    states = [np.zeros(axis.order) for axis in axes]
    guesses, gains = [x.copy() for x in states], [kalman_gain(axis) for axis in axes]
    for k in range(60):
        position = np.round([axis.c @ x / 0.8e-6 for axis, x in zip(axes, states, strict=True)])
        position = position * 0.8e-6
        command = np.asarray(step(made, position, AHEAD + 2e-5 * k)[1]["command"])
        for a, axis in enumerate(axes):
            guess = guesses[a] + gains[a] * (position[a] - axis.c @ guesses[a])
            guesses[a] = axis.a @ guess + axis.b * command[a]
            pushed = command[a] + generator.normal(0.0, 0.5)
            states[a] = axis.a @ states[a] + axis.b * pushed
            own, found = made.design.axes[a].model.from_state @ guesses[a], made.filters[a]
            assert found.last + found.ahead == pytest.approx(own[0], abs=1e-11)
            assert np.allclose(found.hidden, own[1:], atol=1e-7)


def test_tabulated_gains_are_those_of_the_direction() -> None:
    """On a straight contour those computed on line; at a right corner those of Q_max."""
    made = of_case("II")
    table = tabulate(made, 256, 4)
    turned = AHEAD.reshape(-1, 2).copy()
    turned[5:] = turned[4] + np.outer(np.arange(1, 7), [-1e-5, 2e-5])
    off = np.array([3e-6, -4e-6])
    for path, exact in ((AHEAD.reshape(-1, 2), None), (turned, np.zeros(2))):
        found = np.asarray(step(ready(ContourLq(table)), off, path.ravel())[1]["command"])
        if exact is None:
            wanted = np.asarray(step(ready(ContourLq(made)), off, path.ravel())[1]["command"])
        else:
            gains = direction_gains(made, exact)
            controller = ready(ContourLq(made))
            for axis, where in zip(controller.filters, off, strict=True):
                axis.measure(where)
            given = [
                np.concatenate([path[1:, a] - f.last - f.ahead, [f.last + f.ahead], f.hidden])
                for a, f in enumerate(controller.filters)
            ]
            wanted = gains @ np.concatenate(given)
        assert found == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("form", ["on line", "tabulated", "no contour weight", "integrators"])
def test_what_is_declared_is_what_there_is(form: str) -> None:
    """No empty table or dimension, one name each, and the reference takes and gives those ports."""
    made = of_case("I" if form == "no contour weight" else "II", FLOAT32)
    if form == "tabulated":
        made = tabulate(made, 16, 4)
    if form == "integrators":
        made = design(1.2, 20.0, OUTPUT, precision=FLOAT32, axes=(PLAIN, PLAIN))
    controller = ready(ContourLq(made))
    found = controller.declaration
    named = [table.name for table in found.tables] + [value.name for value in found.constants]
    assert len(set(named)) == len(named)
    assert all(table.values.size for table in found.tables)
    sizes = {dimension.name: dimension.value for dimension in found.dimensions}
    assert all(sizes[f.size] > 0 for f in found.state if f.size)
    assert ("SLIDES" in sizes) == (form in ("on line", "integrators"))
    for name in ("step", "follow"):
        ports = found.operation(name)
        given = {p.name: np.zeros(p.size, dtype=np.float32) for p in ports.inputs}
        _, out = controller.call(name, given)
        assert list(out) == [p.name for p in ports.outputs]
        command = np.asarray(out["command"])
        assert command.dtype == np.float32
        assert command.shape == (ports.outputs[0].size,)
    assert all(axis.hidden.dtype == np.float32 for axis in controller.filters)
    assert all(isinstance(axis.ahead, np.float32) for axis in controller.filters)


CONTOURS = {
    "stop": np.repeat([[0.0, 0.0], [1e-3, 5e-4]], [1, 60], axis=0),
    "repeated": np.repeat(np.outer(np.arange(20), [2e-5, 0.0]), 3, axis=0),
    "corner": np.vstack(
        [np.outer(STEPS, [2e-5, 0.0]), np.column_stack([0.0 * STEPS + 5.8e-4, 2e-5 * STEPS])]
    ),
    "reversal": np.abs(np.arange(-30, 30))[:, None] * np.array([[2e-5, 1e-5]]),
    "needle": np.column_stack([2e-5 * np.abs(np.arange(-30, 30)), 1e-9 * np.arange(60)]),
    "jump": np.repeat([[0.0, 0.0], [0.04, -0.04]], 30, axis=0),
    "nothing": np.zeros((60, 2)),
}


@pytest.mark.parametrize("precision", [FLOAT64, FLOAT32])
@pytest.mark.parametrize("form", ["on line", "tabulated", "stationary"])
@pytest.mark.parametrize("name", CONTOURS)
def test_awkward_contours_are_followed(name: str, form: str, precision: Precision) -> None:
    """In closed loop, finite at every step, and to rest at the end of those that end."""
    made = design(0.25, 15.0, STATIONARY if form == "stationary" else OUTPUT, precision=precision)
    controller = ready(ContourLq(tabulate(made, 16, 4) if form == "tabulated" else made))
    path, axes = CONTOURS[name], machining_centre()
    path = np.vstack([path, np.repeat(path[-1:], 90, axis=0)])
    states = [np.zeros(axis.order) for axis in axes]
    for k in range(len(path) - 11):
        position = np.array([axis.c @ x for axis, x in zip(axes, states, strict=True)])
        with np.errstate(all="raise", under="ignore"):
            status, out = step(controller, position, path[k : k + 11].ravel())
        command = np.asarray(out["command"], dtype=float)
        # one that stands before its jump has no direction until that comes into sight
        stands = name == "nothing" or (name == "jump" and k < 20)
        assert status is (Status.PRIMING if stands else Status.OK)
        assert np.all(np.abs(command) <= 20.0)
        states = [axis.a @ x + axis.b * u for axis, x, u in zip(axes, states, command, strict=True)]
    assert name == "jump" or np.max(np.abs(position - path[-1])) < 3e-6


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 2**31), st.sampled_from([FLOAT32, FLOAT64]), st.booleans())
def test_no_input_makes_a_command_that_is_none(
    seed: int, precision: Precision, whole: bool
) -> None:
    generator = np.random.default_rng(seed)
    controller = ready(ContourLq(design(0.25, 15.0, OUTPUT, precision=precision)))
    odd = [0.0, np.nan, np.inf, -np.inf, 0.05, -0.05, 0.0500001, 1e-30, 1e30, precision.max]
    for _ in range(6):
        given = {
            "position": generator.uniform(-0.05, 0.05, 2),
            "hidden": generator.uniform(-2.0, 2.0, 6),
            "reference": generator.uniform(-0.05, 0.05, 22),
        }
        for values in given.values():
            if generator.random() < 0.4:
                values[generator.integers(values.size)] = generator.choice(odd)
        status, out = controller.call("follow" if whole else "step", given)
        assert np.all(np.abs(np.asarray(out["command"])) <= 20.0)
        assert status <= Status.PRIMING or not np.any(out["command"])
        assert all(np.all(np.isfinite(axis.hidden)) for axis in controller.filters)
