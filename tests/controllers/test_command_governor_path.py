"""Predicted indices: every point within reach of its interval, never less than was planned."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.command_governor_path import Reach, predicted_indices

INTERVALS = 6


def walk(generator: np.random.Generator, steps: int, size: float) -> np.ndarray:
    return np.cumsum(generator.uniform(-size, size, steps)) + 0.0


def problem(seed: int) -> tuple[list[np.ndarray], list[Reach], int]:
    """A wandering path, and reaches around a wandering stage: often none of them is enough."""
    generator = np.random.default_rng(seed)
    points = [walk(generator, 25, 0.5) for _ in range(2)]
    reach = []
    for own in points:
        middle = np.append(own[0], own[0] + walk(generator, INTERVALS, 0.7))
        wide = generator.uniform(0.6, 1.6)
        least = np.maximum(middle[:-1], middle[1:]) - wide
        greatest = np.minimum(middle[:-1], middle[1:]) + wide
        reach.append(Reach(least, greatest))
    return points, reach, int(generator.integers(1, 9))


def inside(points: list[np.ndarray], reach: list[Reach], point: int, interval: int) -> bool:
    return all(
        axis.least[interval] <= own[point] <= axis.greatest[interval]
        for own, axis in zip(points, reach, strict=True)
    )


def all_sequences(points: list[np.ndarray], reach: list[Reach], most: int) -> list[tuple[int, ...]]:
    """Every sequence of indices that keeps the reaches, by trying all: an oracle."""
    found: list[tuple[int, ...]] = [(0,)] if inside(points, reach, 0, 0) else []
    for interval in range(INTERVALS - 1):
        longer = []
        for sequence in found:
            for end in range(sequence[-1], min(sequence[-1] + most, points[0].size - 1) + 1):
                if not inside(points, reach, end, interval):
                    break
                if inside(points, reach, end, interval + 1):
                    longer.append((*sequence, end))
        found = longer
    return found


@settings(max_examples=250, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_kept_by_every_interval_and_no_less_than_planned(seed: int) -> None:
    """Any admissible sequence as the plan before: the answer is one too, and nowhere behind it."""
    points, reach, most = problem(seed)
    possible = all_sequences(points, reach, most)
    if not possible:
        return
    planned = possible[seed % len(possible)]
    found = predicted_indices((points[0], points[1]), (reach[0], reach[1]), np.array(planned), most)
    assert tuple(found) in set(possible)
    assert np.all(found >= planned)


def test_as_far_as_any_other() -> None:
    """It waits or goes back to the plan where the most points end badly: nothing is lost by it."""
    behind = tried = 0
    for seed in range(400):
        points, reach, most = problem(seed)
        possible = all_sequences(points, reach, most)
        if possible:
            tried += 1
            first = np.array(possible[0])
            found = predicted_indices((points[0], points[1]), (reach[0], reach[1]), first, most)
            behind += int(found[-1]) < max(sequence[-1] for sequence in possible)
    assert tried > 100
    assert behind == 0


def test_points_planned_are_not_asked_again() -> None:
    """A reach that is too short by nothing at all would otherwise end every motion."""
    points = np.linspace(0.0, 1.0, 11)
    short = Reach(np.full(4, -1.0), np.array([0.3, 0.3, 0.3, 0.3]) - 1e-9)
    planned = np.array([0, 1, 3, 3])
    found = predicted_indices((points, points), (short, short), planned, 5)
    np.testing.assert_array_equal(found, [0, 2, 3, 3])
    np.testing.assert_array_equal(
        predicted_indices((points, points), (short, short), np.zeros(4, np.int64), 5), [0, 2, 2, 2]
    )


def test_waits_where_the_next_interval_reaches_less() -> None:
    """The furthest point in reach of all that follow, not the furthest now and not the plan's."""
    points = np.linspace(0.0, 1.0, 11)
    reach = Reach(np.full(4, -1.0), np.array([0.85, 0.85, 0.85, 0.45]))
    nothing = np.zeros(4, np.int64)
    found = predicted_indices((points, points), (reach, reach), nothing, 10)
    np.testing.assert_array_equal(found, [0, 4, 4, 4])


def test_does_not_wait_where_an_interval_between_does_not_reach() -> None:
    points = np.array([0.55, 0.3, 0.6, 0.9])
    reach = Reach(np.array([-1.0, -1.0, 0.5, -1.0]), np.array([0.95, 0.95, 0.95, 0.58]))
    mirrored = Reach(-reach.greatest, -reach.least)
    nothing = np.zeros(4, np.int64)
    for own, axis in ((points, reach), (-points, mirrored)):
        np.testing.assert_array_equal(
            predicted_indices((own, own), (axis, axis), nothing, 3), nothing
        )


def test_goes_back_to_the_plan_as_late_as_it_can() -> None:
    """What was taken before in the first interval stays taken."""
    points = np.linspace(0.0, 1.0, 11)
    reach = Reach(np.full(4, -1.0), np.array([0.35, 0.65, 0.65, 0.39]))
    found = predicted_indices((points, points), (reach, reach), np.array([0, 2, 4, 4]), 9)
    np.testing.assert_array_equal(found, [0, 3, 4, 4])


def test_most_and_the_end_of_the_path() -> None:
    points = np.linspace(0.0, 1.0, 11)
    wide = Reach(np.full(5, -9.0), np.full(5, 9.0))
    nothing = np.zeros(5, np.int64)
    found = predicted_indices((points, points), (wide, wide), nothing, 3)
    np.testing.assert_array_equal(found, [0, 3, 6, 9, 10])
    alone = points[:1]
    found = predicted_indices((alone, alone), (wide, wide), nothing, 3)
    np.testing.assert_array_equal(found, nothing)
