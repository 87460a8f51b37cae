"""Judging a path against the admissible sets: Theorem 1's hypothesis, by its own definition."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from servogen.errors import InputError
from servogen.paths.timing import TimedPath
from servogen.project import Project, load_project
from servogen.resources import resource_dir
from servogen.systems.judgement import Sets, check_path, check_plants, check_sets

EXAMPLE = resource_dir("examples") / "two_stage" / "servogen.toml"


@pytest.fixture(scope="module")
def project() -> Project:
    return load_project(EXAMPLE)


@pytest.fixture(scope="module")
def sets(project: Project) -> Sets:
    return check_sets(project, check_plants(project))


def timed(points: np.ndarray) -> TimedPath:
    piece = np.zeros(len(points), dtype=np.int64)
    tool_path = SimpleNamespace(labels=("LINE #7",))
    return TimedPath(points, 0.0002, piece, tool_path)  # type: ignore[arg-type]


def test_equal_axes_share_their_set(project: Project, sets: Sets) -> None:
    assert sets.x is sets.y


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_longest_step_is_the_set_s_own(
    project: Project, sets: Sets, column: int, sign: float
) -> None:
    """The bound that check_path draws is where (x_e(q), q') leaves the interior."""
    low, high = 0.0, 0.1
    rest = np.array([0.2 * sign, 0.0, 0.0])
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        inside = sets.x.excess(rest, sign * (0.2 + middle)) < 0.0
        low, high = (middle, high) if inside else (low, middle)
    assert low > 1e-3

    def path(step: float) -> TimedPath:
        points = np.zeros((5, 2))
        points[:, column] = sign * np.array([0.2, 0.2, 0.2, 0.2 + step, 0.2 + step])
        return timed(points)

    check_path(project, path(low - 1e-7), sets)
    with pytest.raises(InputError, match=rf"point 2 at .*LINE #7 .* along {'xy'[column]}"):
        check_path(project, path(high + 1e-7), sets)


def test_the_workspace_is_the_tightened_one_and_the_first_point_is_told(
    project: Project, sets: Sets
) -> None:
    points = np.column_stack([np.linspace(0.39, 0.41, 2001), np.zeros(2001)])
    first = int(np.flatnonzero(points[:, 0] >= 0.396 * (1 - 1e-9))[0])
    with pytest.raises(InputError, match=f"point {first} at .* outside the workspace"):
        check_path(project, timed(points), sets)
    check_path(project, timed(points[:first]), sets)


def test_a_long_path_is_judged_to_its_end(project: Project, sets: Sets) -> None:
    points = np.zeros((450_001, 2))
    points[-1, 1] = 0.1
    with pytest.raises(InputError, match="point 449999 "):
        check_path(project, timed(points), sets)
