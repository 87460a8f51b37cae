"""Turns of loops up to a named bound, seen while the C runs."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path

import pytest
from pycparser import c_parser

from servogen.wcet.dynamic import CountedLibrary
from servogen.wcet.turns import watched_bounds
from servogen.wcet.unit import Unit

TEXT = """
enum { X_ITERATION_CAP = 9, T_TREE_DEPTH = 4 };
double f(int stop, double x)
{
    for (int k = 1 - 1; k < X_ITERATION_CAP; k++) {
        if (k == stop) { break; }
        if (k == X_ITERATION_CAP - 1) { x = 3.0; }
        x = x * 2.0;
    }
    for (int level = 0; level < T_TREE_DEPTH; ++level) { x = x + 1.0; }
    return x;
}
"""
OTHER = "\ndouble h(int n, double x);\ndouble g(double x) { HOW }\n"


def unit(text: str) -> Unit:
    return Unit(Path("a.c"), c_parser.CParser().parse(text))


def test_bounds_of_plain_loops_are_watched() -> None:
    assert watched_bounds([unit(TEXT)]) == ("T_TREE_DEPTH", "X_ITERATION_CAP")


@pytest.mark.parametrize(
    "how",
    [
        "return h(X_ITERATION_CAP, x);",
        "int n = X_ITERATION_CAP; return n + x;",
        "int n; n = X_ITERATION_CAP; return n + x;",
        "return X_ITERATION_CAP;",
        "for (int k = 1; k <= X_ITERATION_CAP; k++) { x = 1.0; } return x;",
        "for (int k = 0; k < X_ITERATION_CAP; k += 1) { x = 1.0; } return x;",
    ],
)
def test_a_bound_that_is_handed_on_is_not(how: str) -> None:
    assert watched_bounds([unit(TEXT + OTHER.replace("HOW", how))]) == ("T_TREE_DEPTH",)


@pytest.mark.parametrize(("stop", "turns"), [(0, 1), (4, 5), (99, 9)])
def test_the_most_turns_are_kept(
    counted: Callable[..., CountedLibrary], stop: int, turns: int
) -> None:
    library = counted(TEXT)
    library.functions.f(stop, ctypes.c_double(1.0))
    seen = (ctypes.c_ulonglong * 2).in_dll(library.functions, "sg_turns")
    assert list(seen) == [4, turns]
    library.functions.f(0, ctypes.c_double(1.0))
    assert list(seen) == [4, turns]
