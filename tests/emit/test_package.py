"""The emitted package: the same bytes every time, and what its manifest and tables say."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from core_designs import VARIANTS, Variant, design, package

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.package import RUNTIME_FILES, emit_package

SCRIPT = """
import sys, hashlib
sys.path.insert(0, sys.argv[1])
from core_designs import Variant, package
made = package(Variant(horizon=3, differing=True))
for name, text in made.files.items():
    print(name, hashlib.sha256(text.encode()).hexdigest())
"""


def test_two_processes_with_other_hash_seeds_give_the_same_bytes(tmp_path):
    found = []
    for seed in ("1", "4242"):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT, str(Path(__file__).parents[1] / "sil")],
            env=os.environ | {"PYTHONHASHSEED": seed},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        found.append(done.stdout)
    assert found[0] == found[1]
    here = package(Variant(horizon=3, differing=True)).files
    assert found[0].count("\n") == len(here) > 10
    for name, text in here.items():
        assert f"{name} {hashlib.sha256(text.encode()).hexdigest()}" in found[0]


@pytest.mark.parametrize("name", ["example", "governor alone"])
def test_no_file_tells_when_or_where_it_was_made(name):
    for file, text in package(VARIANTS[name]).files.items():
        assert str(Path.home()) not in text, file
        assert str(Path(__file__).parents[2]) not in text, file
        assert os.sep + "tmp" not in text, file
        assert not re.search(r"20[2-9]\d-\d\d|\d\d:\d\d:\d\d", text), file
        assert text.endswith("\n"), file
        assert "\r" not in text, file
        assert "\t" not in text, file
        assert not [line for line in text.splitlines() if line != line.rstrip()], file


def test_manifest_says_what_is_there():
    made = package(VARIANTS["axes differ"])
    manifest = json.loads(made.files["manifest.json"])
    assert set(manifest["files"]) == set(made.files) - {"manifest.json"}
    for file, digest in manifest["files"].items():
        assert hashlib.sha256(made.files[file].encode()).hexdigest() == digest
    assert manifest["design_hash"] == made.hash
    assert manifest["precision"] == "float32"
    assert set(RUNTIME_FILES) - {"sg_angle.h", "sg_taut.h"} <= set(manifest["files"])
    by_prefix = {c["prefix"]: c for c in manifest["controllers"]}
    for d in made.declarations:
        own = by_prefix[d.prefix]
        assert own["dimensions"] == {dim.name: dim.value for dim in d.dimensions}
        header = made.files[f"{d.prefix}.h"]
        for entry in own["entry_points"]:
            assert f" {entry['name']}(" in header
            for port in entry["inputs"] + entry["outputs"]:
                assert f" {port['name']}" in header
        tables = made.files[f"{d.prefix}_tables.h"]
        counts = {n: int(size) for n, size in re.findall(r"(\w+)\[(\d+)\] = \{", tables)}
        scalars = len(re.findall(r"^static const sg_real \w+ = ", tables, flags=re.MULTILINE))
        assert own["table_bytes"] == 4 * (sum(counts.values()) + scalars)
    assert manifest["table_bytes"] == sum(c["table_bytes"] for c in by_prefix.values())


def test_hash_names_the_design():
    base = declare_parts(design(VARIANTS["example"]))
    same = emit_package("core", declare_parts(design(Variant(prefix="core"))))
    assert same.hash == package(VARIANTS["example"]).hash
    nudged = replace(
        base[0],
        constants=(replace(base[0].constants[0], value=base[0].constants[0].value * (1 + 2e-16)),
                   *base[0].constants[1:]),
    )  # fmt: skip
    assert emit_package("core", (nudged, *base[1:])).hash != same.hash
    hashes = {package(v).hash for v in VARIANTS.values()}
    assert len(hashes) == len(VARIANTS)


def test_tables_in_the_c_are_the_tables_of_the_design():
    made = package(VARIANTS["example"])
    for d in made.declarations:
        text = made.files[f"{d.prefix}_tables.h"]
        for table in d.tables:
            block = re.search(rf"{d.prefix}_{table.name}\[\d+\] = \{{(.*?)\}};", text, re.S)
            values = [float(word) for word in block.group(1).replace("\n", " ").split(",")]
            assert values == list(table.values.ravel())


def test_cmake_subdirectory_builds_and_runs(tmp_path):
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not installed; the CMake file is an optional target")
    made = package(VARIANTS["governor alone"])
    inner = tmp_path / "core"
    inner.mkdir()
    made.write(inner)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.10)\nproject(firmware C)\nadd_subdirectory(core)\n"
        "add_executable(firmware main.c)\ntarget_link_libraries(firmware core)\n"
    )
    (tmp_path / "main.c").write_text(
        '#include "core.h"\n'
        "int main(void)\n{\n    static core_t self;\n    core_reset_in in = { 0.0, 0.0 };\n"
        "    core_init(&self);\n    return core_reset(&self, &in) == SG_OK ? 0 : 1;\n}\n"
    )
    for command in (["cmake", "-S", ".", "-B", "build"], ["cmake", "--build", "build"]):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    subprocess.run([str(tmp_path / "build" / "firmware")], check=True)


def test_the_bits_of_a_scalar_are_told_where_something_asks():
    """A macro that nothing reads is against rule 2.5 of MISRA C."""
    assert "SG_REAL_BITS 64" in package(Variant(horizon=3)).files["core_scalar.h"]
    assert "SG_REAL_BITS" not in package(Variant(horizon=0)).files["core_scalar.h"]
