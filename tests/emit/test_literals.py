"""Numbers as C text: the same bits come back, from Python's reader and from the compiler's."""

from __future__ import annotations

import struct
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from servogen.emit.literals import real_literal
from servogen.precision import FLOAT32, FLOAT64

EXAMPLES = settings(derandomize=True, deadline=None, max_examples=300)
EDGES_64 = [0.0, -0.0, 5e-324, -5e-324, 2.2250738585072014e-308, 2.225073858507201e-308]
EDGES_64 += [1.7976931348623157e308, 0.1, 1 / 3, 1e22, 1e23, 123456789.0, 9007199254740993.0]
EDGES_32 = [0.0, -0.0, 1e-45, -1e-45, 1.1754944e-38, 1.1754942e-38, 3.4028235e38, 0.1, 16777217.0]


def bits(value: float, kind: str) -> bytes:
    return struct.pack(kind, value)


@EXAMPLES
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_float64_reads_back(value):
    text = real_literal(value, FLOAT64)
    assert bits(float(text), "d") == bits(value, "d")
    assert "." in text
    assert len(text) <= 25


@EXAMPLES
@given(st.floats(allow_nan=False, allow_infinity=False, width=32))
def test_float32_reads_back(value):
    text = real_literal(value, FLOAT32)
    assert text.endswith("f")
    assert "." in text
    assert bits(float(np.float32(text[:-1])), "f") == bits(value, "f")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64])
def test_what_is_not_finite_is_refused(value, precision):
    with pytest.raises(ValueError, match="no finite"):
        real_literal(value, precision)


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("value", [1e39, -3.4028236e38])
def test_what_float32_cannot_hold_is_refused(value):
    with pytest.raises(ValueError, match="no finite float32"):
        real_literal(value, FLOAT32)


def test_the_compiler_reads_the_same_bits(tmp_path):
    rng = np.random.default_rng(0)
    doubles = EDGES_64 + list(rng.normal(size=200) * 10.0 ** rng.uniform(-300, 300, 200))
    floats = EDGES_32 + [float(np.float32(v)) for v in 10.0 ** rng.uniform(-44, 38, 300)]
    lines = ["#include <stdio.h>", "#include <string.h>", "int main(void) {"]
    for i, v in enumerate(doubles):
        lines.append(f"static const double d{i} = {real_literal(float(v), FLOAT64)};")
        lines.append(f"fwrite(&d{i}, sizeof d{i}, 1, stdout);")
    for i, v in enumerate(floats):
        lines.append(f"static const float f{i} = {real_literal(v, FLOAT32)};")
        lines.append(f"fwrite(&f{i}, sizeof f{i}, 1, stdout);")
    source = tmp_path / "literals.c"
    source.write_text("\n".join([*lines, "return 0; }"]))
    subprocess.run(
        ["gcc", "-std=c99", "-Wall", "-Werror", str(source), "-o", str(tmp_path / "literals")],
        check=True,
    )
    said = subprocess.run([str(tmp_path / "literals")], check=True, capture_output=True).stdout
    expected = b"".join(bits(float(v), "d") for v in doubles)
    expected += b"".join(bits(v, "f") for v in floats)
    assert said == expected
