"""Lay out a set of controllers as a C package: sources, headers, runtime, CMake file, manifest."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from servogen import __version__
from servogen.controllers.design import Declaration, Operation, Port, design_hash
from servogen.controllers.governor_design import AXES
from servogen.emit.driver import driver_files, is_driver
from servogen.emit.environment import make_environment
from servogen.emit.head import head_of
from servogen.emit.manifest import manifest_text
from servogen.resources import resource_dir
from servogen.wcet.package import PackageCount

DIVISION = "sg_division.h"
RUNTIME_FILES = (
    "sg_angle.h",
    "sg_compiler.h",
    DIVISION,
    "sg_kernels.h",
    "sg_pqp.h",
    "sg_quotient.h",
    "sg_status.h",
    "sg_taut.h",
)


@dataclass(frozen=True)
class CPackage:
    """``files``: text by name, in a fixed order; ``name``: prefix; ``hash``: names the design."""

    name: str
    hash: str
    declarations: tuple[Declaration, ...]
    files: dict[str, str]

    @property
    def sources(self) -> list[str]:
        """The C to compile."""
        return [f for f in self.code if f.endswith(".c")]

    @property
    def code(self) -> dict[str, str]:
        """The sources and the headers of the firmware, without what only a prover reads."""
        return {
            f: t for f, t in self.files.items() if f.endswith((".c", ".h")) and not is_driver(f)
        }

    def write(self, folder: Path) -> None:
        """All files into ``folder``, whatever is there."""
        for name, text in self.files.items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(text, encoding="utf-8")


def signature(declaration: Declaration, operation: Operation) -> str:
    """C prototype of one entry point, without the semicolon."""
    p = declaration.prefix
    result = "sg_status" if operation.returns_status else "void"
    const = "const " if operation.reads_only else ""
    arguments = [f"{const}{p}_t *self"]
    if operation.inputs:
        arguments.append(f"const {p}_{operation.name}_in *in")
    if operation.outputs:
        arguments.append(f"{p}_{operation.name}_out *out")
    return f"{result} {p}_{operation.name}({', '.join(arguments)})"


def state_names(declaration: Declaration) -> list[str]:
    """Names of the state's components, position first."""
    order = next((d.value for d in declaration.dimensions if d.name == "ORDER"), 0)
    return ["position", "velocity", "acceleration", *(f"state_{i}" for i in range(3, order))]


def measured_ports(declaration: Declaration) -> list[Port]:
    """Inputs of ``step`` that are measured states of either axis."""
    names = {f"{axis}_{name}" for axis in AXES for name in state_names(declaration)}
    return [port for port in declaration.operation("step").inputs if port.name in names]


def included(files: Mapping[str, str], sources: Iterable[str]) -> set[str]:
    """The sources and every file that one of them includes, under whatever condition."""
    reached: set[str] = set()
    waiting = list(sources)
    while waiting:
        name = waiting.pop()
        if name in files and name not in reached:
            reached.add(name)
            waiting += re.findall(r'^\s*#\s*include\s+"([^"]+)"', files[name], flags=re.M)
    return reached


def emit_package(
    name: str, declarations: tuple[Declaration, ...], counts: PackageCount | None = None
) -> CPackage:
    """Render every file. The same declarations give the same bytes.

    Args:
        declarations: every controller once, those used before those that use them.
        counts: of every entry point, for the heads of the files; without them the heads say none.
    """
    precision = declarations[0].precision
    environment = make_environment(precision)
    digest = design_hash(declarations)
    common = {
        "package": name,
        "version": __version__,
        "hash": digest,
        "precision": precision,
        "real_type": f"{name}_real",
        "axes": AXES,
        "state_ports": measured_ports,
    }
    scalar = f"{name}_scalar.h"
    files = {
        f"{name}_{part}.h": environment.get_template(f"{part}.h.jinja").render(
            common | {"divides": True}
        )
        for part in ("types", "scalar")
    }
    for d in declarations:

        def sign(operation: Operation, declaration: Declaration = d) -> str:
            return signature(declaration, operation)

        context = common | {
            "d": d,
            "p": d.prefix,
            "P": d.prefix.upper(),
            "dims": {dim.name: dim.value for dim in d.dimensions},
            "signature": sign,
            "head": None if counts is None else head_of(d, counts),
            "state_names": state_names(d),
        }
        for template, file in (
            ("controller.h.jinja", f"{d.prefix}.h"),
            ("tables.h.jinja", f"{d.prefix}_tables.h"),
            (f"{d.kind}.c.jinja", f"{d.prefix}.c"),
        ):
            if file.endswith("_tables.h") and not (d.constants or d.tables):
                continue
            files[file] = environment.get_template(template).render(context)
    files |= driver_files(environment, declarations, common, signature)
    sources = [file for file in files if file.endswith(".c") and not is_driver(file)]
    folder = resource_dir("c_runtime")
    runtime = {name: (folder / name).read_text(encoding="utf-8") for name in RUNTIME_FILES}
    used = included(files | runtime, sources)
    files |= {name: text for name, text in runtime.items() if name in used}
    if DIVISION not in used:  # nobody asks how many bits a scalar has
        files[scalar] = environment.get_template("scalar.h.jinja").render(
            common | {"divides": False}
        )
    files["CMakeLists.txt"] = environment.get_template("CMakeLists.txt.jinja").render(
        common | {"sources": sources}
    )
    files["manifest.json"] = manifest_text(name, digest, declarations, files)
    return CPackage(name, digest, declarations, files)
