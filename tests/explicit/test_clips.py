"""The clip identity with and without a tree, where it holds and where it is refused; the choice."""

from dataclasses import replace

import numpy as np
import pytest
from explicit_problems import LIMIT_MA, double_integrator, random_program, servo_drive
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import first_moves

from servogen.explicit.choose import choose
from servogen.explicit.clip_laws import MOST_PATTERNS, prove_clips
from servogen.explicit.clips import RecursiveClips, recursive_clips, without_first_bounds
from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree
from servogen.explicit.lookup import TreeLookup, count_clips, evaluate_clips, tree_lookup
from servogen.explicit.tolerances import PROVED_LAW
from servogen.qp.parametric import ParametricQP, parametric_qp


def box(seed: int, n: int, p: int, first_move: int) -> ParametricQP:
    """Any convex cost, bounds of any place and width."""
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(n, n))
    middle = generator.normal(size=n)
    half = generator.uniform(0.1, 2.0, n)
    return parametric_qp(
        root @ root.T + 0.05 * np.eye(n), generator.normal(size=(n, p)),
        constant=generator.normal(size=n), lower=middle - half, upper=middle + half,
        first_move=first_move,
    )  # fmt: skip


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), p=st.integers(1, 7), nu=st.integers(1, 3)
)
def test_recursive_clips_are_the_optimum(seed: int, n: int, p: int, nu: int) -> None:
    """One and several first moves, more and fewer parameters than variables."""
    problem = box(seed, n, p, min(n, nu))
    theta = np.random.default_rng(seed).normal(size=(60, p)) * 10.0 ** (np.arange(60) % 4)[:, None]
    clips = recursive_clips(problem)
    found = evaluate_clips(clips, theta)
    np.testing.assert_allclose(found, first_moves(problem, theta), atol=1e-7)
    steps = sum(2 ** (n - 1 - j) for j in range(min(n, nu)))
    assert clips.index.size == steps
    count = count_clips(clips)
    assert count.comparisons == 2 * (steps + (min(n, nu) if clips.rounds else 0))
    assert count.multiply_adds == n * p + n * steps + min(n, nu)


@pytest.mark.parametrize("moves", [2, 3, 4])
def test_count_of_the_servos_recursive_form(moves: int) -> None:
    """2^(H_u - 1) clips and H_u 2^(H_u - 1) multiply-adds, the coordinates and the scale aside."""
    problem = servo_drive(moves)
    count = count_clips(recursive_clips(problem))
    assert count.comparisons == 2 * 2 ** (moves - 1)
    own = count.multiply_adds - moves * problem.parameters - 1
    assert own == moves * 2 ** (moves - 1)


def test_clip_tree_with_state_limits() -> None:
    """The identity needs bounds on the first move alone; the other constraints may be anything."""
    problem = double_integrator(5)
    relaxed, bounds = without_first_bounds(problem)
    solution = solve(relaxed, 500)
    assert len(solution.regions) < 21
    lookup = tree_lookup(solution, grow_tree(solution, work=100), bounds)
    theta = np.random.default_rng(3).uniform(-5.0, 5.0, (2000, 2))
    wanted = first_moves(problem, theta)
    inside = ~np.isnan(wanted)
    np.testing.assert_allclose(lookup.evaluate(theta)[inside], wanted[inside], atol=1e-9)


def test_identity_is_refused_where_it_fails() -> None:
    with pytest.raises(ExplicitError, match="clip of a vector"):
        without_first_bounds(box(1, 3, 3, 2))
    with pytest.raises(ExplicitError, match="bound on the first move alone"):
        without_first_bounds(parametric_qp(np.eye(2), np.eye(2), lower=[-np.inf, -1.0]))
    with pytest.raises(ExplicitError, match="no other constraint"):
        recursive_clips(random_program(1, 2, 2, 3))
    with pytest.raises(ExplicitError, match="two finite bounds"):
        recursive_clips(parametric_qp(np.eye(2), np.eye(2), lower=[-1.0, -np.inf]))
    with pytest.raises(ExplicitError, match="at most 12"):
        recursive_clips(box(1, 13, 2, 1))


def test_clip_of_two_moves_together_is_not_the_optimum() -> None:
    """Why several first moves are refused: the refused thing, done by hand, is wrong."""
    problem = box(5, 3, 3, 2)
    free = parametric_qp(
        problem.hessian, problem.linear, constant=problem.constant,
        lower=np.where(np.arange(3) < 2, -np.inf, problem.lower),
        upper=np.where(np.arange(3) < 2, np.inf, problem.upper), first_move=2,
    )  # fmt: skip
    theta = np.random.default_rng(1).normal(size=(200, 3)) * 3.0
    clipped = np.clip(solve(free, 10).first_move(theta), problem.lower[:2], problem.upper[:2])
    assert np.max(np.abs(clipped - first_moves(problem, theta))) > 1e-2


def test_tree_of_a_box_of_parameters_is_wrong_outside_and_the_clips_are_not() -> None:
    """Why the servo's lookup is built on the whole space, and clipped."""
    inside, everywhere = servo_drive(3, inside_box=True), servo_drive(3)
    generator = np.random.default_rng(2)
    bounds = inside.domain_bounds[:8]
    theta = generator.uniform(-1.0, 1.0, (2000, 8)) * bounds
    solution = solve(everywhere, 100)
    theta = np.vstack([theta, generator.uniform(-3.0, 3.0, (2000, 3)) @ np.linalg.pinv(
        solution.image.matrix).T * 50.0])  # fmt: skip
    wanted = first_moves(everywhere, theta)
    boxed = solve(inside, 100)
    lookup = tree_lookup(boxed, grow_tree(boxed, work=0))
    free = np.full(1, np.inf)  # with its laws clipped this one happens to be right here
    unclipped = replace(lookup, lower=-free, upper=free).evaluate(theta) - wanted
    assert np.max(np.abs(unclipped)) > LIMIT_MA
    right = evaluate_clips(recursive_clips(everywhere), theta) - wanted
    assert np.max(np.abs(right)) < 1e-6


@pytest.mark.parametrize("form", ["recursive", "law tree", "clip tree", "half clip tree"])
def test_float32_is_off_by_rounding_alone(form: str) -> None:
    """The error is a few roundings of the terms that eta is summed from, however far away."""
    problem = servo_drive(3)
    relaxed, bounds = without_first_bounds(problem)
    if form == "law tree":
        solution = solve(problem, 100)
        lookup = tree_lookup(solution, grow_tree(solution, work=0))
    elif form != "recursive":
        solution = solve(relaxed, 100)
        tree = grow_tree(solution, work=0, mirror=1 if form.startswith("half") else -1)
        lookup = tree_lookup(solution, tree, bounds)
    generator = np.random.default_rng(7)
    half = np.array([1.0, 1.0, 0.01, 0.01, LIMIT_MA, 10.0, 10.0, 10.0])
    theta = (
        generator.uniform(-1.0, 1.0, (20000, 8))
        * half
        * 10.0 ** generator.uniform(-4.0, 2.0, (20000, 1))
    )
    theta = theta.astype(np.float32).astype(np.float64)
    clips = recursive_clips(problem)
    wanted = evaluate_clips(clips, theta)
    if form == "recursive":
        found = evaluate_clips(clips, theta, np.float32)
    else:
        found = lookup.evaluate(theta, np.float32)
    terms = np.max(np.abs(theta[:, None, :] * clips.matrix[None]), axis=(1, 2))
    allowed = 40.0 * np.finfo(np.float32).eps * (1.0 + terms) * LIMIT_MA
    assert np.all(np.abs(found - wanted)[:, 0] <= allowed)
    assert np.max(np.abs(found)) <= LIMIT_MA


def test_choice_for_the_servo() -> None:
    choice = choose(servo_drive(3), 100)
    count = choice.chosen.count
    assert count is not None
    assert count.multiply_adds <= 40
    assert count.comparisons <= 12
    assert count.work == min(form.count.work for form in choice.forms if form.count)
    assert choice.chosen.name in choice.reason
    names = [form.name for form in choice.forms]
    assert {"recursive clips", "clip tree", "law tree"} <= set(names)
    for form in choice.forms:
        theta = np.random.default_rng(1).normal(size=(300, 8)) * 0.01
        wanted = first_moves(servo_drive(3), theta)
        if isinstance(form.lookup, TreeLookup):
            np.testing.assert_allclose(form.lookup.evaluate(theta), wanted, atol=1e-7)
        elif isinstance(form.lookup, RecursiveClips):
            np.testing.assert_allclose(evaluate_clips(form.lookup, theta), wanted, atol=1e-7)


def test_choice_without_a_box() -> None:
    """State limits leave the trees; why the recursive form is out is said."""
    choice = choose(double_integrator(4), 500, work=200)
    out = next(form for form in choice.forms if form.name == "recursive clips")
    assert out.lookup is None
    assert "no other constraint" in out.note
    assert "tree" in choice.chosen.name
    several = choose(random_program(2, 2, 2, 3, first_move=2), 500, work=50)
    assert several.chosen.name == "law tree"


def test_coordinates_are_folded_where_that_is_less() -> None:
    """Two parameters, two coordinates: the tree reads theta itself."""
    solution = solve(double_integrator(4), 500)
    tree = grow_tree(solution, work=0)
    lookup = tree_lookup(solution, tree)
    assert lookup.matrix.shape == (0, 2)
    assert lookup.count.multiply_adds == 2 * tree.depth + 2
    servo = solve(servo_drive(3), 100)
    assert tree_lookup(servo, grow_tree(servo, work=0)).matrix.shape == (3, 8)


CLIPS = {
    "servo": servo_drive(3),
    "servo, four moves": servo_drive(4, 4),
    "one": box(1, 1, 2, 1),
    "two moves": box(2, 4, 3, 2),
    "all moves": box(3, 3, 2, 3),
    "few parameters": box(4, 4, 1, 1),
}
TABLES = ("matrix", "offset", "coefficients", "half", "middle", "lower", "upper")


@pytest.mark.parametrize("name", CLIPS)
def test_numbers_of_the_clips_are_proved_and_any_other_is_not(name: str) -> None:
    problem = CLIPS[name]
    clips = recursive_clips(problem)
    found = prove_clips(problem, clips)
    assert found.error < 1e-12
    assert (found.patterns, found.complete) == (3**problem.variables, True)
    for table in TABLES:
        numbers = getattr(clips, table)
        for place in np.ndindex(numbers.shape):
            if table == "coefficients" and numbers[place] == 0.0:
                continue  # of a variable that is free in that step
            other = numbers.copy()
            other[place] += 1e-5 * np.max(np.abs(numbers), initial=1e-3)
            assert prove_clips(problem, replace(clips, **{table: other})).error > PROVED_LAW
            other[place] = np.nan
            assert prove_clips(problem, replace(clips, **{table: other})).error == np.inf


def test_steps_of_the_clips_in_another_order_are_refuted() -> None:
    problem = CLIPS["servo, four moves"]
    clips = recursive_clips(problem)
    for s in range(clips.index.size - 1):
        index, steps = clips.index.copy(), clips.coefficients.copy()
        index[[s, s + 1]], steps[[s, s + 1]] = index[[s + 1, s]], steps[[s + 1, s]]
        other = replace(clips, index=index, coefficients=steps)
        assert prove_clips(problem, other).error > PROVED_LAW
    assert prove_clips(problem, replace(clips, moves=clips.moves - 1)).error > PROVED_LAW


def test_of_many_patterns_some_are_asked() -> None:
    problem = servo_drive(7, 7)
    found = prove_clips(problem, recursive_clips(problem))
    assert found.error < PROVED_LAW
    assert (found.patterns, found.complete) == (MOST_PATTERNS, False)
