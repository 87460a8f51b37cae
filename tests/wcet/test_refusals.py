"""C without a provable worst case is refused, by file and line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from servogen.errors import CheckFailed, InputError
from servogen.wcet.package import Count, count_package
from servogen.wcet.refusal import CountRefused

Counter = Callable[..., Count]

# Text from line 2 on (line 1 is the typedef), the line at fault, a word of the message.
CASES = [
    ("void f(int n)\n{\n while (n > 0) { n--; }\n}", 4, "while"),
    ("void f(int n)\n{\n do { n--; } while (n > 0);\n}", 4, "do loop"),
    ("int f(int n)\n{\n return n > 0 ? f(n - 1) : 0;\n}", 4, "calls itself"),
    ("int g(int n);\nint f(int n) { return g(n); }\nint g(int n)\n{ return f(n); }", 5, "itself"),
    ("void f(void (*g)(void))\n{\n g();\n}", 4, "function pointer"),
    ("static void g(void) {}\nvoid f(void)\n{ void (*h)(void) = g; h(); }", 4, "pointer"),
    ("typedef struct { int (*g)(void); } s_t;\nint f(s_t *s)\n{\n return s->g(); }", 5, "pointer"),
    ("void f(int n, sg_real *x)\n{\n for (int i = 0; i < n; i++) { x[i] = 0.0; } }", 4, "bound"),
    ("void f(sg_real *x)\n{\n for (int i = 0; i < 9; i += (int)x[0]) { } }", 4, "step"),
    (
        "typedef struct { int n; } s_t;\nvoid f(s_t *s)\n{ for (int i = 0; i < s->n; i++) { } }",
        4,
        "",
    ),
    ("void f(void)\n{\n for (int i = 0; i < 9; i++) { i = 3; } }", 4, "own counter"),
    ("void f(void)\n{\n for (int i = 0; i < 9; i--) { } }", 4, "away from its bound"),
    ("void f(void)\n{\n for (int i = 0; i != 9; i += 2) { } }", 4, "over its end"),
    ("void f(void)\n{\n for (unsigned i = 9; i >= 0; i--) { } }", 4, "below zero"),
    ("void f(unsigned i)\n{\n for (i = 9; i >= 0; i--) { } }", 4, "below zero"),
    ("void f(void)\n{\n for (;;) { } }", 4, "one counter"),
    ("void f(int *p)\n{\n for (int i = 0; *p < 9; i++) { } }", 4, "no bound"),
    (
        "void g(int *p) { *p = 0; }\nvoid f(void)\n{\n for (int i = 0; i < 9; i++) { g(&i); } }",
        5,
        "",
    ),
    ("int f(int n)\n{\n again: if (n > 3) { goto again; }\n return n; }", 4, "goto"),
    ("void g(int n);\nvoid f(int n)\n{\n g(n); }", 5, "'g' has no body"),
    ("void f(int n)\n{\n g(n); }", 4, "'g' is not declared"),
    ("sg_real f(sg_real x)\n{\n return x * 2.0f + (float)x; }", 4, "float where sg_real is double"),
    ("void f(int n)\n{\n int i = n;\n { int i = 3; i++; } }", 5, "hides"),
    ("void f(int n)\n{\n sg_real x[n];\n x[0] = 0.0; }", 4, "length is not a constant"),
    ("#include <string.h>\nvoid f(int n, int *p)\n{\n memset(p, 0, n); }", 5, "size"),
    ("#include <math.h>\nsg_real f(sg_real x)\n{\n return sin(x); }", 5, "'sin' is not declared"),
    ("double sin(double x);\nsg_real f(sg_real x)\n{\n return sin(x); }", 5, "'sin' has no body"),
    ("void f(void)\n{\n while (1) { }\n}", 4, "while"),
    ("void f(int n)\n{\n int i = 0;\n do { i++; } while (i < n && i < 9);\n}", 5, "do loop"),
    # a counter that wraps around never ends
    ("void f(void)\n{\n for (signed char i = 0; i < 200; i++) { } }", 4, "does not hold"),
    ("void f(void)\n{\n unsigned short i;\n for (i = 0; i <= 65535; i++) { } }", 5, "not hold"),
    ("void f(void)\n{\n for (unsigned i = 0; i < -1; i++) { } }", 4, "unsigned"),
    ("void f(void)\n{\n for (int i = -3; i > 4u; i--) { } }", 4, "unsigned"),
    ("void f(void)\n{\n for (sg_real x = 0; x < 9; x++) { } }", 4, "no integer"),
    # one that others may change
    ("static int i;\nvoid f(void)\n{\n for (i = 0; i < 9; i++) { } }", 5, "not a variable of"),
    ("void f(void)\n{\n volatile int n = 3;\n for (int i = 0; i < n; i++) { } }", 5, "bound"),
    (
        "static const volatile int n = 3;\nvoid f(void)\n{\n for (int i = 0; i < n; i++) { } }",
        5,
        "bound",
    ),
    ("void f(void)\n{\n for (volatile int i = 0; i < 9; i++) { } }", 4, "counter"),
    ("void f(volatile int n)\n{\n n = 3;\n for (int i = 0; i < n; i++) { } }", 5, "bound"),
    ("void f(void)\n{\n static int i;\n for (i = 0; i < 9; i++) { } }", 5, "not a variable of"),
    ("void f(int k)\n{\n for (int i = 0; k < 9; i++) { k++; } }", 4, "no bound"),
    ("void f(int k)\n{\n for (int i = 1; i < 9; i *= 2) { } }", 4, "step"),
    ("void f(int *p)\n{\n for (int i = 0; i < *p; i++) { } }", 4, "bound"),
]


@pytest.mark.parametrize(("text", "line", "word"), CASES)
def test_refused_with_line(counts: Counter, text: str, line: int, word: str) -> None:
    with pytest.raises(CountRefused) as caught:
        counts(text)
    assert f"unit0.c:{line}: cannot count: " in str(caught.value)
    assert word in str(caught.value)
    assert caught.value.exit_status == 1


def test_bound_lost_in_a_branch(counts: Counter) -> None:
    text = """void f(int a)
    {
        int n = 3;
        if (a > 0) { n = 4; }
        for (int i = 0; i < n; i++) { }
    }"""
    with pytest.raises(CountRefused, match=r"unit0\.c:6: .*bound"):
        counts(text)


def test_bound_changed_by_an_earlier_iteration(counts: Counter) -> None:
    text = """void f(sg_real *x)
    {
        int n = 3;
        for (int i = 0; i < 5; i++) {
            for (int j = 0; j < n; j++) { x[j] = 0.0; }
            n = n * 2;
        }
    }"""
    with pytest.raises(CountRefused, match=r"unit0\.c:6: .*bound"):
        counts(text)


def test_same_function_with_a_constant_and_without(counts: Counter) -> None:
    text = """static void g(int n) { for (int i = 0; i < n; i++) { } }
    void f(int m) { g(3);
    g(m); }"""
    with pytest.raises(CountRefused, match=r"unit0\.c:2: .*bound"):
        counts(text)


def test_line_of_an_included_header(tmp_path: Path) -> None:
    (tmp_path / "k.h").write_text("\n\nstatic void g(int n)\n{ while (n) { n--; } }\n")
    (tmp_path / "a.c").write_text('#include "k.h"\nvoid f(void) { g(3); }\n')
    with pytest.raises(CountRefused, match=r"k\.h:4: "):
        count_package([tmp_path / "a.c"], [tmp_path], ["f"])


def test_unknown_entry_point(counts: Counter) -> None:
    with pytest.raises(CountRefused, match="entry point 'h' is not defined"):
        counts("void f(void) { }", entry="h")


def test_files_that_are_not_there_or_not_c(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a C file"):
        count_package([tmp_path / "none.c"], [], ["f"])
    (tmp_path / "a.c").write_text("#include <stdio.h>\n")
    with pytest.raises(CheckFailed, match=r"stdio\.h"):
        count_package([tmp_path / "a.c"], [], ["f"])
    (tmp_path / "b.c").write_text("int f( {\n")
    with pytest.raises(CheckFailed, match="C99"):
        count_package([tmp_path / "b.c"], [], ["f"])


def test_no_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.c").write_text("void f(void) { }\n")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="gcc is missing"):
        count_package([tmp_path / "a.c"], [], ["f"])
