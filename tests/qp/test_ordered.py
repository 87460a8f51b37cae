"""The sums of the reference are those of a loop, bit for bit; numpy's own are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.qp.ordered import dot, matvec, total


def loop_sum(terms):
    result = terms[0]
    for term in terms[1:]:
        result = result + term
    return result


def numbers(rng, shape, dtype):
    return (rng.normal(size=shape) * 10.0 ** rng.uniform(-6, 6, shape)).astype(dtype)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    rows=st.integers(1, 40),
    cols=st.integers(1, 40),
    dtype=st.sampled_from([np.float32, np.float64]),
)
def test_sums_are_those_of_a_loop(seed, rows, cols, dtype):
    rng = np.random.default_rng(seed)
    columns, x = numbers(rng, (cols, rows), dtype), numbers(rng, cols, dtype)
    product = matvec(columns, x)
    assert product.dtype == dtype
    for i in range(rows):
        expected = loop_sum([columns[j, i] * x[j] for j in range(cols)])
        assert product[i].tobytes() == expected.tobytes()
    y = numbers(rng, cols, dtype)
    assert dot(x, y).tobytes() == loop_sum([x[j] * y[j] for j in range(cols)]).tobytes()
    assert total(x).tobytes() == loop_sum(list(x)).tobytes()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_order_matters(dtype):
    """Were the sums pairwise, the test above would not notice on data that add up exactly."""
    rng = np.random.default_rng(0)
    x = numbers(rng, 1000, dtype)
    assert total(x) != np.sum(x)
