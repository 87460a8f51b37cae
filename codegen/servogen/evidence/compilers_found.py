"""The compilers of the matrix: gcc, clang, and the clang in ``ziglang``, each with targets."""

from __future__ import annotations

import importlib.util
import re
import shutil
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from servogen.evidence.tools import ToolMissing, run_tool, version_of

# Distributions differ in what they switch on by themselves; zig adds a sanitizer.
_PLAIN = ("-ffp-contract=off", "-fno-stack-protector")
_ZIG = (*_PLAIN, "-fno-sanitize=undefined")
# SSE2, so that 32-bit x86 computes in the precision that it stores, and doubles at multiples of 8
# as everywhere else: the calls that are played are laid out so.
_SSE = ("-msse2", "-mfpmath=sse", "-malign-double")
_PROBE = "#include <stdint.h>\nint32_t probe(int32_t x);\nint32_t probe(int32_t x) { return x; }\n"


@dataclass(frozen=True)
class Compiler:
    """A compiler with a target.

    Attributes:
        name: ``gcc``, ``gcc 32-bit``, ``zig powerpc``.
        family: ``gcc`` or ``clang``.
        command: of the C compiler, up to and with the options of the target.
        plus: likewise of the C++ compiler; empty where it is not asked.
        runs: what it compiles runs here, if it can be linked.
        further: one more target of a compiler that is in the matrix already: one level will do.
    """

    name: str
    family: str
    version: str
    command: tuple[str, ...]
    plus: tuple[str, ...] = ()
    runs: bool = False
    further: bool = False

    def refusal(self) -> str | None:
        """Why it cannot compile the smallest file, None if it can."""
        with TemporaryDirectory(prefix="servogen-probe-") as name:
            Path(name, "probe.c").write_text(_PROBE, encoding="utf-8")
            done = run_tool([*self.command, "-c", "probe.c", "-o", "probe.o"], Path(name))
        said = (done.stderr.strip().splitlines() or ["no message"])[0]
        return None if done.returncode == 0 else re.sub(r"^\S*: ", "", said)


@dataclass(frozen=True)
class Found:
    """``missing``: one sentence for every compiler that is not used."""

    compilers: tuple[Compiler, ...]
    missing: tuple[str, ...]


@cache
def find_compilers() -> Found:
    """Every compiler and target of the matrix that works here.

    Raises:
        ToolMissing: there is no gcc; the figures of the others mean little without it.
    """
    if shutil.which("gcc") is None:
        raise ToolMissing("gcc", "apt-get install gcc")
    compilers: list[Compiler] = []
    missing: list[str] = []
    for candidate in [*_gcc(), *_clang(), *_zig()]:
        if isinstance(candidate, str):
            missing.append(candidate)
            continue
        refusal = candidate.refusal()
        if refusal is None:
            compilers.append(candidate)
        else:
            missing.append(f"{candidate.name}: {refusal}")
    return Found(tuple(compilers), tuple(missing))


def _gcc() -> list[Compiler | str]:
    version = version_of(["gcc", "-dumpfullversion"])
    plus = ("g++", *_PLAIN) if shutil.which("g++") else ()
    narrow = ("gcc", "-m32", "-ffreestanding", *_PLAIN, *_SSE)
    found: list[Compiler | str] = [
        Compiler("gcc", "gcc", version, ("gcc", *_PLAIN), plus, runs=True),
        Compiler("gcc 32-bit", "gcc", version, narrow, runs=True),
    ]
    return found if plus else [*found, "g++: apt-get install g++"]


def _clang() -> list[Compiler | str]:
    if shutil.which("clang") is None:
        return ["clang: apt-get install clang"]
    version = re.sub(r".*version (\S+).*", r"\1", version_of(["clang", "--version"]))
    narrow = ("clang", "--target=i386-linux-gnu", "-ffreestanding", *_PLAIN, *_SSE)
    return [
        Compiler("clang", "clang", version, ("clang", *_PLAIN), ("clang++", *_PLAIN), runs=True),
        Compiler("clang 32-bit", "clang", version, narrow, runs=True),
    ]


# (name, target, further options, runs on x86-64); big-endian ones and one with 16-bit int too.
_TARGETS = (
    ("64-bit", "x86_64-linux-musl", (), True),
    ("32-bit", "x86-linux-musl", _SSE, True),
    ("arm", "arm-linux-musleabihf", (), False),
    ("aarch64", "aarch64-linux-musl", (), False),
    ("riscv32", "riscv32-linux-musl", (), False),
    ("powerpc, big-endian", "powerpc-linux-musleabihf", (), False),
    ("s390x, big-endian", "s390x-linux-musl", (), False),
    ("msp430, 16-bit int", "msp430-freestanding", ("-ffreestanding",), False),
)


def _zig() -> list[Compiler | str]:
    if importlib.util.find_spec("ziglang") is None:
        return ["zig: pip install ziglang"]
    zig = (sys.executable, "-m", "ziglang")
    version = re.sub(r".*version (\S+).*", r"\1", version_of([*zig, "cc", "--version"]))
    found: list[Compiler | str] = []
    for name, target, options, runs in _TARGETS:
        flags = ("-target", target, *options, *_ZIG)
        plus = (*zig, "c++", *flags) if target == "x86_64-linux-musl" else ()
        command = (*zig, "cc", *flags)
        found.append(Compiler(f"zig {name}", "clang", version, command, plus, runs, not runs))
    return found
