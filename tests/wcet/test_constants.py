"""Integer values as C computes them, seen through loop bounds."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from servogen.wcet.package import Count
from servogen.wcet.refusal import CountRefused

Counter = Callable[..., Count]

TEXT = """
enum {{ FOUR = 4, FIVE, SIX = FOUR + 2 }};
static const int seven = SIX + 1;
typedef struct {{ double x[3]; int n; }} s_t;
static void g(int n, unsigned u, sg_real *x)
{{
    int m = n;
    m += 2;
    m++;
    for (int i = 0; i < ({bound}); i++) {{ x[i] = 0.0; }}
}}
void f(sg_real *x) {{ g(-7, 3u, x); }}
"""


@pytest.mark.parametrize(
    ("bound", "value"),
    [
        ("FIVE * SIX - 0x1F", -1),
        ("n / 2 + 10", 7),  # towards zero
        ("n % 4 + 10", 7),  # sign of the dividend
        ("-n / 2", 3),
        ("seven << 1", 14),
        ("m + 10", 6),
        ("n < 0 ? FIVE : SIX", 5),
        ("(n == -7 && u == 3) + 1", 2),
        ("(n != -7 || !u) + 1", 1),
        ("(int)u + 010", 11),
        ("(int)(sizeof(s_t) / sizeof(double))", 4),
        ("~n & 7", 6),
    ],
)
def test_bound(counts: Counter, bound: str, value: int) -> None:
    assert counts(TEXT.format(bound=bound)).total().store == max(0, value)


@pytest.mark.parametrize(
    "bound",
    [
        "u - 4u",  # wraps around
        "2147483647 + (int)u",
        "n / 0",
        "1 << 40",
        "(int)x[0]",
    ],
)
def test_bound_that_c_does_not_define_or_know(counts: Counter, bound: str) -> None:
    with pytest.raises(CountRefused, match="bound"):
        counts(TEXT.format(bound=bound))


@pytest.mark.parametrize(
    "change",
    [
        "(void)(a > 0 && (n = 4));",
        "(void)(a > 0 ? (n = 4) : 0);",
        "if (a > 0) { n = 4; }",
        "switch (a) { case 1: n = 4; break; default: break; }",
        "for (int i = 0; i < 2 && a; i++) { n = 4; }",
        "set(&n);",
    ],
)
def test_a_value_that_may_have_changed_is_not_known(counts: Counter, change: str) -> None:
    text = f"""
    static void set(int *p) {{ *p = 4; }}
    void f(int a, sg_real *x)
    {{
        int n = 3;
        {change}
        for (int i = 0; i < n; i++) {{ x[i] = 0.0; }}
    }}"""
    with pytest.raises(CountRefused, match=r"unit0\.c:8: .*bound"):
        counts(text)
