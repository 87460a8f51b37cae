"""The C that ties one controller to the fuzzing harness: tables made from its declaration."""

from __future__ import annotations

from collections.abc import Sequence

from servogen.controllers.design import Declaration, Operation, Port, Status

HARNESS = ("sg_fuzz.c",)  # of c_runtime/fuzz; sg_replay.c beside it is the main of a replay
ASSUMED = 1.0  # a port without a declared range is given numbers of this order


def target_source(declaration: Declaration) -> str:
    """C99 of the target: compile it with the package's sources and the harness."""
    d = declaration
    parts = [
        f'#include "{d.prefix}.h"\n#include "sg_fuzz.h"\n',
        f"static void clear(void *self)\n{{\n    {d.prefix}_init(({d.prefix}_t *)self);\n}}\n",
    ]
    for op in d.operations:
        parts.append(_wrapper(d, op))
        parts.append(_ports(f"{op.name}_in", f"{d.prefix}_{op.name}_in", op.inputs))
        parts.append(_ports(f"{op.name}_out", f"{d.prefix}_{op.name}_out", op.outputs))
    rows = ",\n".join(_row(d, op) for op in d.operations)
    parts.append(f"static const sg_operation operations[] = {{\n{rows}\n}};\n")
    sizes = f"sizeof({d.prefix}_t), {d.precision.bytes}, clear"
    counts = f"operations, {len(d.operations)}, {max(Status) + 1}"
    parts.append(f"const sg_controller sg_fuzzed = {{ {sizes}, {counts} }};\n")
    return "\n".join(parts)


def _wrapper(d: Declaration, op: Operation) -> str:
    name = f"{d.prefix}_{op.name}"
    arguments = [f"({d.prefix}_t *)self"]
    unused = []
    for ports, side, kind in ((op.inputs, "in", "const "), (op.outputs, "out", "")):
        if ports:
            arguments.append(f"({kind}{name}_{side} *){side}")
        else:
            unused.append(f"    (void){side};\n")
    call = f"{name}({', '.join(arguments)})"
    body = f"return (int){call};" if op.returns_status else f"{call};\n    return -1;"
    head = f"static int call_{op.name}(void *self, const void *in, void *out)"
    return f"{head}\n{{\n{''.join(unused)}    {body}\n}}\n"


def _ports(name: str, struct: str, ports: Sequence[Port]) -> str:
    if not ports:
        return ""
    rows = []
    for port in ports:
        bounded = port.low is not None and port.high is not None
        low = -ASSUMED if port.low is None else float(port.low)
        high = ASSUMED if port.high is None else float(port.high)
        place = f'"{port.name}", offsetof({struct}, {port.name}), {port.size}'
        rows.append(f"    {{ {place}, {int(port.integer)}, {int(bounded)}, {low!r}, {high!r} }}")
    body = ",\n".join(rows)
    return f"static const sg_port {name}[] = {{\n{body}\n}};\n"


def _row(d: Declaration, op: Operation) -> str:
    def size(ports: Sequence[Port], side: str) -> str:
        return f"sizeof({d.prefix}_{op.name}_{side})" if ports else "0"

    def table(ports: Sequence[Port], side: str) -> str:
        return f"{op.name}_{side}, {len(ports)}" if ports else "NULL, 0"

    sizes = f"{size(op.inputs, 'in')}, {size(op.outputs, 'out')}"
    tables = f"{table(op.inputs, 'in')}, {table(op.outputs, 'out')}"
    return f'    {{ "{op.name}", call_{op.name}, {sizes}, {tables} }}'
