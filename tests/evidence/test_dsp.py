"""What TI's compiler is told is true; the package divides by itself; the C6000 compiler agrees."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from core_designs import Variant, design, package, temporary_folder
from small_bench import bench, changed

from servogen.evidence import dsp
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.dsp_pragmas import Told, examine_pragmas
from servogen.evidence.dsp_toolchain import COMPILER, toolchain
from servogen.evidence.tools import ToolMissing, cache_dir
from servogen.progress import Silent
from servogen.resources import resource_dir
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import compare
from servogen.sil.scenarios import suite

BASE = Variant("dsp", horizon=5, cap=12)
SHORT = Variant("dsp1", horizon=1, cap=3, precision="float32", period=0, ramp=0)
BUILT = cache_dir() / "tic6x-elf" / "bin" / COMPILER
needs_compiler = pytest.mark.skipif(not BUILT.is_file(), reason=f"no {COMPILER}: make dsp")

DIVISION = """
#include <stdint.h>
#include <stdio.h>
typedef %s sg_real;
#define SG_REAL_BITS %d
#include "sg_division.h"
static uint64_t state = 88172645463325252u;
static uint64_t draw(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state * 0x9E3779B97F4A7C15u;
}
/* all magnitudes; ends of the range; numbers below the normal ones; quotients near those */
static sg_real number(int kind, int which)
{
    static const uint64_t ends[] = { 0u, 1u, SG_ONE - 1u, SG_ONE, SG_ONE + 1u, SG_INFINITE - 1u,
        SG_INFINITE, SG_INFINITE + 1u, (uint64_t)(SG_TOP / 2) << SG_BITS };
    uint64_t bits = draw() >> ((SG_SPARE == 1) ? 32 : 0);
    if (kind == 1) { bits = ends[draw() %% 9u] | (bits & SG_SIGN); }
    if (kind == 2) { bits &= SG_SIGN | (SG_ONE - 1u); }
    if (kind == 3) {
        const uint64_t exponent = (which == 0) ? draw() %% 60u : (SG_TOP / 2u) + (draw() %% 40u);
        bits = (bits & (SG_ONE - 1u)) | (exponent << SG_BITS);
    }
    return sg_from_image(bits);
}
int main(void)
{
    long small = 0;
    for (int i = 0; i < 2000000; i++) {
        const sg_real a = number(i & 3, 0);
        const sg_real b = number((i >> 2) & 3, 1);
        const sg_real right = a / b;
        const sg_real ours = sg_divide(a, b);
        const uint64_t size = sg_to_image(right) & (SG_SIGN - 1u);
        small += (size > 0u) && (size < SG_ONE);
        if ((right != right) ? (ours == ours) : (sg_to_image(right) != sg_to_image(ours))) {
            printf("%%a / %%a is not %%a\\n", (double)a, (double)b, (double)ours);
            return 1;
        }
    }
    printf("%%ld\\n", small);
    return 0;
}
"""


@cache
def subjects() -> tuple[Subject, ...]:
    return (bench(BASE).subjects[0], bench(SHORT).subjects[0])


def told(subject: Subject, folder: Path) -> Told:
    declarations = subject.package.declarations
    entries = [f"{d.prefix}_{op.name}" for d in declarations for op in d.operations]
    return examine_pragmas(subject.write(folder), folder, entries)


@pytest.mark.parametrize("number", [0, 1])
def test_what_is_told_is_true(number, tmp_path):
    result = told(subjects()[number], tmp_path)
    assert result.faults == []
    assert 0 < result.loops_told <= result.loops
    assert result.tables == result.tables_aligned > 0


LIES = (
    ("dsp_mpc.c", 'ITERATE(5, 5)")', 'ITERATE(1, 4)")', "(1, 4), but the loop turns 5 times"),
    ("sg_pqp.h", "ITERATE(1)", "ITERATE(28)", "(28), but the loop turns 18 times"),
    ("dsp_mpc.c", "ITERATE(1, 12)", "ITERATE(12, 12)", "(12, 12), but the loop turns 1 times"),
    ("dsp_governor.c", "    for (int i", "    ;\n    for (int i", "is not before a loop"),
    ("dsp_mpc_tables.h", "ALIGN(dsp_mpc_b,", "ALIGN(dsp_mpc_c,", "is not before what it names"),
    (
        "dsp_mpc_tables.h",
        'SG_PRAGMA("DATA_ALIGN(dsp_mpc_floor, 8)")',
        "",
        "1 tables are not aligned",
    ),
    ("dsp_follower.c", "MUST_ITERATE(3", "MUST_REPEAT(3", "is not one of ours"),
)


def test_lies_are_found(tmp_path):
    """All at once: each has a sentence of its own, and there are no others."""
    honest = subjects()[0]
    made = honest.package
    for file, old, new, _ in LIES:
        made = changed(made, file, old, new)
    faults = told(replace(honest, package=made), tmp_path).faults
    assert [said for *_, said in LIES if not any(said in fault for fault in faults)] == []
    assert len(faults) == len(LIES)


def test_the_c_stays_c_around_the_pragmas(tmp_path):
    honest = subjects()[0]
    made = changed(honest.package, "sg_compiler.h", "_Pragma(text)", "_Pragma(text) int")
    faults = told(replace(honest, package=made), tmp_path).faults
    assert any("with TI's macros: " in fault for fault in faults)


@pytest.mark.parametrize(("real", "bits"), [("float", 32), ("double", 64)])
def test_own_division_is_that_of_the_processor(real, bits, tmp_path):
    (tmp_path / "divide.c").write_text(DIVISION % (real, bits))
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror"]
    include = f"-I{resource_dir('c_runtime')}"
    subprocess.run(["gcc", *flags, include, "divide.c", "-o", "divide"], cwd=tmp_path, check=True)
    done = subprocess.run(["./divide"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert int(done.stdout) > 10_000  # quotients below the normal numbers were among them


def test_with_own_division_the_bits_are_those_of_the_reference():
    """In float64; in float32 the sanitizers' test plays it."""
    folder = temporary_folder("dsp-own")
    module = compile_package([package(BASE)], folder, ["-O1", "-DSG_OWN_DIVISION"])
    for case in suite(design(BASE), 5, 6):
        reference = case.reference()
        agreement = compare(
            reference, CompiledController(module, reference.declaration), case.calls
        )
        assert agreement.passed, agreement.difference


def test_without_compiler_and_sources_it_says_what_to_install(tmp_path, monkeypatch):
    for tool in ("sh", "ls", "head"):
        (tmp_path / tool).symlink_to(str(shutil.which(tool)))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ToolMissing, match="apt-get install gcc-12-source binutils-source"):
        toolchain(Silent(), tmp_path / "home")
    assert not (tmp_path / "home").exists()


def test_a_compiler_that_is_there_is_not_built_again(tmp_path):
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / COMPILER).touch()
    assert toolchain(Silent(), tmp_path) == tmp_path / "bin"


def build_with(tmp_path: Path, **fakes: str) -> tuple[subprocess.CompletedProcess[str], Path]:
    """The build script with stand-ins for its tools; and where its result has to be."""
    tools, home = tmp_path / "tools", tmp_path / "kept" / "tic6x-elf"
    tools.mkdir()
    home.parent.mkdir()
    quiet = dict.fromkeys(("gcc", "g++", "make", "flex", "bison", "xz", "tar"), "exit 0")
    # the source packages "are there" as well
    for name, text in {**quiet, "ls": "echo $1", **fakes}.items():
        (tools / name).write_text(f"#!/bin/sh\n{text}\n")
        (tools / name).chmod(0o755)
    script = resource_dir("c_runtime") / "dsp" / "build_toolchain.sh"
    env = os.environ | {"PATH": f"{tools}:{os.environ['PATH']}", "HOME_OF_RESULT": str(home)}
    done = subprocess.run(
        ["sh", str(script), str(home)], env=env, capture_output=True, text=True, check=False
    )
    return done, home


def test_a_build_that_fails_leaves_only_its_log(tmp_path):
    done, home = build_with(tmp_path, tar="exit 1")
    assert done.returncode != 0
    assert "unpacking binutils" in done.stdout
    assert [path.name for path in home.parent.iterdir()] == ["tic6x-elf.log"]


def test_a_build_that_ends_well_is_moved_into_place(tmp_path):
    """``tar`` unpacks a configure script, ``make`` installs a compiler below DESTDIR."""
    unpack = 'printf "#!/bin/sh\\n" > "$2/configure"; chmod +x "$2/configure"'
    install = """for word; do case $word in DESTDIR=*)
        bin="${word#DESTDIR=}$HOME_OF_RESULT/bin"; mkdir -p "$bin"
        printf "#!/bin/sh\\necho made\\n" > "$bin/tic6x-elf-gcc"; chmod +x "$bin/tic6x-elf-gcc";;
    esac; done"""
    done, home = build_with(tmp_path, tar=unpack, make=install)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("installing gcc\nmade\n")
    assert [path.name for path in home.parent.iterdir()] == ["tic6x-elf"]
    assert (home / "bin" / COMPILER).is_file()


@pytest.mark.tools
@needs_compiler
def test_the_small_cascades_pass(tmp_path):
    finding = dsp.run(bench(BASE), Silent())
    assert finding.passed, finding.faults
    assert finding.figures["float64"]["division_by"] == ["__c6xabi_divd"]
    assert finding.figures["float32"]["division_by"] == ["__c6xabi_divf"]
    assert finding.figures["float64"]["foreign_with_own_division"] == []
    sizes = finding.figures["float64"]["bytes"]["dsp_mpc.c"]
    assert sizes["text"] > 1000
    tables = sum(8 * t.values.size for t in package(BASE).declarations[1].tables)
    assert 0.9 * tables < sizes["rodata"] < 1.2 * tables  # a short one may end in the code
    assert finding.figures["float64"]["bytes"].keys() == set(package(BASE).sources)


@pytest.mark.tools
@needs_compiler
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("SG_DIVIDE(upper[i] * up, down)", "((upper[i] * up) / down)", "__c6xabi_div"),
        ("const sg_real half =", "const int half =", "does not compile"),
    ],
)
def test_a_warning_or_a_call_is_found(old, new, said):
    honest = subjects()[0]
    made = changed(honest.package, "sg_pqp.h", old, new)
    finding = dsp.run(Bench("dsp", (replace(honest, package=made),)), Silent())
    assert not finding.passed
    assert any(said in fault for fault in finding.faults), finding.faults


@pytest.mark.tools
@needs_compiler
def test_a_call_outside_the_package_is_named(tmp_path):
    text = "struct s { int a[99]; }; void f(struct s *x, struct s *y); double g(double a);\n"
    text += "void f(struct s *x, struct s *y) { *x = *y; } double g(double a) { return 1.0 / a; }\n"
    source = tmp_path / "outside.c"
    source.write_text(text)
    built = dsp.compile_all(BUILT.parent, tmp_path, [source], [])
    assert built.faults == []
    assert len(built.foreign) == 2
    assert "__c6xabi_divd" in built.foreign
    assert dsp.compile_all(BUILT.parent, tmp_path, [], []).faults == [
        "there is no source to compile"
    ]
