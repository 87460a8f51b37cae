"""Loops up to an iteration cap: a fixed part and a part per iteration."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.wcet.caps import affine_bound, cycle_bound
from servogen.wcet.package import Count
from servogen.wcet.refusal import CountRefused

Counter = Callable[..., Count]

SOLVER = """
static void solve(int n, int cap, int period, sg_real *y)
{
    for (int i = 0; i < n; i++) { y[i] = y[i] / 3.0; }
    for (int k = 0; k < cap; k++) {
        for (int i = 0; i < n; i++) { y[i] = y[i] * 2.0; }
        if (k % period == period - 1) {
            for (int i = 0; i < n; i++) { y[i] = y[i] + 1.0; }
        }
    }
}
"""


def test_both_axes_through_a_shared_kernel(counts: Counter) -> None:
    text = SOLVER + (
        "enum { X_ITERATION_CAP = 40, Y_ITERATION_CAP = 50 };\n"
        "void f(sg_real *x, sg_real *y)\n"
        "{ solve(6, X_ITERATION_CAP, 3, x); solve(4, Y_ITERATION_CAP, 2, y);\n"
        "  solve(4, Y_ITERATION_CAP, 2, x); }"
    )
    result = counts(text)
    assert result.caps == {"X_ITERATION_CAP": 40, "Y_ITERATION_CAP": 50}
    assert result.fixed.div == 6 + 4 + 4
    assert {n: p.mul for n, p in result.per_iteration.items()} == {
        "X_ITERATION_CAP": 6,
        "Y_ITERATION_CAP": 8,
    }
    # The work of every third and every second iteration is spread over all of them.
    assert [p.add for p in result.per_iteration.values()] == [2, 4]
    assert result.total().mul == 40 * 6 + 50 * 8
    assert result.total(7).mul == 7 * 14
    assert result.one_iteration().mul == 14


def test_a_turn_counted_by_hand_is_followed(counts: Counter) -> None:
    text = """
    enum { A_ITERATION_CAP = 30, PERIOD = 5 };
    sg_real f(sg_real x, int a)
    {
        int turn = 0;
        for (int k = 0; k < A_ITERATION_CAP; k++) {
            int kind = (turn == PERIOD - 1) ? 2 : 0;
            if (x > 3.0) { break; }
            if (k == A_ITERATION_CAP - 1) { break; }
            if (turn == 0) { kind = (a > 0) ? 1 : 0; }
            if (kind == 2) {
                for (int i = 0; i < 10; i++) { x = x * 3.0; }
            } else {
                for (int i = 0; i < 20; i++) { x = x + 3.0; }
            }
            SKIP
            turn = (turn == PERIOD - 1) ? 0 : (turn + 1);
        }
        return x;
    }"""
    part = counts(text.replace("SKIP", "")).per_iteration["A_ITERATION_CAP"]
    assert (part.mul, part.add) == (
        2 * 10 // 5,
        4 * 20 // 5,
    )  # a may be such that turn 0 has kind 2
    part = counts(text.replace("SKIP", "if (x > 2.0) { continue; }")).per_iteration[
        "A_ITERATION_CAP"
    ]
    assert (part.mul, part.add) == (10, 20)
    # Too many to follow one by one: the turns are followed until they repeat.
    many = counts(text.replace("SKIP", "").replace("CAP = 30", "CAP = 100000"))
    part = many.per_iteration["A_ITERATION_CAP"]
    assert (part.mul, part.add) == (2 * 10 // 5, 4 * 20 // 5)
    assert many.fixed.mul <= 10


def test_a_plain_loop_up_to_the_cap_is_exact(counts: Counter) -> None:
    text = """
    enum { A_ITERATION_CAP = 9 };
    sg_real f(sg_real x) { for (int k = 0; k < A_ITERATION_CAP; k++) { x *= 2.0; } return x; }"""
    result = counts(text)
    assert (result.fixed.branch, result.fixed.mul) == (1, 0)
    part = result.per_iteration["A_ITERATION_CAP"]
    assert (part.mul, part.branch, part.int_add, part.int_cmp) == (1, 1, 1, 1)


def test_the_count_does_not_hang_on_the_cap(counts: Counter) -> None:
    """What ``build`` adopts as a cap must not change the cost of an iteration."""

    def at(cap: int) -> Count:
        text = SOLVER + (
            f"enum {{ X_ITERATION_CAP = {cap} }};\n"
            "void f(sg_real *x) { solve(5, X_ITERATION_CAP, 6, x); }"
        )
        return counts(text)

    assert at(40).per_iteration == at(500).per_iteration
    assert at(40).fixed == at(500).fixed
    # So many are not followed one by one: the work of every sixth counts in each.
    assert at(90_000).per_iteration["X_ITERATION_CAP"].add == 5
    assert at(500).per_iteration["X_ITERATION_CAP"].add == 1


def test_decision_between_solvers_takes_the_larger_of_each_part(counts: Counter) -> None:
    text = """
    enum { A_ITERATION_CAP = 9, B_ITERATION_CAP = 5 };
    sg_real f(int n, sg_real x)
    {
        if (n > 0) { for (int k = 0; k < A_ITERATION_CAP; k++) { x *= 2.0; } }
        else { for (int k = 0; k < B_ITERATION_CAP; k++) { x += 2.0; } }
        return x;
    }"""
    result = counts(text)
    assert {n: (p.mul, p.add) for n, p in result.per_iteration.items()} == {
        "A_ITERATION_CAP": (1, 0),
        "B_ITERATION_CAP": (0, 1),
    }


@pytest.mark.parametrize(
    "loop",
    [
        "for (int k = 1; k < A_ITERATION_CAP; k++) { x *= 2.0; }",
        "for (int k = 0; k < A_ITERATION_CAP; k += 2) { x *= 2.0; }",
        "for (int k = 0; k < A_ITERATION_CAP; k++)"
        " { for (int j = 0; j < A_ITERATION_CAP; j++) { x *= 2.0; } }",
    ],
)
def test_odd_loops_up_to_a_cap_are_refused(counts: Counter, loop: str) -> None:
    text = f"enum {{ A_ITERATION_CAP = 9 }};\nsg_real f(sg_real x)\n{{\n{loop}\nreturn x; }}"
    with pytest.raises(CountRefused, match=r"unit0\.c:5: .*cap"):
        counts(text)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(
    st.lists(st.lists(st.integers(0, 9), min_size=2, max_size=2), max_size=4),
    st.lists(st.lists(st.integers(0, 9), min_size=2, max_size=2), min_size=1, max_size=5),
)
def test_line_covers_what_repeats_for_ever(start: list[list[int]], cycle: list[list[int]]) -> None:
    fixed, slope = cycle_bound([*start, *cycle], len(cycle))
    sums = [0, 0]
    for number, turn in enumerate([*start, *cycle * 5], start=1):
        sums = [a + b for a, b in zip(sums, turn, strict=True)]
        assert all(s <= f + number * p for s, f, p in zip(sums, fixed, slope, strict=True))
    assert all(p <= max(turn[c] for turn in cycle) for c, p in enumerate(slope))


@settings(derandomize=True, deadline=None, max_examples=200)
@given(
    st.lists(st.lists(st.integers(0, 9), min_size=2, max_size=2), min_size=1, max_size=5),
    st.integers(0, 4),
    st.lists(st.integers(0, 9), min_size=2, max_size=2),
    st.lists(st.integers(0, 9), min_size=2, max_size=2),
    st.integers(1, 40),
)
def test_line_covers_every_number_of_iterations(
    cycle: list[list[int]], phase: int, first: list[int], last: list[int], other_cap: int
) -> None:
    def turns(cap: int) -> list[list[int]]:
        regular = [cycle[(k + phase) % len(cycle)] for k in range(cap)]
        return [first, *regular[1:-1], last][:cap]

    fixed, slope = affine_bound(turns(20))
    for cap in (20, other_cap):
        total = [0, 0]
        for number, turn in enumerate(turns(cap), start=1):
            total = [a + b for a, b in zip(total, turn, strict=True)]
            assert all(t <= f + number * s for t, f, s in zip(total, fixed, slope, strict=True))
    assert all(s <= max(t[c] for t in turns(20)) for c, s in enumerate(slope))
