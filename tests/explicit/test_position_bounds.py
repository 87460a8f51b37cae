"""Bounds on the position: rows a million times farther off than the inputs reach in a horizon."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import first_moves
from position_bounds import free_mass, headstock, parameters, program

from servogen.explicit.choose import choose
from servogen.explicit.clips import without_first_bounds
from servogen.explicit.errors import ExplicitError
from servogen.explicit.explore import solve
from servogen.explicit.feasible import feasible_set
from servogen.explicit.grow import grow_tree
from servogen.explicit.image import canonical
from servogen.explicit.prove import prove_tree
from servogen.plants.sampled import Sampled
from servogen.sets.errors import SetError

FREE, HEADSTOCK = free_mass(), headstock()
# The counts of all independent sets whose region holds a ball, asked one by one once.
CASES = [
    (FREE, 1, 3, (), 9),
    (HEADSTOCK, 1, 3, (), 9),
    (HEADSTOCK, 1, 10, (), 23),
    (HEADSTOCK, 2, 5, (), 95),
    (HEADSTOCK, 3, 5, (), 509),
    (FREE, 3, 10, (10,), 65),
    (FREE, 3, 10, (1, 10), 103),
    (HEADSTOCK, 3, 50, (1, 50), 103),
]


@pytest.mark.parametrize(("plant", "control", "prediction", "samples", "count"), CASES)
def test_first_moves_are_those_of_an_independent_solver(
    plant: Sampled, control: int, prediction: int, samples: tuple[int, ...], count: int
) -> None:
    problem = program(plant, control, prediction, 90.0, samples)
    solution = solve(problem, 1000)
    assert len(solution.regions) == count
    assert not solution.findings.unresolved
    theta = parameters(solution, 1)[:400]
    expected = first_moves(problem, theta)
    found = solution.first_move(theta)
    both = ~np.isnan(expected[:, 0]) & ~np.isnan(found[:, 0])
    # a hair from the rim either may call it infeasible
    assert np.mean(both) > 0.9
    assert np.max(np.abs(found[both] - expected[both])) < 0.05


@pytest.mark.parametrize(
    ("plant", "prediction", "samples"),
    [(HEADSTOCK, 3, ()), (FREE, 10, (1, 10)), (HEADSTOCK, 50, (1, 50))],
)
def test_the_tree_without_the_first_bounds_is_right(
    plant: Sampled, prediction: int, samples: tuple[int, ...]
) -> None:
    problem = without_first_bounds(program(plant, 2, prediction, 90.0, samples))[0]
    solution = solve(problem, 1000)
    tree = grow_tree(solution, 0)
    proof = prove_tree(tree, solution)
    assert proof.holds()
    assert proof.arrivals >= tree.leaves > solution.laws.count


def test_the_feasible_set_is_where_the_solver_finds_something() -> None:
    problem = program(FREE, 2, 10, 90.0, (1, 10))
    found = feasible_set(solve(problem, 1000))
    generator = np.random.default_rng(5)
    theta = generator.normal(size=(300, problem.parameters)) * 10.0
    theta[:, -1] = generator.uniform(-180.0, 180.0, 300)
    theta[:, 0] *= 5e-4  # the angle's own increment
    inside = np.max(theta @ found.rows.T - found.bounds, axis=1)
    solved = ~np.isnan(first_moves(problem, theta)[:, 0])
    clear = np.abs(inside) > 1e-6
    assert 20 < np.sum(solved) < 280
    np.testing.assert_array_equal(solved[clear], inside[clear] < 0.0)


def test_inputs_set_the_measure_and_coordinates_are_mixed() -> None:
    """The input's rows are one, the position's far off; no region of the space is a needle."""
    made = canonical(program(FREE, 3, 5, 90.0))
    assert 0.5 < np.median(made.w[10:]) < 2.0
    assert np.min(made.w[:10]) > 1e3
    assert np.linalg.cond(made.e) < 10.0


@pytest.mark.parametrize("samples", [(), tuple(range(1, 9))])
def test_what_numbers_do_not_tell_apart_is_refused_at_once(samples: tuple[int, ...]) -> None:
    with pytest.raises((ExplicitError, SetError)):
        choose(program(FREE, 3, 10, 90.0, samples), 5000)


def test_a_tree_far_too_large_is_refused_before_it_is_grown() -> None:
    problem = without_first_bounds(program(HEADSTOCK, 3, 4, 90.0))[0]
    with pytest.raises(ExplicitError, match="number of tree nodes is about"):
        grow_tree(solve(problem, 1000), 0, max_nodes=3000)
    small = without_first_bounds(program(HEADSTOCK, 2, 3, 90.0))[0]
    with pytest.raises(ExplicitError, match="number of tree nodes is more than 150"):
        grow_tree(solve(small, 1000), 0, max_nodes=150)
