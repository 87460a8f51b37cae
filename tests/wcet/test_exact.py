"""Which classes every run does just as often as counted."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from servogen.wcet.operations import CLASSES
from servogen.wcet.package import Count

Counter = Callable[..., Count]


def test_straight_lines_are_exact(counts: Counter) -> None:
    text = """
    static sg_real least(sg_real a, sg_real b) { return (a < b) ? a : b; }
    sg_real f(int n, sg_real x, sg_real *y)
    {
        for (int i = 0; i < 7; i++) {
            if (i > 3) { y[i] = least(y[i], x) * 2.0; } else { y[i] = 0.0; }
        }
        if (n > 2) { x = x * 3.0; } else { x = x * 4.0; }
        return x;
    }"""
    assert counts(text).exact == CLASSES


@pytest.mark.parametrize(
    ("body", "loose"),
    [
        ("if (n > 2) { x *= 3.0; }", {"mul"}),
        ("if (n > 2) { x *= 3.0; } else { x /= 3.0; }", {"mul", "div"}),
        ("x = (n > 2) ? x * 3.0 : x;", {"mul"}),
        ("n = n > 2 && x > 3.0;", {"cmp"}),
        (
            "if (n > 2) { x *= 3.0; return x; } x *= 3.0; x /= 3.0;",
            {"mul", "div", "int_cmp", "branch"},
        ),
        # deep inside: what follows is counted as if nothing had left
        (
            "if (n > 2) { if (x > 1.0) { return x; } x -= 1.0; } x *= 3.0;",
            {"mul", "add", "int_cmp", "branch", "cmp"},
        ),
        ("switch (n) { case 1: x *= 3.0; break; default: break; }", {"mul"}),
        (
            "for (int i = 0; i < 3; i++) { if (x > 1.0) { break; } x *= 3.0; }",
            {"mul", "cmp", "int_cmp", "int_add", "branch"},
        ),
        (
            "for (int i = 0; i < 3; i++) { if (n > 1) { if (x > 1.0) { continue; } x -= 1.0; }"
            " x *= 3.0; }",
            {"mul", "cmp", "int_cmp", "int_add", "branch", "add"},
        ),
        (
            "for (int i = 0; i < 3 && x < 4.0; i++) { x *= 3.0; }",
            {"mul", "cmp", "int_cmp", "int_add", "branch"},
        ),
        (
            "do { if (x > 1.0) { break; } x *= 3.0; } while (0);",
            {"mul", "cmp", "branch"},
        ),
        # an inner loop that leaves early says nothing of the outer one
        (
            "for (int i = 0; i < 3; i++) { x *= 3.0; for (int j = 0; j < 2; j++)"
            " { if (x > 1.0) { break; } } }",
            {"cmp", "int_cmp", "int_add", "branch"},
        ),
        # every third turn: the line lies above what runs
        (
            "for (int k = 0; k < A_ITERATION_CAP; k++) { if (k % 3 == 2) { x *= 3.0; } x += 1.0; }",
            {"mul"},
        ),
    ],
)
def test_what_may_be_skipped_is_not(counts: Counter, body: str, loose: set[str]) -> None:
    text = f"enum {{ A_ITERATION_CAP = 10 }};\nsg_real f(int n, sg_real x) {{ {body} return x; }}"
    assert set(CLASSES) - set(counts(text).exact) == loose


def test_looseness_comes_through_a_call(counts: Counter) -> None:
    text = """
    static sg_real g(int n, sg_real x) { if (n > 2) { x *= 3.0; } return x; }
    sg_real f(int n, sg_real x) { return g(n, x) / g(3, x); }"""
    assert set(CLASSES) - set(counts(text).exact) == {"mul"}
    assert counts(text.replace("g(n, x)", "g(1, x)")).exact == CLASSES
