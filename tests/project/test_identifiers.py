"""Names that emitted C can begin with."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from servogen.identifiers import C_HEADERS, C_KEYWORDS, is_c_identifier, is_free_prefix


@pytest.mark.parametrize("name", ["two_stage", "a", "A9_", "n" * 31, "sgx", "whiles"])
def test_free_names(name: str) -> None:
    assert is_free_prefix(name)


@pytest.mark.parametrize("name", ["", "9a", "_a", "a-b", "a b", "ä", "a\n", "n" * 32, "while"])
def test_no_identifiers(name: str) -> None:
    assert not is_c_identifier(name)


@pytest.mark.parametrize(
    "name", ["math", "Math", "stdint", "size", "uint8", "sg", "sg_pqp", "SG_x"]
)
def test_taken_names(name: str) -> None:
    assert not is_free_prefix(name)


def test_the_compiler_agrees(tmp_path: Path) -> None:
    """Every keyword is refused by gcc as a name, every header is one of its own."""
    gcc = shutil.which("gcc")
    assert gcc is not None

    def compiles(text: str) -> bool:
        arguments = [gcc, "-std=c99", "-fsyntax-only", "-x", "c", "-"]
        return subprocess.run(arguments, input=text, text=True, capture_output=True).returncode == 0

    includes = "".join(f"#include <{name}.h>\n" for name in sorted(C_HEADERS))
    assert compiles(includes)
    assert compiles("int a, two_stage;\n")
    assert [name for name in sorted(C_KEYWORDS) if compiles(f"int a, {name};\n")] == []
