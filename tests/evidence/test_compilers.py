"""The compiler matrix on designs of every shape, and what it says of C that is not as it should."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from core_designs import VARIANTS, Variant, design, package, temporary_folder

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.package import CPackage, emit_package
from servogen.evidence import compilers, compilers_objects, compilers_strict
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.compilers_found import Compiler, Found, find_compilers
from servogen.evidence.compilers_play import compare
from servogen.evidence.tools import ToolMissing, demand
from servogen.precision import FLOAT32
from servogen.progress import Silent
from servogen.sil.player import Play
from servogen.sil.scenarios import suite

SMALL = Variant(prefix="small", horizon=2, points=5, ramp=1, cap=20, precision="float32")


def found(name: str) -> Compiler:
    """A compiler of the matrix; gcc and zig are where the tests are."""
    return next(c for c in find_compilers().compilers if c.name == name)


def written(made: CPackage) -> Path:
    folder = temporary_folder("compilers")
    compilers_strict.write(made, folder)
    return folder


@pytest.mark.parametrize("name", VARIANTS)
def test_every_package_passes_strict_compilation(name: str) -> None:
    made = package(VARIANTS[name])
    folder = written(made)
    assert compilers_strict.sources(made, found("gcc"), "-O2", folder) == []
    assert compilers_objects.faults(made, folder) == []
    assert compilers_objects.misplaced_tables(made) == []
    if name in ("governor alone", "M = 2", "plain PQP"):  # zig takes a second for each
        assert compilers_strict.sources(made, found("zig 64-bit"), "-O0", folder) == []


def test_32_bit_16_bit_int_and_big_endian() -> None:
    for name in ("axes differ", "example"):
        made = package(VARIANTS[name])
        folder = written(made)
        for target in ("32-bit", "msp430, 16-bit int", "powerpc, big-endian"):
            assert compilers_strict.sources(made, found(f"zig {target}"), "-O0", folder) == []


@pytest.mark.parametrize("name", ["governor alone", "axes differ"])
def test_headers_stand_alone_and_serve_cpp(name: str) -> None:
    made = package(VARIANTS[name])
    folder = written(made)
    assert compilers_strict.headers(made, found("gcc"), folder) == []
    assert len(compilers_strict.header_files(made)) == sum(n.endswith(".h") for n in made.code)
    compiler = next(c for c in find_compilers().compilers if c.plus)
    for standard in ("c++98", "c++20"):
        assert compilers_strict.from_cpp(compiler, standard, folder) == []


def test_nothing_from_libc_is_called() -> None:
    """At -O2 and -O3 gcc turns the loops that fill and copy into memset, memcpy and memmove: what
    C asks of a freestanding implementation too. With one flag it leaves them alone."""
    made = package(VARIANTS["axes differ"])
    folder = written(made)
    for flags, allowed in (
        (["-O1"], set()),
        (["-O3", "-fno-tree-loop-distribute-patterns"], {"memcpy"}),  # a struct copied whole
    ):
        demand(["gcc", "-std=c99", *flags, "-c", *made.sources], "gcc", folder)
        said = demand(["nm", "-u", *(s.replace(".c", ".o") for s in made.sources)], "nm", folder)
        names = {line.split()[1] for line in said.splitlines() if line.strip().startswith("U ")}
        outside = {name for name in names if not name.startswith("core_")}
        assert outside - {"_GLOBAL_OFFSET_TABLE_"} <= allowed


def governor() -> CPackage:
    return emit_package("small", (declare_parts(design(SMALL))[0],))


def changed(file: str, old: str, new: str) -> CPackage:
    made = governor()
    assert old in made.files[file]
    return replace(made, files={**made.files, file: made.files[file].replace(old, new, 1)})


SOURCE = "small_governor.c"
OPEN = "    sg_status status = SG_OK;\n"
WARNED = {
    "unused": f"{OPEN}    int32_t spare;\n",
    "double-promotion": f"{OPEN}    if ((in->last_x * 2.0) > 1.0f) {{ status = SG_OK; }}\n",
    "conversion": f"{OPEN}    int8_t small = in->n_points;\n    (void)small;\n",
    "shadow": f"{OPEN}    {{ const int32_t status = 1; (void)status; }}\n",
    "pedantic": f"{OPEN}    int32_t none[0];\n    (void)none;\n",
}


@pytest.mark.parametrize("name", WARNED)
@pytest.mark.parametrize("compiler", ["gcc", "zig 64-bit"])
def test_a_warning_is_a_fault(name: str, compiler: str) -> None:
    made = changed(SOURCE, OPEN, WARNED[name])
    assert compilers_strict.sources(made, found(compiler), "-O0", written(made))


def test_a_header_that_needs_another_or_is_no_cpp_is_a_fault() -> None:
    made = changed("small_governor.h", '#include "small_types.h"\n', "")
    assert compilers_strict.headers(made, found("gcc"), written(made))
    made = changed("small_governor.h", "#ifndef SMALL_GOVERNOR_H\n", "#ifndef OTHER_H\n")
    assert compilers_strict.headers(made, found("gcc"), written(made))
    made = changed("small_governor.h", "int32_t n_points;", "int32_t n_points; int32_t class;")
    compiler = next(c for c in find_compilers().compilers if c.plus)
    assert compilers_strict.from_cpp(compiler, "c++11", written(made))


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("int32_t small_count;\n", "small_count can be written and is global"),
        ("static int32_t here = 1;\nint32_t *small_here(void);\n"
         "int32_t *small_here(void) { return &here; }\n", "here can be written and is global"),
        ("void away(void);\nvoid small_go(void);\nvoid small_go(void) { away(); }\n",
         "away is called, which is no part of the package"),
        ("void go(void);\nvoid go(void) { }\n", "go does not begin with small_"),
    ],
)  # fmt: skip
def test_what_the_objects_hold_is_seen(line: str, told: str) -> None:
    head = '#include "small_scalar.h"\n'
    made = changed(SOURCE, head, head + line)
    folder = written(made)
    assert compilers_strict.sources(made, found("gcc"), "-O0", folder) == []
    assert told in compilers_objects.faults(made, folder)


def test_a_table_in_the_code_or_nowhere_is_a_fault() -> None:
    numbers = ", ".join("1.5f" for _ in range(20))
    made = changed(SOURCE, OPEN, f"{OPEN}    static const sg_real t[20] = {{ {numbers} }};\n")
    assert compilers_objects.misplaced_tables(made) == [f"{SOURCE} holds a table of 20 numbers"]
    made = governor()
    files = {name: text for name, text in made.files.items() if not name.endswith("_tables.h")}
    missing = compilers_objects.misplaced_tables(replace(made, files=files))
    assert len(missing) == sum(bool(t.values.size) for t in made.declarations[0].tables) > 0


def test_a_compiler_that_makes_nothing_is_a_fault() -> None:
    """As zig does with the second of two files, and says nothing."""
    idle = Compiler("idle", "gcc", "1", ("true",))
    made = governor()
    assert compilers_strict.sources(made, idle, "-O0", written(made)) == [
        f"{SOURCE}: no object, exit status 0"
    ]
    assert Compiler("none", "gcc", "1", ("false",)).refusal() == "no message"


def plays() -> list[Play]:
    return [
        Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
        for case in suite(design(SMALL), 3, 20)
    ]


def test_the_bits_are_compared_and_other_arithmetic_is_seen(tmp_path: Path) -> None:
    gcc = found("gcc")
    loose = replace(gcc, name="loose", command=("gcc", "-ffast-math"))
    unlinked = replace(gcc, name="unlinked", command=("gcc", "-nostdlib", "-nostartfiles"))
    first = replace(gcc, name="first")
    told = compare(package(SMALL), plays(), [first, first, loose, unlinked], tmp_path)
    assert told.same == ("first -O2", "first -O2")
    assert len(told.faults) == 1
    assert told.faults[0].startswith("loose -O2 against first -O2: ")
    assert [text.partition(",")[0] for text in told.not_run] == ["unlinked -O2"]
    assert told.calls > 500
    assert compare(package(SMALL), [], [first], tmp_path).faults == ("no call was played",)


def bench() -> Bench:
    made = package(SMALL)
    subject = Subject(made, FLOAT32, None, lambda count: plays(), lambda n: plays()[:1])  # type: ignore[arg-type]
    return Bench("small", (subject,))


def test_without_a_clang_the_check_does_not_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    gcc = replace(found("gcc"), name="gcc only", further=True)
    monkeypatch.setattr(
        compilers, "find_compilers", lambda: Found((gcc,), ("clang: apt-get install clang",))
    )
    finding = compilers.run(bench(), Silent())
    assert not finding.passed
    assert finding.faults == ("no clang was run: pip install ziglang, or apt-get install clang",)
    assert finding.not_run == ("clang: apt-get install clang",)
    assert finding.line.endswith("; not run: clang")
    assert finding.figures["compilations"]["gcc only -O2"] == 1


def test_without_gcc_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(ToolMissing, match="apt-get install gcc"):
        find_compilers.__wrapped__()
