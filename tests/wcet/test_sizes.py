"""Sizes of structures: those of the compiler for a target with natural alignment."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from core_designs import Variant, design

from servogen.controllers.cascade_design import declare_parts
from servogen.steps.counted import emit_counted
from servogen.wcet.package import count_package
from servogen.wcet.refusal import CountRefused

VARIANTS = [
    Variant(prefix="shape", horizon=h, cap=12, points=9, ramp=3, precision=p)
    for p in ("float64", "float32")
    for h in (3, 0)
]
ODD = """
#include <stdint.h>
typedef struct { int8_t a; double b; int16_t c; } inner_t;
typedef struct { uint8_t n; inner_t each[3]; float x; int64_t big; char tail; } odd_t;
typedef union { inner_t a; float b[9]; } either_t;
typedef struct { const float *p; float x; } pointing_t;
"""


def compiled(folder: Path, headers: str, types: list[str]) -> list[int]:
    """What gcc makes of them on the host, whose alignment is natural too."""
    shown = "".join(f'printf("%d\\n", (int)sizeof({name}));' for name in types)
    (folder / "sizes.c").write_text(f"#include <stdio.h>\n{headers}\nint main(void){{{shown}}}\n")
    command = ["gcc", "-std=c99", f"-I{folder}", "-o", "sizes", "sizes.c"]
    subprocess.run(command, cwd=folder, check=True)
    told = subprocess.run([folder / "sizes"], capture_output=True, text=True, check=True)
    return [int(line) for line in told.stdout.split()]


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda v: f"{v.precision}-{v.horizon}")
def test_structures_of_the_emitted_c(tmp_path: Path, variant: Variant) -> None:
    package, counts = emit_counted("shape", declare_parts(design(variant)))
    package.write(tmp_path)
    types = list(counts.type_bytes)
    assert {f"{d.prefix}_t" for d in package.declarations} <= set(types)
    assert {"shape_plan_in", "shape_fast_step_out"} <= set(types)
    headers = "".join(f'#include "{d.prefix}.h"\n' for d in package.declarations)
    assert compiled(tmp_path, headers, types) == list(counts.type_bytes.values())


def test_odd_structures(tmp_path: Path) -> None:
    (tmp_path / "odd.c").write_text(ODD)
    types = ["inner_t", "odd_t", "either_t"]
    counts = count_package([tmp_path / "odd.c"], [], [], types=[*types, "pointing_t"])
    assert [counts.type_bytes[t] for t in types] == compiled(tmp_path, ODD, types)
    assert counts.type_bytes["pointing_t"] == 8  # pointers have four bytes on the targets


def test_a_structure_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "odd.c").write_text(ODD)
    with pytest.raises(CountRefused, match="'none_t' is not defined"):
        count_package([tmp_path / "odd.c"], [], [], types=["none_t"])
