"""The batched dual simplex method against HiGHS, and the cones against brute force."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.explicit import small_lp
from servogen.explicit.cones import cone_of, cut, homogeneous, sides
from servogen.explicit.small_lp import (
    _transposed,
    greatest,
    greatest_many,
    inner_ball,
    inner_balls,
)
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import chebyshev_centre, maximise


def random_set(seed: int, n: int, rows: int, low: float) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    h = generator.normal(size=(rows, n))
    return h / np.linalg.norm(h, axis=1, keepdims=True), generator.uniform(low, 1.0, rows)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), rows=st.integers(1, 20))
def test_greatest_is_what_highs_finds(seed: int, n: int, rows: int) -> None:
    """Bounded, unbounded and empty sets."""
    h, k = random_set(seed, n, rows, -0.3)
    objective = np.random.default_rng(seed + 1).normal(size=n)
    try:
        wanted = maximise(h, k, objective).value
    except SetError:
        wanted = -np.inf
    assert greatest(h, k, objective) == pytest.approx(wanted, rel=1e-8, abs=1e-9)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), rows=st.integers(1, 20))
def test_ball_is_what_highs_finds(seed: int, n: int, rows: int) -> None:
    h, k = random_set(seed, n, rows, -0.2)
    ball = inner_ball(h, k)
    assert np.max(h @ ball.centre - k) <= -ball.radius + 1e-9
    radius = min(chebyshev_centre(h, k)[1], 1.0)
    if ball.radius > 1e-3:  # enough for "there is room"; not necessarily the largest
        assert ball.radius <= radius + 1e-9
    else:
        assert ball.radius == pytest.approx(radius, abs=1e-9)


def test_batches_are_their_members() -> None:
    """More programs than go through at once, each as on its own."""
    h, _ = random_set(1, 3, 12, 0.1)
    generator = np.random.default_rng(2)
    k, objectives = generator.uniform(0.1, 1.0, (600, 12)), generator.normal(size=(600, 3))
    together = greatest_many(h, k, objectives)
    alone = [greatest(h, k[i], objectives[i]) for i in range(0, 600, 37)]
    np.testing.assert_allclose(together[::37], alone, rtol=1e-12)
    shared = greatest_many(np.tile(h[:5], (600, 1, 1)), k, objectives, shared=h[5:])
    np.testing.assert_allclose(shared, together, rtol=1e-12)
    split = inner_balls(np.tile(h[:5], (600, 1, 1)), k, shared=h[5:])
    balls = inner_balls(np.tile(h, (600, 1, 1)), k)
    np.testing.assert_allclose([b.radius for b in split], [b.radius for b in balls], rtol=1e-9)
    radii = [inner_ball(h, k[i]).radius for i in range(0, 600, 37)]
    np.testing.assert_allclose([ball.radius for ball in balls][::37], radii, rtol=1e-12)


def test_thin_set_keeps_its_thickness() -> None:
    h = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    assert inner_ball(h, np.array([1e-6, 1e-6, 3.0, 3.0])).radius == pytest.approx(1e-6, rel=1e-4)
    assert inner_ball(h, np.array([0.0, 0.0, 3.0, 3.0])).radius == pytest.approx(0.0, abs=1e-10)
    assert inner_ball(h, np.array([1.0, -1.5, 3.0, 3.0])).radius == pytest.approx(-0.25)


def vertices(h: np.ndarray, k: np.ndarray) -> np.ndarray:
    """By trying every choice of rows."""
    found = []
    for rows in combinations(range(len(k)), h.shape[1]):
        chosen = list(rows)
        if abs(np.linalg.det(h[chosen])) > 1e-9:
            x = np.linalg.solve(h[chosen], k[chosen])
            if np.all(h @ x <= k + 1e-9):
                found.append(x)
    return np.array(found)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 4), rows=st.integers(3, 10))
def test_cone_has_the_vertices(seed: int, n: int, rows: int) -> None:
    h, k = random_set(seed, n, rows, 0.1)
    h, k = np.vstack([h, np.eye(n), -np.eye(n)]), np.append(k, np.full(2 * n, 2.0))
    cone = cone_of(h, k)
    assert not cone.lines.size
    assert np.all(cone.rays[:, -1] > 0.0)  # bounded
    own = cone.rays[:, :-1] / cone.rays[:, -1:]
    wanted = vertices(h, k)
    assert len(own) == len(wanted)
    apart = np.max(np.abs(own[:, None] - wanted[None]), axis=2)
    assert np.max(np.min(apart, axis=1)) < 1e-8


@pytest.mark.parametrize("n", [3, 4, 5])
def test_corners_where_more_planes_meet_than_needed(n: int) -> None:
    """|x_1| + ... + |x_n| <= 1: 2 n corners, 2^(n-1) planes at each; then cut through most."""
    h = np.array(np.meshgrid(*[[-1.0, 1.0]] * n)).reshape(n, -1).T / np.sqrt(n)
    cone = cone_of(h, np.full(2**n, 1.0 / np.sqrt(n)))
    assert len(cone.rays) == 2 * n
    half = cut(cone, homogeneous(np.eye(n)[-1:], np.array([0.0]))[0])
    assert len(half.rays) == 2 * n - 1
    lowest = np.sort(half.rays[:, n - 1] / half.rays[:, n])
    np.testing.assert_allclose(lowest, [-1.0] + [0.0] * (2 * n - 2), atol=1e-9)
    # a plane off the corners: an edge from each of the 2 n - 2 of the equator to the lower tip
    slice_ = cut(half, homogeneous(-np.eye(n)[-1:], np.array([0.5]))[0])
    assert len(slice_.rays) == 2 * (2 * n - 2)


def test_unbounded_sets_know_their_sides() -> None:
    """A half plane, then a wedge of it, against lines near and far."""
    half = cone_of(np.array([[0.0, 1.0]]), np.array([0.0]))  # y <= 0
    assert half.lines.shape == (1, 3)
    lines = homogeneous(np.array([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0]]), np.array([1.0, -1.0, 1e6]))
    below, above = sides([half], lines)[0]
    np.testing.assert_array_equal(below, [True, True, True])
    np.testing.assert_array_equal(above, [False, True, True])
    wedge = cut(half, homogeneous(np.array([[1.0, 1.0]]), np.array([0.0]))[0])
    wedge = cut(wedge, homogeneous(np.array([[-1.0, 0.0]]), np.array([0.0]))[0])  # 0 <= x <= -y
    below, above = sides([wedge], homogeneous(np.array([[1.0, 2.0]]), np.array([0.0])))[0]
    assert below[0]
    assert not above[0]


def test_one_singular_basis_spoils_no_other() -> None:
    rows = np.array([[[2.0, 1.0], [0.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]]])
    solved, whole = _transposed(rows, np.array([[2.0, 3.0], [1.0, 2.0]]))
    assert whole.tolist() == [True, False]
    np.testing.assert_allclose(rows[0].T @ solved[0], [2.0, 3.0])


def test_no_answer_is_not_an_empty_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row whose program nobody solved must not look redundant, as one over an empty set does."""
    h, k = np.array([[1.0], [-1.0]]), np.array([-1.0, 0.0])
    assert greatest(h, k, np.array([1.0])) == -np.inf

    def gives_up(*_: object) -> None:
        raise SetError("constraints", None, "a linear program that solves")

    monkeypatch.setattr(small_lp, "maximise", gives_up)
    assert greatest(h, k, np.array([1.0])) == np.inf
