"""The runtime's kernels by themselves, on a package's own tables: straight-line code, so that the
floating-point instructions executed must be exactly those counted.

Every table of two dimensions is multiplied with a vector, every one of one dimension is a factor
of a scalar product. The result is a package like any other, with an entry point for each table.
The tables stand in a file of their own: a compiler that saw them would fold their zeros and ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.controllers.design import Declaration, Operation, Port, Table
from servogen.emit.literals import real_literal
from servogen.emit.package import CPackage, signature
from servogen.precision import Precision
from servogen.sil.harness import Call
from servogen.sil.player import Play

SEED = 4711
VECTORS = 5


def with_kernels(package: CPackage) -> tuple[CPackage, Play, str]:
    """The package with the kernels beside it, calls of each, and the name of the C file to count.

    The file names, the prefix and the operations are new; nothing of the package is changed.
    """
    prefix = f"{package.name}_kernels"
    tables = [
        (f"{d.prefix}_{t.name}", t)
        for d in package.declarations
        for t in d.tables
        if t.values.size > 1 and not t.integer
    ]
    precision = package.declarations[0].precision
    declaration = Declaration(
        "kernels", prefix, "kernels on tables", precision, 0.0, (), (), (),
        tuple(_operation(name, table) for name, table in tables), (),
    )  # fmt: skip
    files = {
        f"{prefix}.h": _header(package.name, declaration),
        f"{prefix}.c": _source(package.name, declaration, tables),
        f"{prefix}_data.c": _data(package.name, prefix, tables, precision),
    }
    grown = CPackage(
        package.name, package.hash, (*package.declarations, declaration), package.files | files
    )
    return grown, _play(declaration), f"{prefix}.c"


def _operation(name: str, table: Table) -> Operation:
    columns, rows = table.values.shape[0], table.values.size // table.values.shape[0]
    result = rows if table.values.ndim == 2 else 0
    return Operation(
        name, "",
        (Port("x", "", "the vector", size=columns),),
        (Port("y", "", "the result", size=result),),
        returns_status=False,
    )  # fmt: skip


def _play(declaration: Declaration) -> Play:
    random = np.random.default_rng(SEED)
    dtype = declaration.precision.dtype
    calls = [
        Call(op.name, {"x": random.normal(0.0, 1.0, op.inputs[0].size).astype(dtype)})
        for op in declaration.operations
        for _ in range(VECTORS)
    ]
    return Play("kernels", declaration.prefix, tuple(calls))


def _header(package: str, declaration: Declaration) -> str:
    p, real = declaration.prefix, f"{package}_real"
    lines = [
        f"#ifndef {p.upper()}_H", f"#define {p.upper()}_H", f'#include "{package}_types.h"',
        "typedef struct { int32_t nothing; }" f" {p}_t;", f"void {p}_init({p}_t *self);",
    ]  # fmt: skip
    for op in declaration.operations:
        for port, side in ((op.inputs[0], "in"), (op.outputs[0], "out")):
            size = f"[{port.size}]" if port.size else ""
            lines.append(f"typedef struct {{ {real} {port.name}{size}; }} {p}_{op.name}_{side};")
        lines.append(f"{signature(declaration, op)};")
    return "\n".join([*lines, "#endif", ""])


def _source(package: str, declaration: Declaration, tables: Sequence[tuple[str, Table]]) -> str:
    p = declaration.prefix
    lines = [
        f'#include "{p}.h"', f'#include "{package}_scalar.h"',
        f"void {p}_init({p}_t *self)", "{", "    self->nothing = 0;", "}",
    ]  # fmt: skip
    for op, (name, table) in zip(declaration.operations, tables, strict=True):
        n, data = op.inputs[0].size, f"{p}_data_{name}"
        lines += [f"extern const sg_real {data}[{table.values.size}];",
                  signature(declaration, op), "{", "    (void)self;"]  # fmt: skip
        if op.outputs[0].size:
            lines.append(f"    sg_matvec({op.outputs[0].size}, {n}, {data}, in->x, out->y);")
        else:
            lines.append(f"    out->y = sg_dot({n}, {data}, in->x);")
        lines.append("}")
    return "\n".join([*lines, ""])


def _data(
    package: str, prefix: str, tables: Sequence[tuple[str, Table]], precision: Precision
) -> str:
    lines = [f'#include "{package}_types.h"']
    for name, table in tables:
        kind = f"const {package}_real {prefix}_data_{name}[{table.values.size}]"
        numbers = ", ".join(real_literal(float(v), precision) for v in table.values.ravel())
        lines += [f"extern {kind};", f"{kind} = {{ {numbers} }};"]
    return "\n".join([*lines, ""])
