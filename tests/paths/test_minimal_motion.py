"""Minimal motion: against linear and quadratic programs, and what makes a string taut."""

from __future__ import annotations

import time
from itertools import pairwise
from math import fsum

import daqp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import bmat, csr_matrix, diags, eye

from servogen.errors import InputError
from servogen.paths import minimal_motion as subject
from servogen.paths.minimal_motion import (
    SHORT,
    look_ahead,
    minimal_motion,
    pattern_motion,
    tube_around,
)
from servogen.paths.taut_compiled import has_compiler, taut_string_compiled
from servogen.paths.taut_string import heights_along, taut_string

Array = NDArray[np.float64]
Ends = tuple[float | None, float | None]
KINDS = ("walk", "noise", "steps", "narrow", "lattice", "figures")


def random_tube(kind: str, n: int, seed: int) -> tuple[Array, Array]:
    """Bounds of order one around a path of its kind; of ``narrow`` some have no width at all,
    of ``lattice`` many lie in one line."""
    rng = np.random.default_rng(seed)
    width = 0.5
    match kind:
        case "walk":
            path = np.cumsum(rng.normal(size=n)) * 0.2
        case "noise":
            path = rng.normal(size=n)
        case "steps":
            path = np.repeat(rng.normal(size=n), 1 + np.arange(n) % 5)[:n]
        case "narrow":
            path = np.cumsum(rng.normal(size=n)) * 0.2
            width = rng.choice([0.0, 1e-6, 0.1, 1.0], n)
        case "lattice":
            path = np.cumsum(rng.integers(-1, 2, n)).astype(float)
            return path - rng.integers(0, 2, n), path + rng.integers(0, 3, n)
        case _:
            t = np.arange(n)
            path = np.sin(0.3 * t) + 1.5 * np.sin(0.05 * t + rng.normal())
    return path - width, path + width * rng.uniform(0.5, 1.0)


def ends_of(kind: str, lower: Array, upper: Array, seed: int) -> Ends:
    rng = np.random.default_rng(seed)
    start = float(rng.uniform(lower[0], upper[0])) if "start" in kind else None
    end = float(rng.uniform(lower[-1], upper[-1])) if "end" in kind else None
    return start, end


def pinned(lower: Array, upper: Array, ends: Ends) -> tuple[Array, Array]:
    low, high = lower.copy(), upper.copy()
    for at, value in zip((0, -1), ends, strict=True):
        if value is not None:
            low[at] = high[at] = value
    return low, high


def distance(x: Array) -> float:
    """The sum of |x_{j+1} - x_j|, (20)."""
    return fsum(np.abs(np.diff(x)).tolist())


def least_distance(lower: Array, upper: Array) -> float:
    """(20) as a linear program in x and the steps' magnitudes."""
    n = lower.size
    step = diags([-np.ones(n - 1), np.ones(n - 1)], [0, 1], shape=(n - 1, n))
    rows = csr_matrix(bmat([[step, -eye(n - 1)], [-step, -eye(n - 1)]]))
    bounds = [*zip(lower, upper, strict=True), *([(0.0, None)] * (n - 1))]
    cost = np.concatenate([np.zeros(n), np.ones(n - 1)])
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    found = linprog(
        cost, rows, np.zeros(2 * n - 2), bounds=bounds, method="highs-ds", options=tight
    )
    assert found.status == 0
    return float(found.fun)


def least_squares(lower: Array, upper: Array) -> Array:
    """The x (n,) of the least sum of squared steps."""
    n = lower.size
    step = np.diff(np.eye(n), axis=0)
    hessian = step.T @ step
    x = lower.copy()
    free = lower < upper
    near = {"eps_prox": 1e-4, "eta_prox": 1e-13} if free.all() else {}  # a constant is left open
    x[free], _, flag, _ = daqp.solve(
        hessian[np.ix_(free, free)], hessian[np.ix_(free, ~free)] @ x[~free],
        np.zeros((0, int(free.sum()))), upper[free], lower[free],
        np.zeros(int(free.sum()), dtype=np.int32),
        primal_tol=1e-11, dual_tol=1e-12, iter_limit=100_000, **near,
    )  # fmt: skip
    assert flag == 1
    return x


def slack(x: Array, lower: Array, upper: Array, ends: Ends) -> float:
    """How far a line is from taut: the bends where no bound stands in its way, and the steps at
    free ends, summed. Zero, and x within the tube: it is optimal."""
    low, high = pinned(lower, upper, ends)
    bend = np.diff(np.concatenate([[0.0], np.diff(x), [0.0]]))
    near = 1e-12 * (1.0 + np.abs(x))
    convex = np.where(x >= high - near, 0.0, np.maximum(bend, 0.0))
    concave = np.where(x <= low + near, 0.0, np.maximum(-bend, 0.0))
    return float(np.sum(convex + concave))


@pytest.mark.parametrize("ends", ["start and end", "start", "end", "free"])
@pytest.mark.parametrize("kind", KINDS)
def test_distance_is_that_of_the_linear_program(kind: str, ends: str) -> None:
    for seed in range(6):
        lower, upper = random_tube(kind, 40 + 30 * seed, seed)
        start, end = ends_of(ends, lower, upper, seed)
        x = minimal_motion(lower, upper, start=start, end=end)
        best = least_distance(*pinned(lower, upper, (start, end)))
        assert abs(distance(x) - best) <= 1e-8


@pytest.mark.parametrize("ends", ["start and end", "start", "end", "free"])
@pytest.mark.parametrize("kind", KINDS)
def test_every_point_is_that_of_the_quadratic_program(kind: str, ends: str) -> None:
    for seed in range(6):
        lower, upper = random_tube(kind, 10 + 10 * seed, 100 + seed)
        start, end = ends_of(ends, lower, upper, seed)
        x = minimal_motion(lower, upper, start=start, end=end)
        best = least_squares(*pinned(lower, upper, (start, end)))
        np.testing.assert_allclose(x, best, rtol=0.0, atol=1e-8)


@st.composite
def tubes(draw: st.DrawFn) -> tuple[Array, Array, Ends]:
    """Few values, so that bounds meet, repeat and lie in one line; or any values at all."""
    coarse = st.integers(-3, 3).map(float)
    value = draw(st.sampled_from([coarse, st.floats(-1e3, 1e3), st.floats(-1e-3, 1e-3)]))
    n = draw(st.integers(1, 40))
    pairs = np.sort(np.array([[draw(value), draw(value)] for _ in range(n)]), axis=1)
    lower, upper = pairs[:, 0].copy(), pairs[:, 1].copy()
    share = draw(st.sampled_from([None, 0.0, 0.5, 1.0])), draw(st.sampled_from([None, 0.0, 1.0]))
    ends = [
        None if s is None else float(np.clip(lower[at] + s * (upper[at] - lower[at]),
                                             lower[at], upper[at]))
        for s, at in zip(share, (0, -1), strict=True)
    ]  # fmt: skip
    assume(n > 1 or None in ends or ends[0] == ends[1])
    return lower, upper, (ends[0], ends[1])


@settings(deadline=None, max_examples=400)
@given(tubes())
def test_the_string_is_in_the_tube_and_taut(tube: tuple[Array, Array, Ends]) -> None:
    lower, upper, ends = tube
    low, high = pinned(lower, upper, ends)
    x = minimal_motion(lower, upper, start=ends[0], end=ends[1])
    assert np.all((low <= x) & (x <= high))
    assert slack(x, lower, upper, ends) <= 1e-12 * x.size * (1.0 + np.max(np.abs(x)))
    if low.max() > high.min():
        return
    # a constant serves: the middle of all that do, or what the ends leave
    fixed = next((end for end in ends if end is not None), None)
    middle = 0.5 * low.max() + 0.5 * high.min() if fixed is None else fixed
    np.testing.assert_array_equal(x, np.full(x.size, middle))


@settings(deadline=None, max_examples=200)
@given(tubes())
def test_mirrored_and_reversed_tubes_have_the_mirrored_and_reversed_string(
    tube: tuple[Array, Array, Ends],
) -> None:
    lower, upper, (start, end) = tube
    x = minimal_motion(lower, upper, start=start, end=end)
    minus = (None if start is None else -start, None if end is None else -end)
    np.testing.assert_array_equal(minimal_motion(-upper, -lower, start=minus[0], end=minus[1]), -x)
    back = minimal_motion(lower[::-1], upper[::-1], start=end, end=start)
    np.testing.assert_allclose(back[::-1], x, rtol=0.0, atol=1e-12 * (1.0 + np.max(np.abs(x))))


@settings(deadline=None, max_examples=150)
@given(tubes())
def test_what_is_seen_so_far_ahead_settles_a_point(tube: tuple[Array, Array, Ends]) -> None:
    """The path cut ``look_ahead`` points after a point has the same string up to it, whatever the
    bounds from there on."""
    lower, upper, (start, end) = tube
    x = minimal_motion(lower, upper, start=start, end=end)
    ahead = look_ahead(lower, upper, start=start, end=end)
    assert 0 <= ahead < x.size
    for i in range(x.size - 1 - ahead):
        for then in (-1e4, 1e4):
            cut = continued(lower, upper, start, i + 1 + ahead, then)
            np.testing.assert_allclose(cut[: i + 1], x[: i + 1], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["walk", "noise", "figures"])
def test_what_is_seen_any_less_far_ahead_does_not(kind: str) -> None:
    for seed in range(4):
        lower, upper = random_tube(kind, 60, 300 + seed)
        start = None if seed % 2 else float(upper[0])
        x = minimal_motion(lower, upper, start=start)
        ahead = look_ahead(lower, upper, start=start)
        assert ahead > 0
        assert any(
            not np.allclose(continued(lower, upper, start, i + ahead, then)[: i + 1], x[: i + 1])
            for i in range(1, x.size - ahead)
            for then in (-1e4, 1e4)
        )


def continued(lower: Array, upper: Array, start: float | None, size: int, then: float) -> Array:
    """The string where the tube goes somewhere else after ``size`` points."""
    low, high = np.append(lower[:size], then), np.append(upper[:size], then)
    return minimal_motion(low, high, start=start)


@pytest.mark.parametrize("kind", KINDS)
def test_the_c_has_the_bits_of_the_reference(kind: str) -> None:
    assert has_compiler()
    for seed, n in enumerate((1, 2, 3, 50, 3000, 20_000)):
        lower, upper = random_tube(kind, n, 200 + seed)
        start = float(lower[0]) - 0.1 * seed
        x, ahead = taut_string_compiled(lower, upper, start)
        low, high = lower.tolist(), upper.tolist()
        knots = taut_string(low, high, start)
        assert x.tobytes() == np.array(heights_along(knots, low, high, n)).tobytes()
        assert ahead == knots.look_ahead


def test_what_is_asked_for_needs_no_more_points() -> None:
    """A part of the string is the whole one's, and the reference says which of it is settled."""
    lower, upper = (bound.tolist() for bound in random_tube("walk", 400, 7))
    whole = heights_along(taut_string(lower, upper, 0.0), lower, upper, 400)
    for needed in (1, 17, 100):
        knots = taut_string(lower, upper, 0.0, needed)
        assert knots.places[-1] >= needed - 1
        assert knots.decided == len(knots.places)
        assert heights_along(knots, lower, upper, needed) == whole[:needed]
        few = needed + 1
        knots = taut_string(lower[:few], upper[:few], 0.0, needed)
        settled = knots.places[knots.decided - 1] + 1
        assert heights_along(knots, lower, upper, needed)[:settled] == whole[:settled]
        assert settled < needed


@pytest.mark.parametrize("compiled", [True, False])
def test_without_a_compiler_the_bits_are_the_same(
    compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    lower, upper = random_tube("walk", SHORT + 100, 3)
    expected = np.array(minimal_motion(lower, upper))
    used = []
    whole = taut_string_compiled
    monkeypatch.setattr(subject, "has_compiler", lambda: compiled)
    monkeypatch.setattr(subject, "taut_string_compiled", lambda *a: used.append(1) or whole(*a))
    assert minimal_motion(lower, upper).tobytes() == expected.tobytes()
    assert bool(used) is compiled


def test_a_million_points_take_less_than_two_seconds() -> None:
    t = np.arange(1_000_000)
    noise = np.random.default_rng(0).normal(size=t.size)
    path = 0.05 * np.sin(t / 5000.0) + 1e-4 * np.cumsum(noise)
    minimal_motion(*tube_around(path[:5000], 0.025))  # the compiler's time is not the string's
    began = time.perf_counter()
    lower, upper = tube_around(path, 0.025, 0.001)
    x = minimal_motion(lower, upper, start=float(path[0]), end=float(path[-1]))
    assert time.perf_counter() - began < 2.0
    assert np.all(np.abs(x - path) <= 0.024 + 1e-15)
    assert slack(x, lower, upper, (float(path[0]), float(path[-1]))) < 1e-9


def test_far_from_zero_and_in_any_unit_it_is_the_same_string() -> None:
    lower, upper = random_tube("walk", 500, 5)
    x = minimal_motion(lower, upper)
    for scale in (2.0**-300, 2.0**300):
        np.testing.assert_array_equal(minimal_motion(scale * lower, scale * upper), scale * x)
    shifted = minimal_motion(lower + 1e4, upper + 1e4)
    np.testing.assert_allclose(shifted - 1e4, x, rtol=0.0, atol=1e-10)


def test_the_shortest_paths_and_tubes_of_no_width() -> None:
    one = np.array([1.0]), np.array([3.0])
    assert minimal_motion(*one).tolist() == [2.0]
    assert minimal_motion(*one, start=1.0).tolist() == [1.0]
    assert minimal_motion(*one, end=2.5).tolist() == [2.5]
    assert look_ahead(*one) == 0
    two = np.array([0.0, 2.0]), np.array([1.0, 3.0])
    assert minimal_motion(*two).tolist() == [1.0, 2.0]
    assert minimal_motion(*two, start=0.0).tolist() == [0.0, 2.0]
    assert minimal_motion(*two, start=0.5, end=3.0).tolist() == [0.5, 3.0]
    wire = np.array([0.0, 0.0, 1.0, -2.0, -2.0])
    assert minimal_motion(wire, wire).tolist() == wire.tolist()
    assert minimal_motion(wire, wire, start=0.0, end=-2.0).tolist() == wire.tolist()


def test_lines_that_are_straight_but_for_rounding_are_followed_to_the_last_bit() -> None:
    """Here the string leaves the tube by a bit or two, and is put back."""
    for seed in range(20):
        rise, begin = np.random.default_rng(seed).normal(size=2)
        line = rise * np.arange(1000) + begin
        for wire in (line, np.tile(line, 1 + SHORT // 1000)):
            assert minimal_motion(wire, wire).tolist() == wire.tolist()


def test_the_picture_of_the_docstring() -> None:
    """Level, around an upper bound's corner, straight, around a lower one's, level."""
    lower, upper = np.full(9, -5.0), np.full(9, 5.0)
    upper[2], lower[6] = 1.0, 3.0
    expected = [1.0, 1.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.0, 3.0]
    np.testing.assert_allclose(minimal_motion(lower, upper), expected, rtol=0.0, atol=1e-15)


def test_a_pattern_begins_and_ends_on_its_own_points() -> None:
    t = np.linspace(0.0, 9.0, 300)
    pattern = np.column_stack([np.sin(t), 0.3 * t])
    x = pattern_motion(pattern, [0.5, 0.25], 0.05)
    np.testing.assert_array_equal(x[[0, -1]], pattern[[0, -1]])
    assert np.all(np.abs(x - pattern) <= np.array([0.45, 0.2]) + 1e-15)
    assert np.all((x >= pattern.min(axis=0)) & (x <= pattern.max(axis=0)))
    free = pattern_motion(pattern, 0.5, free_ends=True)
    for axis in range(2):
        alone = minimal_motion(*tube_around(pattern[:, axis], 0.5))
        np.testing.assert_array_equal(free[:, axis], alone)
        assert distance(free[:, axis]) < distance(x[:, axis])


def test_points_that_repeat_only_hold_the_string_longer() -> None:
    lower, upper = random_tube("walk", 60, 9)
    x = minimal_motion(np.repeat(lower, 3), np.repeat(upper, 3), start=0.0, end=None)
    assert slack(x, np.repeat(lower, 3), np.repeat(upper, 3), (0.0, None)) < 1e-12
    assert abs(distance(x) - distance(minimal_motion(lower, upper, start=0.0))) < 1e-12


def refused(*arguments: object, **ends: float) -> str:
    with pytest.raises(InputError) as caught:
        minimal_motion(*arguments, **ends)  # type: ignore[arg-type]
    return str(caught.value)


def test_what_cannot_be_a_tube_is_refused_with_its_place() -> None:
    low, high = np.zeros(5), np.ones(5)
    for value in (np.nan, np.inf, -np.inf, 1e300):
        bad = low.copy()
        bad[3] = value
        assert refused(bad, high).startswith("lower[3] is")
        assert refused(low, bad).startswith("upper[3] is")
    crossed = low.copy()
    crossed[2:] = np.nextafter(1.0, 2.0)
    assert refused(crossed, high).startswith("lower[2] is 1.0000000000000002, expected at most")
    assert refused(np.zeros(0), np.zeros(0)).startswith("lower is of shape (0,)")
    assert refused(np.zeros((2, 2)), np.ones((2, 2))).startswith("lower is of shape (2, 2)")
    assert refused(low, high[:4]).startswith("upper is of shape (4,)")
    for value in (np.nan, -1e-9, 1.0 + 1e-9, np.inf):
        assert refused(low, high, start=value).startswith("start is")
        assert refused(low, high, end=value).startswith("end is")
    assert refused(low[:1], high[:1], start=0.2, end=0.3).startswith("end is 0.3")


def test_what_cannot_be_a_pattern_is_refused() -> None:
    def says(*arguments: object) -> str:
        with pytest.raises(InputError) as caught:
            tube_around(*arguments)  # type: ignore[arg-type]
        return str(caught.value)

    points = np.array([0.0, 1.0])
    assert says([0.0, np.nan], 1.0).startswith("points[1] is nan")
    assert says(points, -1.0).startswith("stroke is -1.0")
    assert says(points, np.nan).startswith("stroke is nan")
    for margin in (-1e-3, 1.001, np.nan):
        assert says(points, 1.0, margin).startswith("margin is")
    for bad in (np.zeros(3), np.zeros((0, 2))):
        with pytest.raises(InputError, match="points is of shape"):
            pattern_motion(bad, 1.0)
    with pytest.raises(InputError, match=r"points\[0\] is nan"):
        pattern_motion(np.full((2, 2), np.nan), 1.0)


def test_the_arguments_are_left_as_they_are() -> None:
    lower, upper = random_tube("walk", 30, 1)
    before = lower.copy(), upper.copy()
    minimal_motion(lower, upper, start=float(upper[0]), end=float(lower[-1]))
    for mine, theirs in pairwise([lower, before[0]]):
        np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(upper, before[1])
