"""Compile an emitted package for Python through cffi.

API mode where Python's C headers are there. Where they are not (Debian keeps them in python3-dev),
the same sources become a shared library that cffi opens: no header is needed, calls cost a little
more, results are the same.
"""

from __future__ import annotations

import hashlib
import importlib.util
import io
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cffi

from servogen.controllers.design import Declaration, Port
from servogen.emit.package import CPackage, signature
from servogen.errors import InputError, ServogenError

# Bit identity with the reference needs IEEE arithmetic in source order; speed comes from -O3, which
# under strict ISO semantics reorders nothing.
# -fno-wrapv undoes what Python adds to its extensions: a target's compiler does not wrap either.
# -g0 does too: nobody debugs these, and what a debugger reads is up to a third of gcc's work.
COMPILE_FLAGS = (
    "-std=c99",
    "-g0",
    "-O3",
    "-ffp-contract=off",
    "-fno-wrapv",
    "-Wall",
    "-Wextra",
    "-Werror",
)

Module = Any  # ``ffi`` and ``lib`` of what was compiled: cffi gives them no types


class BuildError(ServogenError):
    """The emitted C did not compile: a fault of servogen or of the compiler, not of the input."""

    exit_status = 1


def _members(ports: Sequence[Port], real: str) -> str:
    lines = []
    for port in ports:
        kind = "int32_t" if port.integer else real
        lines.append(f"    {kind} {port.name}{f'[{port.size}]' if port.size else ''};")
    return "\n".join(lines)


def _declare(d: Declaration) -> str:
    """cffi's view of one controller: opaque state, in and out structs, prototypes."""
    p, real = d.prefix, d.precision.c_type
    parts = [f"size_t {p}_bytes(void);", f"void {p}_init(void *self);"]
    for op in d.operations:
        for ports, suffix in ((op.inputs, "in"), (op.outputs, "out")):
            if ports:
                parts.append(
                    f"typedef struct {{\n{_members(ports, real)}\n}} {p}_{op.name}_{suffix};"
                )
        text = signature(d, op).replace(f"const {p}_t *self", "const void *self")
        text = text.replace(f"{p}_t *self", "void *self")
        parts.append(text.replace("sg_status", "int") + ";")
        if _repeats(d, op.name):
            parts.append(
                f"void {p}_{op.name}_repeat(void *self, int count, {p}_{op.name}_out *out);"
            )
    return "\n".join(parts)


def _repeats(d: Declaration, name: str) -> bool:
    """Operations without inputs are run many at a time, so that a loop stays at C speed."""
    op = d.operation(name)
    return not op.inputs and bool(op.outputs)


def _source(package: CPackage, storage: str) -> str:
    """What the C does not offer by itself: sizes, and many calls at C speed."""
    lines = ["#include <stddef.h>", *(f'#include "{d.prefix}.h"' for d in package.declarations)]
    for d in package.declarations:
        p = d.prefix
        lines.append(f"{storage}size_t {p}_bytes(void) {{ return sizeof({p}_t); }}")
        for op in d.operations:
            if _repeats(d, op.name):
                call = f"{p}_{op.name}"
                lines.append(
                    f"{storage}void {call}_repeat(void *self, int count, {call}_out *out)\n"
                    f"{{ for (int i = 0; i < count; i++) {{ {call}(self, &out[i]); }} }}"
                )
    return "\n".join(lines)


def has_python_headers() -> bool:
    """Whether this Python can compile extensions (Debian: python3-dev)."""
    return (Path(sysconfig.get_paths()["include"]) / "Python.h").is_file()


@contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """setuptools prints the compiler's commands; keep them for the error message only."""
    text = io.StringIO()
    with redirect_stdout(text), redirect_stderr(text):
        yield text


def compile_package(
    packages: Sequence[CPackage], folder: Path, extra_flags: Sequence[str] = ()
) -> Module:
    """Compile one or more packages into one module with ``ffi`` and ``lib``.

    Args:
        packages: their prefixes must differ.
        folder: where sources and the extension go; kept by the caller.
        extra_flags: for the compiler and the linker, e.g. a sanitizer.

    Raises:
        BuildError: the compiler refused.
        InputError: there is no compiler.
    """
    if shutil.which("gcc") is None:
        raise InputError(None, "gcc", "missing", "a C compiler on the PATH: apt-get install gcc")
    key = hashlib.sha256("".join(p.hash for p in packages).encode()).hexdigest()[:12]
    name = f"_sil_{packages[0].name}_{key}"
    sources: list[str] = []
    for package in packages:
        package.write(folder)
        sources += [str(folder / file) for file in package.sources]
    ffi = cffi.FFI()
    for package in packages:
        ffi.cdef("\n".join(_declare(d) for d in package.declarations))
    flags = [*COMPILE_FLAGS, "-Wno-unused-function", *extra_flags]
    if not has_python_headers():
        return _shared_library(ffi, packages, folder, sources, flags)
    ffi.set_source(
        name,
        "\n".join(_source(package, "static ") for package in packages),
        sources=sources,
        include_dirs=[str(folder)],
        extra_compile_args=flags,
        extra_link_args=list(extra_flags),
    )
    with _quiet() as said:
        try:
            path = ffi.compile(tmpdir=str(folder), verbose=False)
        except Exception as error:  # cffi and setuptools raise several unrelated types
            raise BuildError(
                f"the emitted C does not compile: {error}\n{said.getvalue()}"
            ) from error
    return _load(name, Path(path))


def _shared_library(
    ffi: Any, packages: Sequence[CPackage], folder: Path, sources: list[str], flags: list[str]
) -> Module:
    shim, library = folder / "sil_shim.c", folder / "libsil.so"
    shim.write_text("\n".join(_source(package, "") for package in packages), encoding="utf-8")
    command = ["gcc", *flags, "-shared", "-fPIC", f"-I{folder}", *sources, str(shim)]
    done = subprocess.run(
        [*command, "-o", str(library)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise BuildError(f"the emitted C does not compile: {done.stderr}")
    return SimpleNamespace(ffi=ffi, lib=ffi.dlopen(str(library)))


def _load(name: str, path: Path) -> Module:
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise BuildError(f"the compiled module {path.name} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@contextmanager
def built(*packages: CPackage, extra_flags: Sequence[str] = ()) -> Iterator[Module]:
    """``compile_package`` in a temporary folder that goes away with the block."""
    folder = Path(tempfile.mkdtemp(prefix="servogen-sil-"))
    try:
        yield compile_package(packages, folder, extra_flags)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
