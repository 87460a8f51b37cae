"""Every form of the servo drive's first move against DAQP, on 100,000 parameters."""

import numpy as np
import pytest
from explicit_problems import LIMIT_MA, servo_drive
from many_parameters import HALF, THIRDS, parameters
from oracle import first_moves

from servogen.explicit.clips import recursive_clips, without_first_bounds
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree
from servogen.explicit.lookup import evaluate_clips, tree_lookup
from servogen.explicit.solution import ExplicitSolution
from servogen.qp.parametric import ParametricQP

ALLOWED_MA = 1e-6


@pytest.fixture(scope="module")
def problem() -> ParametricQP:
    return servo_drive(3)


@pytest.fixture(scope="module")
def solution(problem: ParametricQP) -> ExplicitSolution:
    return solve(problem, 100)


@pytest.fixture(scope="module")
def thetas(solution: ExplicitSolution) -> np.ndarray:
    return parameters(solution)


@pytest.fixture(scope="module")
def wanted(problem: ParametricQP, thetas: np.ndarray) -> np.ndarray:
    moves = first_moves(problem, thetas)
    assert not np.any(np.isnan(moves))
    return moves


def test_parameters_try_every_law_near_and_far(
    solution: ExplicitSolution, thetas: np.ndarray, wanted: np.ndarray
) -> None:
    assert len(thetas) >= 100_000
    found = solution.law_of[solution.locate(solution.image.of(thetas))]
    free = np.abs(wanted[:, 0]) < LIMIT_MA * (1.0 - 1e-9)
    for name, least in (("inside", 0.1), ("facets", 0.3), ("far", 0.6)):
        third = THIRDS[name]
        assert least < np.mean(free[third]) < 0.9  # a saturated move tries no law
        assert np.min(np.bincount(found[third], minlength=11)) > 400
    boxes = np.max(np.abs(thetas[THIRDS["far"]] / HALF), axis=1)
    assert np.mean(boxes > 1e2) > 0.95
    assert np.mean(boxes > 1e5) > 0.2


def test_regions_one_by_one(
    solution: ExplicitSolution, thetas: np.ndarray, wanted: np.ndarray
) -> None:
    assert np.max(np.abs(solution.first_move(thetas) - wanted)) <= ALLOWED_MA


@pytest.mark.parametrize("mirror", [-1, 2])
def test_law_tree(
    solution: ExplicitSolution, thetas: np.ndarray, wanted: np.ndarray, mirror: int
) -> None:
    lookup = tree_lookup(solution, grow_tree(solution, 0, mirror))
    assert np.max(np.abs(lookup.evaluate(thetas) - wanted)) <= ALLOWED_MA


@pytest.mark.parametrize("mirror", [-1, 1])
def test_clip_tree(
    problem: ParametricQP, thetas: np.ndarray, wanted: np.ndarray, mirror: int
) -> None:
    relaxed, bounds = without_first_bounds(problem)
    solution = solve(relaxed, 100)
    lookup = tree_lookup(solution, grow_tree(solution, 500, mirror), bounds)
    assert np.max(np.abs(lookup.evaluate(thetas) - wanted)) <= ALLOWED_MA


def test_recursive_clips(problem: ParametricQP, thetas: np.ndarray, wanted: np.ndarray) -> None:
    moves = evaluate_clips(recursive_clips(problem), thetas)
    assert np.max(np.abs(moves - wanted)) <= ALLOWED_MA
