"""Tangents of streamed points: curves, standstills, corners, reversals, and never a bad number."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.controllers.contour_tangent import Course, Slide, TangentSweep, distinct
from servogen.precision import FLOAT32, FLOAT64, Precision

SHARE, APART = 20.0 / 21.2, 1e-7


def sweep(
    points: np.ndarray, course: Course | None = None, precision: Precision = FLOAT64
) -> tuple[Slide, Course]:
    path = np.asarray(points, dtype=precision.dtype)
    before = course or Course(path[0].copy(), np.zeros_like(path[0]))
    count = len(path) - 1
    return TangentSweep(path.shape[1], count, (1.0 - SHARE, SHARE), APART, precision)(path, before)


def harmless(slide: Slide) -> np.ndarray:
    """(S, p, p) phi^2 r r' that the weight leaves out, from what the law is given."""
    along = slide.along.astype(float)
    length = np.sum(along**2, axis=1)
    whole = slide.price + SHARE * length  # tau, since price = tau - share |t|^2
    found: np.ndarray = along[:, :, None] * along[:, None, :] / whole[:, None, None]
    return found


def line(direction: tuple[float, ...]) -> np.ndarray:
    way = np.array(direction) / np.linalg.norm(direction)
    return np.outer(way, way)


def test_on_a_curve_it_is_the_tangent() -> None:
    angle = 0.025 * np.arange(12) + 0.4
    points = 1e-3 * np.column_stack([np.cos(angle), np.sin(angle)])
    found = sweep(points)[0]
    for j in range(1, 12):
        exact = line((-np.sin(angle[j]), np.cos(angle[j])))
        # a fifth of the square of a step's angle; the last point's direction is foreseen
        assert np.max(np.abs(harmless(found)[j - 1] - exact)) < (1.3e-4 if j < 11 else 2.6e-4)
    assert found.known == 11


def test_in_space_and_at_any_speed() -> None:
    along = np.cumsum([1e-5, 3e-5, 2e-6, 5e-4, 1e-6])
    way = np.array([0.6, 0.0, -0.8])
    assert np.allclose(harmless(sweep(np.outer(along, way))[0]), np.outer(way, way), atol=1e-12)


def test_a_standstill_keeps_the_direction() -> None:
    stands = [[0.0, 0.0], [1e-5, 0.0], [2e-5, 0.0], [2e-5, 0.0], [2e-5, 0.0], [3e-5, 0.0]]
    assert np.allclose(harmless(sweep(np.array(stands))[0]), line((1.0, 0.0)), atol=1e-12)
    # and keeps it as long as it lasts, whatever has passed by
    course = sweep(np.array(stands[1:3] + stands[2:4]))[1]
    for _ in range(3):
        found, course = sweep(np.array([[2e-5, 0.0]] * 6), course)
        assert found.known == 5 or not np.any(course.direction)


def test_a_standstill_after_a_motion_still_knows_it() -> None:
    course = sweep(np.array([[0.0, 0.0], [1e-5, 1e-5]]))[1]
    course = sweep(np.array([[1e-5, 1e-5], [1e-5, 1e-5]]), course)[1]
    found = sweep(np.array([[1e-5, 1e-5]] * 4), course)[0]
    assert found.known == 3
    assert np.allclose(harmless(found), line((1.0, 1.0)), atol=1e-12)


def test_at_a_right_corner_every_error_counts() -> None:
    corner = np.array([[-2.0, 0.0], [-1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [0.0, 3.0]])
    found = harmless(sweep(1e-5 * corner)[0])
    assert np.allclose(found[0], line((1.0, 0.0)))
    assert np.allclose(found[1], 0.0)  # the corner itself
    assert np.allclose(found[2], line((0.0, 1.0)))


def test_a_reversal_is_the_same_line() -> None:
    back = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [1.0, 1.0], [0.0, 0.0], [-1.0, -1.0]])
    assert np.allclose(harmless(sweep(1e-5 * back)[0]), line((1.0, 1.0)), atol=1e-12)
    # one that is a little off is not taken for a motion across
    back[3:, 1] += 0.01
    assert np.allclose(harmless(sweep(1e-5 * back)[0])[1], line((1.0, 1.0)), atol=0.02)


def test_a_creep_is_seen_when_it_has_gone_far_enough() -> None:
    """A hundredth of the threshold per sample, with noise across it of as much."""
    generator = np.random.default_rng(2)
    steps = np.arange(400)
    points = np.column_stack([0.01 * APART * steps, 0.01 * APART * generator.normal(size=400)])
    course = Course(points[0].copy(), np.zeros(2))
    for k in range(380):
        found, course = sweep(points[k : k + 11], course)
        assert found.known == (10 if k > 100 else found.known)
    assert harmless(found)[0][0, 0] > 0.98


def test_nothing_is_known_of_a_point() -> None:
    found = sweep(np.full((11, 2), 0.02))[0]
    assert found.known == 0
    assert not np.any(found.along)
    assert np.all(found.price == 1.0)


@pytest.mark.parametrize("precision", [FLOAT64, FLOAT32])
@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 2**31), st.sampled_from([2, 3]), st.sampled_from([0.0, 1e-9, 1e-7, 1e-2]))
def test_any_points_give_finite_slides(
    precision: Precision, seed: int, axes: int, size: float
) -> None:
    """Repeated, tiny, huge, random: prices are at least alpha / q, tangents no longer than one."""
    generator = np.random.default_rng(seed)
    steps = generator.normal(size=(12, axes)) * size
    steps[generator.random(12) < 0.4] = 0.0
    steps[:, generator.integers(axes)] *= generator.choice([0.0, 1.0, 1e3])
    found, course = sweep(0.03 + np.cumsum(steps, axis=0), None, precision)
    assert np.all(np.isfinite(found.along))
    assert np.all(np.isfinite(course.direction))
    assert np.all(found.price >= (1.0 - SHARE) * (1.0 - 1e-6))
    for part in harmless(found):
        assert np.trace(part) <= 1.0 + 1e-5


def test_what_the_precision_cannot_tell_is_one_point() -> None:
    assert distinct(FLOAT64, 0.05, 1e-9) == 1e-9
    assert distinct(FLOAT32, 0.05, 1e-9) == pytest.approx(1.9e-7, rel=0.01)
