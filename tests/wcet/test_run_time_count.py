"""What runs is never more than what was counted, and just that where nothing is decided."""

from __future__ import annotations

import ctypes
import random
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from servogen.wcet.dynamic import CountedLibrary, build_counted
from servogen.wcet.operations import OperationCounts
from servogen.wcet.package import Count, count_package

Counter = Callable[..., Count]
Builder = Callable[..., CountedLibrary]

STRAIGHT = """
#include <math.h>
#include <stdint.h>
#include <string.h>
enum { N = 3, A_ITERATION_CAP = 11 };
typedef struct { sg_real x[N]; int32_t n; const sg_real *table; } s_t;
static const sg_real gain = 2.5;
static const sg_real table[N * N] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
static int32_t next(int32_t *n) { *n += 1; return (*n)++ % 7; }
static s_t made(s_t s, int k) { s.x[k] = (sg_real)k; s.table = table; return s; }
static void matvec(int rows, int cols, const sg_real *m, const sg_real *x, sg_real *y)
{
    for (int i = 0; i < rows; i++) {
        sg_real sum = gain;
        for (int j = 0; j < cols; j++) { sum += m[i * cols + j] * x[j]; }
        y[i] = sum;
    }
}
sg_real f(sg_real *x)
{
    int32_t n = 4;
    s_t s = {{0.0}, 2, table};
    s_t t;
    sg_real y[N] = {x[0], gain};
    sg_real grid[2][N];
    memset(&t, 0, sizeof(t));
    matvec(N, N, s.table, x, y);
    for (int k = 0; k < A_ITERATION_CAP; k++) {
        for (int i = N - 1; i >= 0; i--) {
            for (int j = 0; j <= i; ++j) { y[j] -= -x[i] / (gain + fabs(y[j])); }
        }
        if (k % 3 == 2) { y[0] *= 0.5; }
    }
    s.n += next(&n) * n;
    t = made(s, 1 + 1);
    grid[1][2] = t.x[2] + sqrt(4.0 + y[0] * y[0]);
    t.n = (t.n << 2) ^ (~n | 5);
    y[1] = (isfinite(y[1]) + t.n > 2) * 3;
    return grid[1][2] * y[1] - (sg_real)(t.n / 3);
}
"""


@pytest.mark.parametrize("real", ["double", "float"])
def test_equal_on_straight_lines(counts: Counter, counted: Builder, real: str) -> None:
    text = STRAIGHT if real == "double" else STRAIGHT.replace("4.0 +", "(sg_real)4 +")
    if real == "float":
        text = text.replace("0.5;", "0.5f;").replace("fabs", "fabsf").replace("sqrt", "sqrtf")
    prelude = f"typedef {real} sg_real;\n"
    library = counted(text, prelude=prelude)
    element = ctypes.c_double if real == "double" else ctypes.c_float
    library.functions.f((element * 3)(0.5, -1.5, 2.5))
    once = library.read()
    count = counts(text, prelude=prelude)
    # The acceleration every third iteration is spread evenly, rounded up; all else is exact.
    assert count.total().covers(once)
    exact = {n: v for n, v in once.as_dict().items() if n not in ("mul", "load", "store")}
    assert exact == {n: count.total().as_dict()[n] for n in exact}
    assert count.total().mul - once.mul == 11 - 3
    library.functions.f((element * 3)(0.5, -1.5, 2.5))
    assert library.read() == once + once
    library.reset()
    assert library.read() == OperationCounts()


def test_counting_does_not_change_results(counted: Builder, tmp_path: Path) -> None:
    """The counted twin computes the same bits as the C it was made from."""
    source = tmp_path / "plain.c"
    source.write_text("typedef double sg_real;\n" + STRAIGHT, encoding="utf-8")
    plain = tmp_path / "plain.so"
    flags = ["-std=c99", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run(["gcc", *flags, "-o", str(plain), str(source), "-lm"], check=True)
    results = []
    for functions in (counted(STRAIGHT).functions, ctypes.CDLL(str(plain))):
        functions.f.restype = ctypes.c_double
        results.append(functions.f((ctypes.c_double * 3)(0.5, -1.5, 2.5)))
    assert results[0] == results[1]


DECIDING = """
typedef struct { sg_real worst; int row; } state;
static sg_real least(sg_real a, sg_real b) { return a < b ? a : b; }
static void scan(int n, const sg_real *x, state *s)
{
    s->worst = x[0];
    s->row = 0;
    for (int i = 1; i < n; i++) {
        if (x[i] < s->worst) { s->worst = x[i]; s->row = i; }
    }
}
int f(int mode, sg_real *x)
{
    state s;
    if (!(x[0] >= -10.0)) { return -1; }
    scan(12, x, &s);
    for (int i = 0; i < 12 && x[i] < 0.9; i++) {
        if (i == s.row) { continue; }
        if (x[i] > 0.8 || (x[i] > 0.7 && s.worst < 0.05)) { break; }
        x[i] = least(x[i] * 2.0, x[i] / s.worst);
    }
    switch (mode) {
        case 0: x[0] = x[1] + x[2]; /* falls through */
        case 1: x[1] = x[2] * x[3]; break;
        case 2: x[3] = -x[3]; break;
        default: break;
    }
    return s.worst ? s.row : 0;
}
"""


def test_never_more_than_the_bound(counts: Counter, counted: Builder) -> None:
    bound = counts(DECIDING).total()
    library = counted(DECIDING)
    rng = random.Random(4)
    seen = OperationCounts()
    for _ in range(300):
        library.reset()
        values = [rng.random() ** 3 for _ in range(12)]
        library.functions.f(rng.randrange(-1, 4), (ctypes.c_double * 12)(*values))
        assert bound.covers(library.read())
        seen = seen.maximum(library.read())
    assert seen.cmp > bound.cmp // 2  # the bound is not far from what happens


# -- small programs made by hypothesis --------------------------------------------------------

VALUES = ("a", "b", "x[0]", "x[n % 4]", "(sg_real)n", "1.5")
WHOLE = ("n", "m", "k[1]", "k[n & 3]", "2")


@st.composite
def statements(
    draw: st.DrawFn, depth: int, counters: tuple[str, ...] = (), decide: bool = True
) -> str:
    """A few statements on reals a, b, x[4] and integers n, m, k[4]; loops nest to ``depth``.

    Without ``decide`` nothing depends on data, only on loop counters.
    """
    lines = []
    kinds = [0, 1, 3, *([2] if decide else []), *([4, 5] if depth else [])]
    if depth and (decide or counters):
        kinds += [6, 7]
    for _ in range(draw(st.integers(1, 3))):
        kind = draw(st.sampled_from(kinds))
        v, w = draw(st.sampled_from(VALUES)), draw(st.sampled_from(VALUES))
        i, j = draw(st.sampled_from(WHOLE)), draw(st.sampled_from(WHOLE))
        op = draw(st.sampled_from("+-*/"))
        target = draw(st.sampled_from(("a", "b", "x[1]", "x[m & 3]")))
        if kind == 0:
            lines.append(f"{target} = ({v} {op} {w}) * 0.5 + 1.0;")
        elif kind == 1:
            lines.append(f"{draw(st.sampled_from(('n', 'm', 'k[2]')))} = ({i} + {j}) & 15;")
        elif kind == 2:
            lines.append(f"{target} {draw(st.sampled_from('+-*'))}= fabs({v}) < {w} ? {v} : -{w};")
        elif kind == 3:
            size = draw(st.sampled_from((*counters, "2", "3")))
            lines.append(f"a = helper({size}, x, b);")
        elif kind in (4, 5):
            name = f"i{len(counters)}"
            limit = draw(st.sampled_from(("3", "4", *(f"{c} + 1" for c in counters))))
            body = draw(statements(depth - 1, (*counters, name), decide))
            lines.append(f"for (int {name} = 0; {name} < {limit}; {name}++) {{ {body} }}")
        else:
            tests = (f"{v} < {w}", f"{i} > {j} && {v} > 0.5", f"!({v} > 0.1) || {i} == 1")
            known = tuple(f"{c} % 2 == 0" for c in counters)
            test = draw(st.sampled_from((*tests, *known) if decide else known))
            leave = ("", "break;", "continue;") if counters else ("", "return a;")
            then = draw(statements(depth - 1, counters, decide))
            if decide:
                then += draw(st.sampled_from(leave))
            other = draw(statements(depth - 1, counters, decide))
            lines.append(f"if ({test}) {{ {then} }} else {{ {other} }}")
    return "\n".join(lines)


HELPER = """
#include <math.h>
static sg_real helper(int size, const sg_real *x, sg_real start)
{
    sg_real sum = start;
    for (int i = 0; i < size; i++) {
        if (i == 1) { sum = sum * 0.5; }
        sum += x[i & 3];
    }
    return sum > 100.0 ? 1.0 : sum;
}
"""


@settings(
    derandomize=True,
    deadline=None,
    max_examples=10,
    suppress_health_check=[HealthCheck.too_slow],
)
@given(
    st.lists(statements(3), min_size=4, max_size=6),
    st.lists(statements(3, decide=False), min_size=2, max_size=4),
    st.integers(0, 2**31),
)
def test_small_programs(
    tmp_path_factory: pytest.TempPathFactory, deciding: list[str], plain: list[str], seed: int
) -> None:
    bodies = {f"f{i}": body for i, body in enumerate(deciding)}
    bodies |= {f"g{i}": body for i, body in enumerate(plain)}
    text = "typedef double sg_real;\n" + HELPER
    for name, body in bodies.items():
        text += (
            f"sg_real {name}(sg_real *x, int *k, sg_real a, sg_real b, int n, int m)\n"
            f"{{\n{body}\nk[0] = n + m; return a + b;\n}}\n"
        )
    folder = tmp_path_factory.mktemp("program")
    source = folder / "a.c"
    source.write_text(text, encoding="utf-8")
    bounds = count_package([source], [], list(bodies)).entry_points
    library = build_counted([source], [], folder)
    rng = random.Random(seed)
    for name in bodies:
        bound = bounds[name].total()
        for _ in range(5):
            x = (ctypes.c_double * 4)(*(rng.uniform(-1, 2) for _ in range(4)))
            k = (ctypes.c_int * 4)(*(rng.randrange(4) for _ in range(4)))
            reals = [ctypes.c_double(rng.uniform(-1, 2)) for _ in range(2)]
            library.reset()
            getattr(library.functions, name)(x, k, *reals, rng.randrange(4), rng.randrange(4))
            ran = library.read()
            assert bound.covers(ran), f"{name}: {ran} above {bound} in\n{text}"
            for kind in bounds[name].exact:
                assert ran.as_dict()[kind] == bound.as_dict()[kind], f"{name}: {kind} in\n{text}"
            assert name[0] == "f" or ran == bound, f"{name}: {ran} is not {bound} in\n{text}"
