"""Compile an emitted package into a Python extension through cffi (API mode)."""

from __future__ import annotations

import hashlib
import importlib.util
import io
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import ModuleType
from typing import Any

import cffi

from servogen.controllers.design import Declaration, Port
from servogen.emit.package import CPackage, signature
from servogen.errors import ServogenError

# Bit identity with the reference needs IEEE arithmetic in source order; speed comes from -O3, which
# under strict ISO semantics reorders nothing.
COMPILE_FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")


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
    parts = [f"typedef struct {{ ...; }} {p}_t;", f"void {p}_init({p}_t *self);"]
    for op in d.operations:
        for ports, suffix in ((op.inputs, "in"), (op.outputs, "out")):
            if ports:
                parts.append(
                    f"typedef struct {{\n{_members(ports, real)}\n}} {p}_{op.name}_{suffix};"
                )
        text = signature(d, op)
        parts.append(text.replace("sg_status", "int") + ";")
        if _repeats(d, op.name):
            parts.append(
                f"void {p}_{op.name}_repeat({p}_t *self, int count, {p}_{op.name}_out *out);"
            )
    return "\n".join(parts)


def _repeats(d: Declaration, name: str) -> bool:
    """Operations without inputs are run many at a time, so that a loop stays at C speed."""
    op = d.operation(name)
    return not op.inputs and bool(op.outputs)


def _source(package: CPackage) -> str:
    lines = [f'#include "{d.prefix}.h"' for d in package.declarations]
    for d in package.declarations:
        for op in d.operations:
            if _repeats(d, op.name):
                p, call = d.prefix, f"{d.prefix}_{op.name}"
                lines.append(
                    f"static void {call}_repeat({p}_t *self, int count, {call}_out *out)\n"
                    f"{{ for (int i = 0; i < count; i++) {{ {call}(self, &out[i]); }} }}"
                )
    return "\n".join(lines)


@contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """setuptools prints the compiler's commands; keep them for the error message only."""
    text = io.StringIO()
    with redirect_stdout(text), redirect_stderr(text):
        yield text


def compile_package(
    packages: Sequence[CPackage], folder: Path, extra_flags: Sequence[str] = ()
) -> ModuleType:
    """Compile one or more packages into one module with ``ffi`` and ``lib``.

    Args:
        packages: their prefixes must differ.
        folder: where sources and the extension go; kept by the caller.
        extra_flags: for the compiler and the linker, e.g. a sanitizer.

    Raises:
        BuildError: the compiler refused.
    """
    key = hashlib.sha256("".join(p.hash for p in packages).encode()).hexdigest()[:12]
    name = f"_sil_{packages[0].name}_{key}"
    sources: list[str] = []
    for package in packages:
        for file, text in package.files.items():
            (folder / file).write_text(text, encoding="utf-8")
        sources += [str(folder / file) for file in package.sources]
    ffi = cffi.FFI()
    for package in packages:
        ffi.cdef("\n".join(_declare(d) for d in package.declarations))
    ffi.set_source(
        name,
        "\n".join(_source(package) for package in packages),
        sources=sources,
        include_dirs=[str(folder)],
        extra_compile_args=[*COMPILE_FLAGS, "-Wno-unused-function", *extra_flags],
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


def _load(name: str, path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise BuildError(f"the compiled module {path.name} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@contextmanager
def built(*packages: CPackage, extra_flags: Sequence[str] = ()) -> Iterator[ModuleType]:
    """``compile_package`` in a temporary folder that goes away with the block."""
    folder = Path(tempfile.mkdtemp(prefix="servogen-sil-"))
    try:
        yield compile_package(packages, folder, extra_flags)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


Module = Any  # a compiled module: cffi gives it no types
