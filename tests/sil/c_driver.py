"""A C program that plays calls from a file into every entry point, made from the declarations.

It is how the emitted C is run under sanitizers, which a Python extension cannot be: each call is
the number of an entry point, then the bytes of its input struct; back come status and output.
"""

from __future__ import annotations

import os
import struct
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from core_designs import Variant, package, temporary_folder

from servogen.controllers.design import Declaration, Operation, Port

SANITIZERS = ["-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero"]
SANITIZERS += ["-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-g", "-O1"]


def layout(ports: Sequence[Port], d: Declaration) -> np.dtype[Any]:
    """The struct as C lays it out."""
    fields = []
    for port in ports:
        kind = np.dtype(np.int32) if port.integer else d.precision.dtype
        fields.append((port.name, kind, (port.size,)) if port.size else (port.name, kind))
    return np.dtype(fields, align=True)


def entry_points(declarations: Sequence[Declaration]) -> list[tuple[Declaration, Operation]]:
    return [(d, op) for d in declarations for op in d.operations]


def _case(number: int, d: Declaration, op: Operation) -> str:
    name = f"{d.prefix}_{op.name}"
    arguments = [f"{d.prefix}_self"]
    lines = [f"case {number}: {{"]
    if op.inputs:
        # exactly as large as the struct, on the heap: a read beyond it is seen
        lines.append(f"{name}_in *in = malloc(sizeof *in);")
        lines.append("if (fread(in, sizeof *in, 1, stdin) != 1) { return 2; }")
        arguments.append("in")
    if op.outputs:
        lines.append(f"{name}_out *out = malloc(sizeof *out); memset(out, 0xA5, sizeof *out);")
        arguments.append("out")
    call = f"{name}({', '.join(arguments)})"
    lines.append(f"status = {f'(int){call}' if op.returns_status else f'({call}, 0)'};")
    lines.append("fwrite(&status, sizeof status, 1, stdout);")
    if op.outputs:
        lines.append("fwrite(out, sizeof *out, 1, stdout); free(out);")
    if op.inputs:
        lines.append("free(in);")
    return "\n    ".join([*lines, "break; }"])


def driver_source(declarations: Sequence[Declaration]) -> str:
    includes = "".join(f'#include "{d.prefix}.h"\n' for d in declarations)
    # memory is dirty before init: what init forgets is garbage, as on a target
    setup = "\n    ".join(
        f"{d.prefix}_t *{d.prefix}_self = malloc(sizeof *{d.prefix}_self); "
        f"memset({d.prefix}_self, 0xA5, sizeof *{d.prefix}_self); {d.prefix}_init({d.prefix}_self);"
        for d in declarations
    )
    free = " ".join(f"free({d.prefix}_self);" for d in declarations)
    cases = "\n    ".join(
        _case(number, d, op) for number, (d, op) in enumerate(entry_points(declarations))
    )
    return (
        f"#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n{includes}"
        f"int main(void)\n{{\n    int which, status;\n    {setup}\n"
        "    while (fread(&which, sizeof which, 1, stdin) == 1) {\n    switch (which) {\n    "
        f"{cases}\n    default: return 3;\n    }} }}\n    {free}\n    return 0;\n}}\n"
    )


def build(v: Variant) -> Path:
    """The sanitized program of one package."""
    made = package(v)
    folder = temporary_folder("driver")
    for file, text in made.files.items():
        (folder / file).write_text(text)
    (folder / "main.c").write_text(driver_source(made.declarations))
    subprocess.run(
        ["gcc", "-std=c99", "-ffp-contract=off", *SANITIZERS, "main.c", *made.sources,
         "-o", "driver"],
        cwd=folder,
        check=True,
    )  # fmt: skip
    return folder / "driver"


def play(
    program: Path, v: Variant, calls: Sequence[tuple[int, bytes]]
) -> list[tuple[int, np.ndarray | None]]:
    """Status and outputs of every call; a report of a sanitizer fails the test."""
    entries = entry_points(package(v).declarations)
    given = b"".join(struct.pack("i", number) + data for number, data in calls)
    environment = os.environ | {"ASAN_OPTIONS": "detect_leaks=0"}
    done = subprocess.run(
        [str(program)], input=given, capture_output=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr.decode()[:3000]
    assert done.stderr == b""
    found, offset = [], 0
    for number, _ in calls:
        d, op = entries[number]
        (status,) = struct.unpack_from("i", done.stdout, offset)
        offset += 4
        values = None
        if op.outputs:
            kind = layout(op.outputs, d)
            values = np.frombuffer(done.stdout, kind, 1, offset)[0]
            offset += kind.itemsize
        found.append((status, values))
    assert offset == len(done.stdout)
    return found
