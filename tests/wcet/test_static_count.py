"""Counts of C whose operations can be counted by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from servogen.wcet.operations import OperationCounts
from servogen.wcet.package import Count, count_package

Counter = Callable[..., Count]

MATVEC = """
static inline void sg_matvec(int rows, int cols, const sg_real *m, const sg_real *x, sg_real *y)
{
    for (int i = 0; i < rows; i++) {
        sg_real sum = 0.0;
        for (int j = 0; j < cols; j++) {
            sum += m[i * cols + j] * x[j];
        }
        y[i] = sum;
    }
}
"""


def matvec(rows: int, cols: int) -> OperationCounts:
    n = rows * cols
    tests = rows + 1 + rows * (cols + 1)
    return OperationCounts(
        add=n,
        mul=n,
        load=2 * n,
        store=rows,
        int_add=2 * n + rows,
        int_mul=n,
        int_cmp=tests,
        branch=tests,
        call=1,
    )


def test_kernel_with_constants_from_enumeration_and_literals(counts: Counter) -> None:
    text = MATVEC + (
        "enum { N = 3, M = 2 * N };\n"
        "void f(const sg_real *m, const sg_real *x, sg_real *y) { sg_matvec(M, N - 1, m, x, y); }"
    )
    assert counts(text).total() == matvec(6, 2)


def test_each_call_has_its_own_constants(counts: Counter) -> None:
    text = MATVEC + (
        "static void two(int n, const sg_real *m, sg_real *x, sg_real *y)\n"
        "{ sg_matvec(n, n, m, x, y); sg_matvec(n + 1, 2, m, y, x); }\n"
        "void f(const sg_real *m, sg_real *x, sg_real *y) { two(4, m, x, y); two(7, m, x, y); }"
    )
    parts = [matvec(4, 4), matvec(5, 2), matvec(7, 7), matvec(8, 2)]
    want = sum(parts, OperationCounts(call=2, int_add=2))
    assert counts(text).total() == want


def test_triangular_loops_are_summed_exactly(counts: Counter) -> None:
    text = """
    void f(const sg_real *m, sg_real *y)
    {
        for (int i = 0; i < 7; i++) {
            for (int j = i; j >= 0; j--) { y[i] += m[j]; }
            for (int j = 2 * i + 1; j < 15; j += 2) { y[j] *= m[j]; }
        }
    }"""
    total = counts(text).total()
    assert total.add == sum(i + 1 for i in range(7))
    assert total.mul == sum(len(range(2 * i + 1, 15, 2)) for i in range(7))


def test_triangle_through_a_call(counts: Counter) -> None:
    text = MATVEC + (
        "void f(const sg_real *m, sg_real *x, sg_real *y)\n"
        "{ for (int i = 1; i <= 5; i++) { sg_matvec(i, 2, m, x, y); } }"
    )
    assert counts(text).total().mul == 2 * (1 + 2 + 3 + 4 + 5)


@pytest.mark.parametrize(
    ("header", "trips"),
    [
        ("int i = 0; i < 10; ++i", 10),
        ("int i = 0; i <= 10; i += 3", 4),
        ("int i = 9; i >= 0; i--", 10),
        ("int i = 9; i > -4; i -= 5", 3),
        ("int i = 0; 10 > i; i++", 10),
        ("int i = 0; i != 8; i = i + 2", 4),
        ("int i = 5; i < 5; i++", 0),
        ("int i = 0; i < 6 && x[i] > 0.0; i++", 6),
    ],
)
def test_loop_headers(counts: Counter, header: str, trips: int) -> None:
    assert (
        counts(f"void f(sg_real *x) {{ for ({header}) {{ x[0] *= 2.0; }} }}").total().mul == trips
    )


def test_costlier_branch_class_by_class(counts: Counter) -> None:
    text = """
    sg_real f(int a, sg_real x)
    {
        if (a > 3) { x = x * x * x; } else { x = x + x / x; }
        return a == 1 ? x * 2.0 : -x;
    }"""
    want = OperationCounts(mul=3, add=1, div=1, neg=1, int_cmp=2, branch=2)
    assert counts(text).total() == want


def test_known_condition_takes_one_branch(counts: Counter) -> None:
    text = """
    static sg_real g(int mode, sg_real x)
    {
        if (mode == 2) { x = x * x; } else { x = x / x; }
        return x;
    }
    sg_real f(sg_real x) { return g(2, x) + g(3, x) + g(2, x); }"""
    total = counts(text).total()
    assert (total.mul, total.div, total.call) == (2, 1, 3)


def test_what_follows_an_early_return_belongs_to_the_other_way(counts: Counter) -> None:
    text = """
    sg_real f(int a, sg_real x)
    {
        if (a < 0) { return x * x; }
        x = x * x * x;
        if (a < 9) { x = x / x; } else { return x; }
        return x * x;
    }"""
    total = counts(text).total()
    assert (total.mul, total.div) == (3, 1)


def test_break_and_continue_do_not_shorten_a_loop(counts: Counter) -> None:
    text = """
    void f(sg_real *x)
    {
        for (int i = 0; i < 5; i++) {
            if (x[i] > 1.0) { break; }
            if (x[i] > 0.5) { continue; }
            x[i] = x[i] * 2.0;
        }
    }"""
    assert counts(text).total().mul == 5


def test_logical_operators_count_all_operands(counts: Counter) -> None:
    total = counts("int f(sg_real a, sg_real b) { return a > 0.0 && (b > 0.0 || a < b); }").total()
    assert (total.cmp, total.branch, total.int_cmp) == (3, 2, 0)


def test_switch_with_fall_through(counts: Counter) -> None:
    text = """
    sg_real f(int a, sg_real x)
    {
        switch (a) {
            case 0: x = x * x;
            case 1: x = x * x; break;
            default: x = x / x; break;
        }
        return x;
    }"""
    want = OperationCounts(mul=2, div=1, int_cmp=2, branch=2)
    assert counts(text).total() == want


def test_integers_and_reals_are_told_apart(counts: Counter) -> None:
    text = """
    #include <stdint.h>
    typedef struct { sg_real gain; int32_t n; const sg_real *table; } s_t;
    static sg_real twice(sg_real a) { return a + a; }
    sg_real f(s_t *s, uint32_t k, const int *map)
    {
        int j = map[k] + 1;
        s->n = s->n * j;
        s->gain = s->gain * s->table[j];
        return twice((sg_real)k) + (sg_real)(j / 2);
    }"""
    want = OperationCounts(
        add=2,
        mul=1,
        convert=2,
        load=2,
        store=1,
        int_add=1,
        int_mul=1,
        int_div=1,
        int_load=3,
        int_store=1,
        call=1,
    )
    assert counts(text).total() == want


def test_memory_model(counts: Counter) -> None:
    text = """
    typedef struct { sg_real x[2]; int n; } s_t;
    static const sg_real gain = 3.0;
    static void g(sg_real *p) { *p = gain; }
    sg_real f(s_t *to, const s_t *from)
    {
        sg_real taken = 1.0;
        sg_real t[3] = {0.0};
        *to = *from;
        g(&taken);
        return taken + t[1];
    }"""
    want = OperationCounts(
        add=1, load=1 + 2 + 2, store=1 + 3 + 2 + 1, int_load=1, int_store=1, call=1
    )
    assert counts(text).total() == want


def test_literals_and_enumerations_fold(counts: Counter) -> None:
    text = "enum { N = 4 };\nsg_real f(sg_real x) { return x * (sg_real)(N * 2 + 1) + -1.0 / 3.0; }"
    assert counts(text).total() == OperationCounts(mul=1, add=1)


def test_library_functions(counts: Counter) -> None:
    text = """
    #include <math.h>
    #include <string.h>
    typedef struct { sg_real x[5]; int n; } s_t;
    sg_real f(s_t *s, s_t *t, sg_real a)
    {
        memset(s, 0, sizeof(*s));
        memcpy(s, t, sizeof(s_t));
        return isfinite(a) ? sqrt(fabs(a)) : fmax(a, 0.0);
    }"""
    want = OperationCounts(
        neg=1, sqrt=1, cmp=1, other_fp=1, branch=1, int_store=24, int_load=12, call=2
    )
    assert counts(text).total() == want


def test_float_package_counts_like_a_double_one(counts: Counter) -> None:
    text = "sg_real f(sg_real a) { return a * 2.0f + (sg_real)0.1; }"
    assert counts(text, prelude="typedef float sg_real;\n").total() == OperationCounts(mul=1, add=1)


def test_several_files_with_tables_and_a_shared_header(tmp_path: Path) -> None:
    (tmp_path / "k.h").write_text("typedef double sg_real;\n" + MATVEC, encoding="utf-8")
    (tmp_path / "tables.h").write_text("extern const double table[6];\n", encoding="utf-8")
    values = ", ".join(f"{i}.25e-3" for i in range(6))
    long_table = f"const double big[300] = {{{', '.join(['-1.5'] * 300)}}};\n"
    (tmp_path / "tables.c").write_text(
        f'#include "tables.h"\nconst double table[6] = {{{values}}};\n'
        f"{long_table}static const int open[] = {{1, 2, 3}};\n",
        encoding="utf-8",
    )
    (tmp_path / "a.c").write_text(
        '#include "k.h"\n#include "tables.h"\nvoid g(const sg_real *x, sg_real *y);\n'
        "void f(const sg_real *x, sg_real *y) { sg_matvec(2, 3, table, x, y); g(x, y); }",
        encoding="utf-8",
    )
    (tmp_path / "b.c").write_text(
        '#include "k.h"\n#include "tables.h"\n'
        "void g(const sg_real *x, sg_real *y) { sg_matvec(3, 2, table, x, y); }",
        encoding="utf-8",
    )
    files = [tmp_path / n for n in ("a.c", "b.c", "tables.c")]
    result = count_package(files, [tmp_path], ["f", "g"])
    assert result.entry_points["g"].total() == matvec(3, 2)
    want = matvec(2, 3) + matvec(3, 2) + OperationCounts(call=1)
    assert result.entry_points["f"].total() == want
    assert result.table_bytes == {"table": 48, "big": 2400, "open": 12}
    assert result.total_table_bytes == 2460
    assert result.precision == "float64"


def test_stack_is_the_deepest_chain(counts: Counter) -> None:
    text = """
    static void leaf(sg_real *x) { sg_real t[10]; t[0] = *x; *x = t[0]; }
    static void small(sg_real *x) { *x = 0.0; }
    void f(sg_real *x) { sg_real y[2]; int n = 0; leaf(x); small(x); small(y); x[n] = y[0]; }"""
    assert counts(text).stack_bytes == (4 + 16 + 4) + (4 + 80)
