"""Every form of the servo drive's first move against DAQP, on 100,000 parameters."""

import numpy as np
import pytest
from explicit_problems import LIMIT_MA, servo_drive
from oracle import first_moves

from servogen.explicit.clips import recursive_clips, without_first_bounds
from servogen.explicit.explore import solve
from servogen.explicit.grow import grow_tree
from servogen.explicit.lookup import evaluate_clips, tree_lookup
from servogen.explicit.pieces import hyperplanes
from servogen.explicit.problem import ParametricQP
from servogen.explicit.solution import ExplicitSolution

THIRD = 34_000
ALLOWED_MA = 1e-6
HALF = np.array([100.0, 100.0, np.pi, np.pi, LIMIT_MA, 360.0, 360.0, 360.0])


@pytest.fixture(scope="module")
def problem() -> ParametricQP:
    return servo_drive(3)


@pytest.fixture(scope="module")
def solution(problem: ParametricQP) -> ExplicitSolution:
    return solve(problem, 100)


@pytest.fixture(scope="module")
def thetas(solution: ExplicitSolution) -> np.ndarray:
    """A third anywhere in the facts' box and about the origin, a third on or next to facets, a
    third up to a hundred boxes away."""
    generator = np.random.default_rng(20130101)
    p = HALF.size
    inside = generator.uniform(-1.0, 1.0, (THIRD, p)) * HALF
    near = generator.uniform(-3.0, 3.0, (THIRD // 2, 3))
    back = np.linalg.pinv(solution.image.matrix)
    inside[: THIRD // 2] = near @ back.T
    planes = hyperplanes(solution)
    chosen = planes[generator.integers(0, len(planes), THIRD)]
    normals = chosen[:, :3] / np.linalg.norm(chosen[:, :3], axis=1, keepdims=True)
    heights = -chosen[:, 3] / np.linalg.norm(chosen[:, :3], axis=1)
    eta = generator.uniform(-4.0, 4.0, (THIRD, 3))
    beside = generator.choice([0.0, 1e-13, -1e-13, 1e-10, -1e-10, 1e-7, -1e-7], THIRD)
    eta += normals * (heights + beside - np.sum(normals * eta, axis=1))[:, None]
    far = generator.uniform(-1.0, 1.0, (THIRD, p)) * HALF
    far *= 10.0 ** generator.uniform(0.0, 2.0, (THIRD, 1))
    return np.vstack([inside, eta @ back.T, far])


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
