"""Walks from the root of a search tree to a leaf: told apart by level."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from servogen.wcet.package import Count
from servogen.wcet.refusal import CountRefused

Counter = Callable[..., Count]

# A complete binary tree in arrays, as an explicit controller stores it: inner nodes hold a
# half-space, leaves an affine law.
TREE = """
#include <stdint.h>
enum { T_ORDER = 3, T_INNER = 7, T_LEAVES = 8, T_TREE_DEPTH = 3, T_ITERATION_CAP = 10 };
static const sg_real t_normal[T_INNER * T_ORDER] = {1, 2, 3};
static const sg_real t_offset[T_INNER] = {1, 2, 3};
static const sg_real t_gain[T_LEAVES * T_ORDER] = {1, 2, 3};
static sg_real dot(int n, const sg_real *a, const sg_real *b)
{
    sg_real sum = a[0] * b[0];
    for (int i = 1; i < n; i++) { sum += a[i] * b[i]; }
    return sum;
}
static int32_t leaf(const sg_real *x)
{
    int32_t node = 0;
    for (int level = 0; level < T_TREE_DEPTH; level++) {
        const sg_real side = dot(T_ORDER, &t_normal[node * T_ORDER], x);
        node = (2 * node) + ((side <= t_offset[node]) ? 1 : 2);
    }
    return node - T_INNER;
}
sg_real law(const sg_real *x)
{
    return dot(T_ORDER, &t_gain[leaf(x) * T_ORDER], x);
}
void search(sg_real *x) { for (int i = 0; i < 5; i++) { x[0] += law(x); } }
void solve(sg_real *x) { for (int k = 0; k < T_ITERATION_CAP; k++) { x[0] += law(x); } }
"""


def test_a_lookup_is_told_by_level(counts: Counter) -> None:
    result = counts(TREE, entry="law")
    assert result.caps == {"T_TREE_DEPTH": 3}
    assert (result.per_iteration, result.fixed.mul) == ({}, 3)
    level = result.per_level["T_TREE_DEPTH"]
    assert (level.mul, level.add, level.cmp, level.load) == (3, 2, 1, 7)
    assert result.total().mul == 3 + 3 * 3 == result.base.mul
    assert result.total(cap=99) == result.total()  # a depth is no cap to be traded
    assert set(result.exact) >= {"mul", "add", "cmp", "load"}
    told = result.to_json()
    assert told["per_tree_level"] == {"T_TREE_DEPTH": level.as_dict()}


def test_lookups_in_a_search(counts: Counter) -> None:
    result = counts(TREE, entry="search")
    assert result.per_level["T_TREE_DEPTH"].mul == 5 * 3
    assert result.total().mul == 5 * (3 + 9)


def test_lookups_in_a_solver_belong_to_its_iterations(counts: Counter) -> None:
    result = counts(TREE, entry="solve")
    assert (result.per_level, result.caps) == ({}, {"T_ITERATION_CAP": 10})
    assert result.per_iteration["T_ITERATION_CAP"].mul == 3 + 9
    assert result.total().mul == 10 * 12


def test_a_solver_inside_a_tree_is_refused(counts: Counter) -> None:
    text = TREE.replace("node = (2", "for (int k = 0; k < T_ITERATION_CAP; k++) { } node = (2")
    with pytest.raises(CountRefused, match=r"an iteration cap inside one up to 'T_TREE_DEPTH'"):
        counts(text, entry="law")


def test_a_walk_that_is_not_as_long_as_the_tree_is_deep(counts: Counter) -> None:
    text = TREE.replace("int level = 0", "int level = 1")
    with pytest.raises(CountRefused, match=r"unit0\.c:\d+: .*tree depth 'T_TREE_DEPTH'"):
        counts(text, entry="law")
