"""Linear programs on polyhedra: support, emptiness, centre, redundancy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.sets.errors import SetError
from servogen.sets.polyhedron import (
    chebyshev_centre,
    is_empty,
    maximise,
    pair_is_redundant,
    remove_redundant,
    remove_redundant_pairs,
)

SQUARE = np.vstack([np.eye(2), -np.eye(2)])
ONES = np.ones(4)


def test_support_of_a_square() -> None:
    best = maximise(SQUARE, ONES, np.array([3.0, -2.0]))
    assert best.value == pytest.approx(5.0, abs=1e-12)
    assert best.point is not None
    np.testing.assert_allclose(best.point, [1.0, -1.0], atol=1e-12)


def test_support_is_not_hurt_by_units() -> None:
    """Columns a billion apart, rows too."""
    columns, rows = np.array([1e-6, 1e6]), np.array([1e5, 1e-5, 1.0, 1e3])
    h = SQUARE * rows[:, None] / columns
    best = maximise(h, rows, np.array([1.0, 0.0]))
    assert best.value == pytest.approx(1e-6, rel=1e-9)


def test_unbounded_and_empty() -> None:
    half = np.array([[1.0, 0.0]])
    assert maximise(half, np.ones(1), np.array([0.0, 1.0])).value == np.inf
    assert chebyshev_centre(half, np.ones(1))[1] == np.inf
    apart = np.array([[1.0, 0.0], [-1.0, 0.0]])
    with pytest.raises(SetError, match="not empty"):
        maximise(apart, np.array([0.0, -1.0]), np.array([1.0, 0.0]))
    assert is_empty(apart, np.array([0.0, -1.0]))
    assert not is_empty(apart, np.array([1.0, -1.0]))  # a line
    assert not is_empty(SQUARE, ONES)


def test_centre_of_a_triangle() -> None:
    h = np.array([[-1.0, 0.0], [0.0, -1.0], [3.0, 4.0]])
    centre, radius = chebyshev_centre(h, np.array([0.0, 0.0, 12.0]))
    assert radius == pytest.approx(1.0, abs=1e-9)  # legs 4 and 3, hypotenuse 5
    np.testing.assert_allclose(centre, [1.0, 1.0], atol=1e-9)


def test_redundant_rows_of_a_square_go() -> None:
    extra = np.array([[1.0, 1.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]])
    h, k = np.vstack([SQUARE, extra]), np.append(ONES, [2.5, 1.0, 1.5, 0.3])
    np.testing.assert_array_equal(remove_redundant(h, k), [0, 1, 2, 3, 6])


def test_of_equal_rows_the_first_stays() -> None:
    h, k = np.vstack([SQUARE, SQUARE * 2.0]), np.append(ONES, 2.0 * ONES)
    np.testing.assert_array_equal(remove_redundant(h, k), [0, 1, 2, 3])


def test_impossible_row_is_told() -> None:
    with pytest.raises(SetError, match="not empty"):
        remove_redundant(np.vstack([SQUARE, np.zeros(2)]), np.append(ONES, -1.0))


def test_tolerance_decides_a_row_that_cuts_a_little() -> None:
    h = np.vstack([SQUARE, [1.0, 1.0]])
    k = np.append(ONES, 2.0 - 1e-6)
    assert 4 in remove_redundant(h, k)
    assert 4 not in remove_redundant(h, k, tolerance=1e-5)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 4), rows=st.integers(5, 14))
def test_reduced_set_is_the_same_set(seed: int, n: int, rows: int) -> None:
    """Same support in random directions and along every dropped row; no row left can go."""
    generator = np.random.default_rng(seed)
    h = np.vstack([generator.normal(size=(rows, n)), np.eye(n), -np.eye(n)])
    k = np.append(generator.uniform(0.2, 3.0, rows), np.full(2 * n, 4.0))
    kept = remove_redundant(h, k)
    for direction in generator.normal(size=(5, n)):
        whole = maximise(h, k, direction).value
        assert maximise(h[kept], k[kept], direction).value == pytest.approx(whole, rel=1e-7)
    for i in set(range(len(h))) - set(kept.tolist()):
        assert maximise(h[kept], k[kept], h[i]).value <= k[i] + 1e-8
    np.testing.assert_array_equal(remove_redundant(h[kept], k[kept]), range(len(kept)))


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 4), rows=st.integers(3, 8))
def test_pairs_agree_with_single_rows(seed: int, n: int, rows: int) -> None:
    generator = np.random.default_rng(seed)
    h = np.vstack([generator.normal(size=(rows, n)), np.eye(n)])
    kept = remove_redundant_pairs(h)
    single = remove_redundant(np.vstack([h, -h]), np.ones(2 * len(h)))
    np.testing.assert_array_equal(np.concatenate([kept, kept + len(h)]), single)


def test_pair_redundancy_when_the_rest_is_unbounded() -> None:
    assert not pair_is_redundant(np.array([[1.0, 0.0]]), np.array([0.0, 1.0]))
    assert pair_is_redundant(np.array([[1.0, 0.0]]), np.array([0.5, 0.0]))
