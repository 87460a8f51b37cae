"""Compilation without a warning: sources at every level, headers alone and twice, from C++."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from servogen.emit.package import CPackage, included
from servogen.evidence.compilers_found import Compiler
from servogen.evidence.flags import WARNINGS
from servogen.evidence.tools import run_tool

STRICT = ("-std=c99", *WARNINGS)
LEVELS = ("-O0", "-O2", "-O3", "-Os")
STANDARDS = ("c++98", "c++11", "c++14", "c++17", "c++20")
_PLUS = ("-Wall", "-Wextra", "-pedantic", "-Werror")


def write(package: CPackage, folder: Path) -> None:
    """The sources and headers, and the files that include them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in {
        **package.code,
        **header_files(package),
        "caller.cpp": _caller(package),
    }.items():
        (folder / name).write_text(text, encoding="utf-8")


def sources(package: CPackage, compiler: Compiler, level: str, folder: Path) -> list[str]:
    """Compile the package in ``folder``; objects beside the sources. What was said, or nothing."""
    return _compile([*compiler.command, *STRICT, level], package.sources, folder)


def headers(package: CPackage, compiler: Compiler, folder: Path) -> list[str]:
    """Every header alone, and every header twice."""
    return _compile([*compiler.command, *STRICT], list(header_files(package)), folder)


def from_cpp(compiler: Compiler, standard: str, folder: Path) -> list[str]:
    """All public headers included twice by C++, every entry point called."""
    return _compile([*compiler.plus, f"-std={standard}", *_PLUS], ["caller.cpp"], folder)


def header_files(package: CPackage) -> dict[str, str]:
    """A C file for every header, which includes it twice.

    A header that the callers of the package never see is included after the package's scalar, as
    its own sources do.
    """
    public = included(package.files, [f"{d.prefix}.h" for d in package.declarations])
    scalar = f"{package.name}_scalar.h"
    files = {}
    for name in sorted(package.code):
        if name.endswith(".h"):
            before = "" if name in public or name == scalar else f'#include "{scalar}"\n'
            text = f'{before}#include "{name}"\n#include "{name}"\nextern int nothing;\n'
            files[f"twice_{Path(name).stem}.c"] = text
    return files


def _caller(package: CPackage) -> str:
    lines = [f'#include "{d.prefix}.h"' for d in package.declarations] * 2
    lines.append("int main()\n{")
    for d in package.declarations:
        lines.append(f"    static {d.prefix}_t {d.prefix};\n    {d.prefix}_init(&{d.prefix});")
        for op in d.entries:
            name, arguments = f"{d.prefix}_{op.name}", [f"&{d.prefix}"]
            for ports, end in ((op.inputs, "in"), (op.outputs, "out")):
                if ports:
                    lines.append(f"    static {name}_{end} {name}_{end}_it;")
                    arguments.append(f"&{name}_{end}_it")
            lines.append(f"    (void){name}({', '.join(arguments)});")
    return "\n".join([*lines, "    return 0;", "}", ""])


def _compile(command: Sequence[str | Path], files: Sequence[str], folder: Path) -> list[str]:
    """Warnings and errors, one file at a time: zig compiles only the first of several.

    No object is a fault too, whatever the compiler's exit status says.
    """
    found = [] if files else ["there is nothing to compile"]
    for name in files:
        place = Path(name).with_suffix(".o")
        (folder / place).unlink(missing_ok=True)
        done = run_tool([*command, "-c", name, "-o", place], folder)
        said = [x.strip() for x in done.stderr.splitlines() if re.search(r"(error|warning):", x)]
        if not said and (done.returncode != 0 or not (folder / place).is_file()):
            said = [f"{name}: no object, exit status {done.returncode}"]
        found += said
    return found
