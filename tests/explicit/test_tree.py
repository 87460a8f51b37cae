"""Search trees: their figures, their proofs, and proofs that notice a wrong tree."""

from dataclasses import replace

import numpy as np
import pytest
from explicit_problems import LIMIT_MA, double_integrator, random_program, servo_drive

from servogen.explicit import facet_parts
from servogen.explicit.clips import without_first_bounds
from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree, is_odd
from servogen.explicit.lookup import tree_lookup
from servogen.explicit.prove import prove_tree, rounding_slack
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree, descend
from servogen.qp.parametric import parametric_qp
from servogen.sets.errors import SetError


@pytest.fixture(scope="module")
def servo_inside() -> ExplicitSolution:
    return solve(servo_drive(3, inside_box=True), 100)


@pytest.fixture(scope="module")
def relaxed() -> ExplicitSolution:
    return solve(without_first_bounds(servo_drive(3))[0], 100)


@pytest.fixture(scope="module")
def limited() -> ExplicitSolution:
    return solve(double_integrator(5), 500)


def proved(tree: Tree, solution: ExplicitSolution) -> None:
    proof = prove_tree(tree, solution)
    assert proof.holds()
    assert proof.wrong == ()
    assert proof.unreached == 0
    assert proof.leaves == tree.leaves
    assert proof.arrivals >= len(solution.regions)


def test_law_tree_of_the_servo_inside_the_box(servo_inside: ExplicitSolution) -> None:
    greedy = grow_tree(servo_inside, work=0)
    assert greedy.nodes <= 79
    assert greedy.depth <= 7
    proved(greedy, servo_inside)
    better = grow_tree(servo_inside, work=800)
    assert (better.depth, better.nodes) < (greedy.depth, greedy.nodes)
    proved(better, servo_inside)


def test_law_tree_of_the_servo_everywhere() -> None:
    solution = solve(servo_drive(3), 100)
    tree = grow_tree(solution, work=0)
    assert tree.nodes <= 91
    assert tree.depth <= 7
    proved(tree, solution)


def test_clip_tree_of_the_servo(relaxed: ExplicitSolution) -> None:
    assert len(relaxed.regions) == 9
    assert relaxed.findings.closed_form
    tree = grow_tree(relaxed)
    assert tree.nodes <= 27
    assert tree.depth <= 4
    proved(tree, relaxed)


@pytest.mark.parametrize("mirror", [0, 1, 2])
def test_half_trees_of_the_servo(relaxed: ExplicitSolution, mirror: int) -> None:
    tree = grow_tree(relaxed, mirror=mirror)
    assert tree.nodes <= (27, 17, 17)[mirror]
    proved(tree, relaxed)


def test_tree_with_state_limits(limited: ExplicitSolution) -> None:
    tree = grow_tree(limited, work=500)
    assert tree.depth == 5
    proved(tree, limited)
    half = grow_tree(limited, work=500, mirror=0)
    assert half.nodes < tree.nodes
    proved(half, limited)


@pytest.mark.parametrize("seed", range(6))
def test_random_trees_give_the_solutions_moves(seed: int) -> None:
    problem = random_program(seed, 3, (1, 2, 3)[seed % 3], 4, first_move=2)
    solution = solve(problem, 500)
    tree = grow_tree(solution, work=50)
    proved(tree, solution)
    theta = np.random.default_rng(seed).uniform(-2.0, 2.0, (500, problem.parameters))
    wanted = solution.first_move(theta)
    found = tree_lookup(solution, tree).evaluate(theta)
    inside = ~np.isnan(wanted[:, 0])
    np.testing.assert_allclose(found[inside], wanted[inside], atol=1e-9)


def test_wrong_trees_are_noticed(limited: ExplicitSolution) -> None:
    """A leaf exchanged, a child exchanged, a plane moved by a millionth of a bound."""
    tree = grow_tree(limited, work=0)
    at, side = np.argwhere(tree.children < 0)[3]
    children = tree.children.copy()
    children[at, side] = -1 - (-1 - children[at, side] + 1) % limited.laws.count
    assert not prove_tree(replace(tree, children=children), limited).holds()
    children = tree.children.copy()
    children[0] = children[0, ::-1]
    assert not prove_tree(replace(tree, children=children), limited).holds()
    for node in range(tree.inner):
        offsets = tree.offsets.copy()
        offsets[node] += 1e-6
        assert not prove_tree(replace(tree, offsets=offsets), limited).holds()


def test_every_leaf_of_a_tree_matters(relaxed: ExplicitSolution) -> None:
    tree = grow_tree(relaxed, work=0)
    for at, side in np.argwhere(tree.children < 0):
        children = tree.children.copy()
        children[at, side] = -1 - (-1 - children[at, side] + 1) % relaxed.laws.count
        assert not prove_tree(replace(tree, children=children), relaxed).holds()


def test_rounded_tables_are_proved_within_a_bound(limited: ExplicitSolution) -> None:
    """float32 tables of the double integrator: off by rounding, and by no more than is proved."""
    tree = grow_tree(limited, work=0).rounded(np.float32)
    reach = np.full(2, np.max(np.abs(limited.program.domain_bounds)))
    slack = rounding_slack(tree, reach, 1e-7 * reach)
    laws = limited.laws
    rounded = (laws.gains.astype(np.float32), laws.offsets.astype(np.float32))
    proof = prove_tree(tree, limited, slack=slack, laws=rounded)
    assert 0.0 < proof.worst_difference < 1e-4
    assert proof.holds(allowed=1e-4)
    assert not proof.holds(allowed=0.0)
    moved = replace(tree, offsets=tree.offsets + np.float32(1e-2))
    worse = prove_tree(moved, limited, slack=slack, laws=rounded)
    assert worse.worst_difference > 10.0 * proof.worst_difference
    theta = np.random.default_rng(1).uniform(-5.0, 5.0, (4000, 2))
    wanted = limited.first_move(theta)
    found = tree_lookup(limited, grow_tree(limited, work=0)).evaluate(theta, np.float32)
    inside = ~np.isnan(wanted)
    assert np.max(np.abs(found - wanted)[inside]) <= proof.worst_difference + 1e-5


def test_rounded_clip_tree_inside_the_box(servo_inside: ExplicitSolution) -> None:
    """The clip leaves in float32. In the corners of the box, fifty thousand bounds out, the proof
    allows for errors that do not meet in one parameter; near the origin it is close.
    """
    relaxed, bounds = without_first_bounds(servo_drive(3, inside_box=True))
    solution = solve(relaxed, 100)
    tree = grow_tree(solution, work=0).rounded(np.float32)
    corners = np.abs(solution.image.matrix) @ relaxed.domain_bounds[:8]
    slack = rounding_slack(tree, corners, 1e-7 * corners)
    laws = (solution.laws.gains.astype(np.float32), solution.laws.offsets.astype(np.float32))
    proof = prove_tree(tree, solution, slack=slack, clip=bounds, laws=laws)
    assert 0.0 < proof.worst_difference < LIMIT_MA
    theta = np.random.default_rng(4).uniform(-1.0, 1.0, (20000, 8)) * relaxed.domain_bounds[:8]
    theta = theta.astype(np.float32).astype(np.float64)
    exact = tree_lookup(solution, grow_tree(solution, work=0), bounds)
    off = exact.evaluate(theta, np.float32) - exact.evaluate(theta)
    assert np.max(np.abs(off)) <= proof.worst_difference
    small = (np.vstack([np.eye(3), -np.eye(3)]), np.full(6, 3.0))
    near = prove_tree(
        tree, solution, slack=rounding_slack(tree, np.full(3, 3.0), np.full(3, 1e-6)),
        within=small, clip=bounds, laws=laws,
    )  # fmt: skip
    assert 0.0 < near.worst_difference < 0.1


def test_same_input_same_tree(servo_inside: ExplicitSolution) -> None:
    again = solve(servo_drive(3, inside_box=True), 100)
    first, second = grow_tree(servo_inside, work=300), grow_tree(again, work=300)
    assert first.normals.tobytes() == second.normals.tobytes()
    assert first.offsets.tobytes() == second.offsets.tobytes()
    assert first.children.tobytes() == second.children.tobytes()


def test_mirror_needs_an_odd_program() -> None:
    uneven = parametric_qp(np.eye(2), np.eye(2) + 0.1, lower=[-1.0, -2.0], upper=[1.0, 1.0])
    solution = solve(uneven, 10)
    assert not is_odd(solution)
    with pytest.raises(ExplicitError, match="odd"):
        grow_tree(solution, mirror=0)
    shifted = parametric_qp(
        np.eye(2), np.eye(2) + 0.1, constant=[0.1, 0.0], lower=[-1.0] * 2, upper=[1.0] * 2
    )
    assert not is_odd(solve(shifted, 10))
    one_sided = parametric_qp(
        np.eye(2), np.eye(2), rows=[[1.0, 1.0]], bounds=[1.0], lower=[-1.0] * 2, upper=[1.0] * 2
    )
    assert not is_odd(solve(one_sided, 50))
    assert is_odd(solve(servo_drive(2), 10))
    assert is_odd(solve(double_integrator(3), 100))
    assert not is_odd(solve(random_program(3, 2, 2, 3), 100))


def test_one_law_is_a_tree_without_nodes() -> None:
    free = parametric_qp(np.eye(2), np.eye(2), lower=[-np.inf, -1.0], upper=[np.inf, 1.0])
    solution = solve(free, 10)
    assert solution.laws.count == 1
    tree = grow_tree(solution)
    assert (tree.nodes, tree.depth) == (1, 0)
    assert prove_tree(tree, solution).holds()
    np.testing.assert_array_equal(descend(tree, np.zeros((3, 2))), [0, 0, 0])
    np.testing.assert_allclose(tree_lookup(solution, tree).evaluate(np.eye(2)), [[-1.0], [0.0]])


def test_tree_and_solution_must_fit(limited: ExplicitSolution, relaxed: ExplicitSolution) -> None:
    with pytest.raises(ExplicitError, match="coordinates"):
        prove_tree(grow_tree(limited, work=0), relaxed)


def test_programs_that_no_batch_settles_are_asked_one_by_one(
    relaxed: ExplicitSolution, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What then has no answer may remain: a tree is not refused for it with an internal error."""

    def gives_up(*_: object, **__: object) -> None:
        raise SetError("constraints", None, "a linear program that solves")

    tree = grow_tree(relaxed, work=0)
    monkeypatch.setattr(facet_parts, "inner_balls", gives_up)
    proved(tree, relaxed)
    monkeypatch.setattr(facet_parts, "inner_ball", gives_up)
    assert not prove_tree(tree, relaxed).holds()
