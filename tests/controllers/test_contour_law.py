"""The law: recursion, sliding references and batch least squares are one; coordinates; float32."""

import numpy as np
import pytest
from contour_machine import CASES, OUTPUT, STATIONARY, batch_input, design, of_case, weights
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.contour_axis import axis_model
from servogen.controllers.contour_estimate import wanted_state
from servogen.controllers.contour_law import SlidingLaw
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.contour_recursion import Machine, end_weight, first_input, stationary
from servogen.controllers.contour_tangent import Course, Slide
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.controllers.errors import DesignError
from servogen.controllers.finite_preview import finite_preview
from servogen.plants.machining_centre import machining_centre
from servogen.plants.statespace import Discrete
from servogen.precision import FLOAT32

PLAIN = Discrete(np.array([[1.0]]), np.array([1.1e-5]), np.array([1.0]), 0.0005)


class GivenTangents:
    """In place of a sweep: tangents of any length up to one, as they are."""

    def __init__(self, tangents: np.ndarray, share: float, count: int) -> None:
        along = tangents[:count]
        price = 1.0 - share * np.sum(along**2, axis=1)
        self.slide = Slide(along, price, along, np.ones(count), len(tangents))

    def __call__(self, points: np.ndarray, course: Course) -> tuple[Slide, Course]:
        return self.slide, course


def law_input(
    found: ContourLqDesign, tangents: np.ndarray, state: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    law = SlidingLaw(found)
    law._sweep = GivenTangents(tangents, found.share, found.count)  # type: ignore[assignment]
    given, start = [], 0
    for a, axis in enumerate(found.axes):
        n = axis.model.order
        own = axis.model.from_state @ state[start : start + n]
        given.append(np.concatenate([wanted[:, a] - own[0], own]))
        start += n
    points = np.vstack([wanted[:1], wanted])
    commands, _, _ = law(points, Course(points[0], 0.0 * points[0]), given)
    return np.array(commands)


def recursion_input(
    axes: tuple[Discrete, ...],
    asked: ContourWeights,
    terminal: Terminal,
    tangents: np.ndarray,
    state: np.ndarray,
    wanted: np.ndarray,
    wanted_end: np.ndarray,
) -> np.ndarray:
    q = np.array([asked.output_weight(tangent) for tangent in tangents])
    h = end_weight(axes, asked, terminal, q[-1])
    c = Machine.of(axes).c
    g = -c.T @ q[-1] @ wanted[-1] if terminal is OUTPUT else -h @ wanted_end
    return first_input(Machine.of(axes), asked.control, q, (h, g), state, wanted)


def end_state(axes: tuple[Discrete, ...], wanted: np.ndarray) -> np.ndarray:
    if len(wanted) < 2:
        return np.zeros(sum(axis.order for axis in axes))
    advance = wanted[-1] - wanted[-2]
    found = [wanted_state(axis) for axis in axes]
    return np.concatenate(
        [f.on_position * wanted[-1, a] + f.on_advance * advance[a] for a, f in enumerate(found)]
    )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.integers(0, 2**31),
    st.sampled_from([OUTPUT, STATIONARY]),
    st.sampled_from([2, 3]),
    st.integers(2, 15),
    st.floats(0.1, 10.0),
    st.one_of(st.just(0.0), st.floats(0.1, 40.0)),
)
def test_slides_recursion_and_batch_agree(
    seed: int, terminal: Terminal, p: int, preview: int, tracking: float, contour: float
) -> None:
    """Of axes of orders 3, 5 and 1, for tangents of any direction and length up to one.

    States of a machine that has been moving: what a model of order five makes of numbers drawn at
    random is metres away after ten samples, and the bound is of the inputs.
    """
    generator = np.random.default_rng(seed)
    axes = (*machining_centre(), PLAIN)[:p]
    asked = weights(tracking, contour)
    tangents = generator.normal(size=(preview, p))
    tangents *= (generator.beta(2.0, 0.5, preview) / np.linalg.norm(tangents, axis=1))[:, None]
    wanted = generator.uniform(-0.04, 0.04, p) + np.cumsum(
        generator.normal(0.0, 2e-5, (preview, p)), axis=0
    )
    moving = generator.normal(0.0, 2e-5, p)
    found = [wanted_state(axis) for axis in axes]
    state = np.concatenate(
        [f.on_position * (wanted[0, a] - moving[a]) + f.on_advance * moving[a]
         for a, f in enumerate(found)]
    )  # fmt: skip
    end = end_state(axes, wanted)
    by_batch = batch_input(axes, asked, terminal, tangents, state, wanted, end)
    by_recursion = recursion_input(axes, asked, terminal, tangents, state, wanted, end)
    made = design(tracking, contour, terminal, preview, axes=axes)
    by_slides = law_input(made, tangents, state, wanted)
    # absolute states of 40 mm are multiplied by gains of 1e5 and more in the two oracles, which the
    # law does not do: that is what their rounding is a share of
    scale = 1.0 + float(np.max(np.abs(by_batch)))
    assert np.max(np.abs(by_recursion - by_batch)) < 1e-9 * scale
    assert np.max(np.abs(by_slides - by_batch)) < 1e-9 * scale


@pytest.mark.parametrize("name", CASES)
def test_recursion_and_slides_equal_the_batch_to_1e12(name: str) -> None:
    """At the origin, where nothing cancels, on the paper's own cases."""
    terminal, tracking, contour = CASES[name]
    generator, axes = np.random.default_rng(7), machining_centre()
    for _ in range(10):
        angle = generator.uniform(0.0, np.pi) + np.cumsum(generator.normal(0.0, 0.3, 10))
        tangents = np.column_stack([np.cos(angle), np.sin(angle)])
        wanted = np.cumsum(generator.normal(0.0, 1e-5, (10, 2)), axis=0)
        state = generator.normal(0.0, 1e-5, 8)
        given = (tangents, state, wanted, end_state(axes, wanted))
        asked = weights(tracking, contour)
        exact = batch_input(axes, asked, terminal, *given)
        by_slides = law_input(of_case(name), *given[:3])
        scale = float(np.max(np.abs(exact)))
        assert (
            np.max(np.abs(recursion_input(axes, asked, terminal, *given) - exact)) < 1e-12 * scale
        )
        assert np.max(np.abs(by_slides - exact)) < 1e-12 * scale


def test_pivots_stay_above_the_least_price() -> None:
    """The bound on them changes none: the system is at least the least price."""
    made = design(0.25, 40.0, OUTPUT)
    generator = np.random.default_rng(3)
    for _ in range(50):
        along = generator.normal(size=(10, 2))
        along /= np.linalg.norm(along, axis=1)[:, None]
        matrix = np.eye(10) * (1.0 - made.share)
        for a, axis in enumerate(made.axes):
            matrix = matrix + axis.tables.stiffness * np.outer(along[:, a], along[:, a])
        values = np.linalg.eigvalsh(matrix)
        assert values[0] >= made.least_price * (1.0 - 1e-9)
        assert values[-1] <= 1.0 + 1e-9  # the condition is at most 1 + beta / alpha


def test_without_contour_weight_it_is_the_finite_preview_controller() -> None:
    """Case III: the constant gains of the Riccati equation are the tables."""
    made = of_case("III")
    for plant, axis in zip(machining_centre(), made.axes, strict=True):
        plain = finite_preview(plant, 3.0, 2e-9, 10)
        feedback = axis.tables.first[10:] @ axis.model.from_state
        feedback = feedback - np.sum(axis.tables.first[:10]) * plant.c
        assert np.allclose(axis.tables.first[:10], plain.ahead, rtol=1e-9, atol=1e-6)
        assert np.allclose(
            feedback, -plain.feedback, rtol=1e-8, atol=1e-6 * np.max(np.abs(feedback))
        )
        assert plain.decay < 1.0
    held = finite_preview(machining_centre()[0], 3.0, 2e-9, 10, held=True)
    assert held.ahead[-1] != pytest.approx(
        finite_preview(machining_centre()[0], 3.0, 2e-9, 10).ahead[-1]
    )


def test_the_stationary_solution_solves_its_equation() -> None:
    for plant in machining_centre():
        h = stationary(plant, 15.25, 2e-9)
        b = plant.b[:, None]
        k = np.linalg.solve(b.T @ h @ b + 2e-9, b.T @ h @ plant.a)
        left = plant.a.T @ h @ (plant.a - b @ k) + 15.25 * np.outer(plant.c, plant.c) - h
        assert np.max(np.abs(left)) < 1e-9 * np.max(np.abs(h))


def test_the_appendix_state_moves_at_constant_velocity() -> None:
    """Under the constant input that follows it, for n + 1 samples, from any order."""
    for plant in (*machining_centre(), PLAIN):
        found = wanted_state(plant)
        assert found.condition < 3e3
        n = plant.order
        seen = np.array([plant.c @ np.linalg.matrix_power(plant.a, j) for j in range(n + 1)])
        driven = np.array([0.0, *np.cumsum(seen[:n] @ plant.b)])
        state = 0.003 * found.on_position + 2.5e-5 * found.on_advance
        left = 0.003 + 2.5e-5 * np.arange(n + 1) - seen @ state
        u = left[-1] / driven[-1]
        assert np.max(np.abs(left - driven * u)) < 1e-15
        # m in a sample per unit, of the facts' 0.0226 and 0.0223 m/s
        assert u == pytest.approx(2.5e-5 / 1.12e-5, rel=0.03)


def test_an_axis_whose_outputs_do_not_tell_its_state_is_refused() -> None:
    def pair(apart: float) -> Discrete:
        poles = np.diag([1.0, 0.5, 0.5 + apart])
        return Discrete(poles, np.array([1e-5, 1e-5, -1e-5]), np.ones(3), 0.0005)

    assert 1e3 < wanted_state(pair(1e-3)).condition < 1e8
    with pytest.raises(DesignError, match=r"a condition below 1e\+08"):
        wanted_state(pair(1e-9))


def test_coordinates_hold_the_axis_whole() -> None:
    for plant in (*machining_centre(), PLAIN):
        model = axis_model(plant, 20.0, 0.05)
        assert np.allclose(model.to_state @ model.from_state, np.eye(plant.order), atol=1e-9)
        assert np.allclose(plant.c @ model.to_state, np.eye(plant.order)[0], atol=1e-12)
        state, back = np.zeros(plant.order), np.zeros(plant.order)
        generator = np.random.default_rng(1)
        for _ in range(200):
            u = 20.0 * np.sign(generator.normal())
            state, back = plant.a @ state + plant.b * u, model.a @ back + model.b * u
            assert np.max(np.abs(back[1:]), initial=0.0) <= 1.0
        assert np.allclose(model.from_state @ state, back, atol=1e-9)
        # at the end of its reach the position moves nothing by more than a hundredth of its range
        assert np.max(np.abs(model.drift)) * model.reach < 0.01


def test_single_precision_does_not_lose_the_place() -> None:
    """40 mm from the origin the command differs by no more than at it."""
    off = []
    for where in (0.0, 0.04):
        generator, worst = np.random.default_rng(5), 0.0
        for _ in range(20):
            angle = generator.uniform(0.0, np.pi, 10)
            tangents = np.column_stack([np.cos(angle), np.sin(angle)])
            change = np.cumsum(generator.normal(0.0, 2e-5, (10, 2)), axis=0)
            hidden = generator.normal(0.0, 0.02, 6)
            commands = []
            for precision in (None, FLOAT32):
                made = of_case("II") if precision is None else of_case("II", precision)
                law = SlidingLaw(made)
                law._sweep = GivenTangents(tangents.astype(made.precision.dtype), made.share, 10)  # type: ignore[assignment]
                given = [
                    np.concatenate([change[:, a], [where], part]).astype(made.precision.dtype)
                    for a, part in enumerate((hidden[:2], hidden[2:]))
                ]
                zero = np.zeros(2, dtype=made.precision.dtype)
                commands.append(np.array(law(np.zeros((11, 2)), Course(zero, zero), given)[0]))
            worst = max(worst, float(np.max(np.abs(commands[0] - commands[1]))))
        off.append(worst)
    assert off[0] < 1e-4  # of some units: 1e-5 of 10 nm a sample
    assert off[1] < 3.0 * off[0]


@pytest.mark.parametrize(
    ("key", "make"),
    [
        ("preview", lambda: design(1.0, 1.0, STATIONARY, 1)),
        ("preview", lambda: design(1.0, 1.0, OUTPUT, 0)),
        ("axes", lambda: design(1.0, 1.0, OUTPUT, axes=machining_centre()[:1])),
        ("tracking_weight", lambda: weights(0.0, 1.0)),
        ("contour_weight", lambda: weights(1.0, -1.0)),
        ("contour_weight", lambda: design(1e-4, 30.0, OUTPUT, precision=FLOAT32)),
        ("contour_weight", lambda: design(1e-12, 30.0, OUTPUT)),
        ("control_weight", lambda: ContourWeights(1.0, 1.0, 0.0)),
        ("z.a", lambda: design(1.0, 1.0, OUTPUT, axes=(PLAIN, PLAIN, doubled()))),
        ("y.b", lambda: design(1.0, 1.0, OUTPUT, axes=(PLAIN, still()))),
    ],
)
def test_what_cannot_be_designed_is_refused(key: str, make: object) -> None:
    with pytest.raises(DesignError) as refused:
        make()  # type: ignore[operator]
    assert refused.value.key == key


def doubled() -> Discrete:
    """Two integrators: one is the position, the other does not decay."""
    return Discrete(
        np.array([[1.0, 1e-3], [0.0, 1.0]]), np.array([0.0, 1e-5]), np.eye(2)[0], 0.0005
    )


def still() -> Discrete:
    return Discrete(np.array([[1.0]]), np.array([0.0]), np.array([1.0]), 0.0005)


def test_what_float32_does_not_carry_float64_may() -> None:
    with pytest.raises(DesignError, match=r"2.1e\+05 times tracking_weight .*; float64 carries it"):
        design(1e-4, 30.0, OUTPUT, precision=FLOAT32)
    with pytest.raises(DesignError, match=r"in float32$"):
        design(1e-13, 30.0, OUTPUT, precision=FLOAT32)
    assert design(1e-4, 30.0, OUTPUT).count == 10
    assert design(1e-4, 0.0, OUTPUT, precision=FLOAT32).count == 0
