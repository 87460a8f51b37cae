"""Every form of the servo drive's first move against DAQP, on 100,000 parameters."""

import numpy as np
import pytest
from explicit_problems import LIMIT_MA, servo_drive
from many_parameters import parameters
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
    free = np.abs(moves) < LIMIT_MA * (1.0 - 1e-9)
    assert 0.1 < np.mean(free) < 0.9  # neither all saturated nor none
    return moves


def test_enough_parameters(thetas: np.ndarray) -> None:
    assert len(thetas) >= 100_000


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
