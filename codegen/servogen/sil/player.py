"""A C program that plays recorded calls into every entry point of a package and writes what came
back: how the same C is run under sanitizers, with coverage, on an emulated processor.

The stream of calls is binary. Each record is two int32, ``which`` and ``times``, then the bytes of
the input struct once. ``which`` is the index in ``entry_points``; ``FRESH`` (-1) stands for a new
instance of every controller, in dirty memory, through ``_init``. For each of the ``times`` calls
come back an int32 status and the bytes of the output struct.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from servogen.controllers.design import Declaration, Operation, Port, Status, Value
from servogen.sil.harness import Call

FRESH = -1
# What memory holds before init: what init forgets is garbage, as on a target.
DIRT = 0xA5


@dataclass(frozen=True)
class Play:
    """Calls on one fresh instance of the controller with this prefix.

    ``repeats``: for each call, how often it is made (operations without inputs only).
    """

    name: str
    prefix: str
    calls: tuple[Call, ...]
    repeats: tuple[int, ...] = ()

    def counted(self) -> Iterator[tuple[Call, int]]:
        return zip(self.calls, self.repeats or (1,) * len(self.calls), strict=True)


@dataclass(frozen=True)
class Answer:
    """What one call gave back; ``index`` counts the calls of a play, repeated ones singly."""

    play: str
    index: int
    prefix: str
    operation: str
    status: int
    outputs: np.void | None


def struct_layout(ports: Sequence[Port], declaration: Declaration) -> np.dtype[Any]:
    """The struct as C lays it out (x86-64, ARM, C6000: doubles on multiples of eight)."""
    fields = []
    for port in ports:
        kind = np.dtype(np.int32) if port.integer else declaration.precision.dtype
        fields.append((port.name, kind, (port.size,)) if port.size else (port.name, kind))
    return np.dtype(fields, align=True)


def entry_points(declarations: Sequence[Declaration]) -> list[tuple[Declaration, Operation]]:
    """All operations of all controllers, in the order that numbers them."""
    return [(d, op) for d in declarations for op in d.operations]


def pack_inputs(
    declaration: Declaration, operation: Operation, inputs: Mapping[str, Value]
) -> bytes:
    """The bytes of an input struct; padding is zero."""
    record = np.zeros((), struct_layout(operation.inputs, declaration))
    for port in operation.inputs:
        record[port.name] = inputs[port.name]
    return record.tobytes()


def encode(declarations: Sequence[Declaration], plays: Iterable[Play]) -> bytes:
    """The stream of all plays, each from fresh instances on."""
    number = {(d.prefix, op.name): i for i, (d, op) in enumerate(entry_points(declarations))}
    by_prefix = {d.prefix: d for d in declarations}
    parts: list[bytes] = []
    for play in plays:
        parts.append(struct.pack("<ii", FRESH, 1))
        d = by_prefix[play.prefix]
        for call, times in play.counted():
            op = d.operation(call.operation)
            parts.append(struct.pack("<ii", number[play.prefix, call.operation], times))
            if op.inputs:
                parts.append(pack_inputs(d, op, call.inputs))
    return b"".join(parts)


def decode(
    declarations: Sequence[Declaration], plays: Iterable[Play], told: bytes
) -> Iterator[Answer]:
    """The answers to ``encode``'s stream, call by call.

    Raises:
        ValueError: there are fewer or more answers than calls.
    """
    by_prefix = {d.prefix: d for d in declarations}
    offset = 0
    for play in plays:
        d, index = by_prefix[play.prefix], 0
        for call, times in play.counted():
            op = d.operation(call.operation)
            kind = struct_layout(op.outputs, d) if op.outputs else None
            for _ in range(times):
                size = 4 + (kind.itemsize if kind is not None else 0)
                if offset + size > len(told):
                    raise ValueError(f"the answers end at {play.name}, call {index}")
                (status,) = struct.unpack_from("<i", told, offset)
                values = np.frombuffer(told, kind, 1, offset + 4)[0] if kind is not None else None
                yield Answer(play.name, index, play.prefix, op.name, status, values)
                offset += size
                index += 1
    if offset != len(told):
        raise ValueError(f"{len(told) - offset} bytes more than answers were expected")


def differing(first: Answer, second: Answer) -> str | None:
    """Name of the first item whose bits differ between two answers; padding does not count."""
    if first.status != second.status:
        return "status"
    if first.outputs is None or second.outputs is None:
        return None
    for name in first.outputs.dtype.names or ():
        if first.outputs[name].tobytes() != second.outputs[name].tobytes():
            return str(name)
    return None


def status_name(status: int) -> str:
    """``SG_OK`` and so on; the number where the C has no such status."""
    return f"SG_{Status(status).name}" if status in tuple(Status) else str(status)


def player_source(declarations: Sequence[Declaration]) -> str:
    """The program, C99. Compile it with the package's sources.

    Macros: ``SG_PLAYER_FILES``: read ``calls.bin`` and write ``results.bin`` in the current folder
    instead of the standard streams. ``SG_PLAYER_MARKS``: call ``sg_player_begin(which)`` right
    before and ``sg_player_end()`` right after every entry point; they are yours to define.
    """
    return _HEAD + "".join(
        [
            "".join(f'#include "{d.prefix}.h"\n' for d in declarations),
            _MARKS,
            _fresh(declarations),
            _dispatch(declarations),
            _MAIN,
        ]
    )


def _fresh(declarations: Sequence[Declaration]) -> str:
    """Instances on the heap, exactly as large as they are: a sanitizer sees what goes beyond."""
    lines = [f"static {d.prefix}_t *{d.prefix}_self;" for d in declarations]
    lines += ["static void fresh(void)", "{"]
    for d in declarations:
        p = f"{d.prefix}_self"
        lines.append(f"    free({p}); {p} = malloc(sizeof *{p}); memset({p}, {DIRT}, sizeof *{p});")
        lines.append(f"    {d.prefix}_init({p});")
    return "\n".join([*lines, "}", ""])


def _dispatch(declarations: Sequence[Declaration]) -> str:
    lines = ["static int play(int which, int times)", "{", "    switch (which) {"]
    for number, (d, op) in enumerate(entry_points(declarations)):
        name = f"{d.prefix}_{op.name}"
        arguments = [f"{d.prefix}_self"]
        lines.append(f"    case {number}: {{")
        if op.inputs:
            lines.append(f"        {name}_in *in = malloc(sizeof *in);")
            lines.append("        if (fread(in, sizeof *in, 1, given) != 1) { return 2; }")
            arguments.append("in")
        if op.outputs:
            lines.append(f"        {name}_out *out = malloc(sizeof *out);")
            arguments.append("out")
        lines.append("        for (int i = 0; i < times; i++) {")
        if op.outputs:
            lines.append(f"            memset(out, {DIRT}, sizeof *out);")
        call = f"{name}({', '.join(arguments)});"
        result = "status = (int32_t)" if op.returns_status else "status = 0; "
        lines.append(f"            MARK_BEGIN({number}); {result}{call} MARK_END();")
        lines.append("            fwrite(&status, sizeof status, 1, told);")
        if op.outputs:
            lines.append("            fwrite(out, sizeof *out, 1, told);")
        lines.append("        }")
        if op.inputs:
            lines.append("        free(in);")
        if op.outputs:
            lines.append("        free(out);")
        lines += ["        break;", "    }"]
    lines += ["    default: return 3;", "    }", "    return 0;", "}", ""]
    return "\n".join(lines)


_HEAD = """\
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
"""

_MARKS = """
#ifdef SG_PLAYER_MARKS
void sg_player_begin(int which);
void sg_player_end(void);
#define MARK_BEGIN(which) sg_player_begin(which)
#define MARK_END() sg_player_end()
#else
#define MARK_BEGIN(which) ((void)0)
#define MARK_END() ((void)0)
#endif

static FILE *given, *told;
static int32_t status;
"""

_MAIN = """
int main(void)
{
    int32_t head[2];
    int result = 0;
#ifdef SG_PLAYER_FILES
    given = fopen("calls.bin", "rb");
    told = fopen("results.bin", "wb");
    if (given == NULL || told == NULL) { return 4; }
#else
    given = stdin;
    told = stdout;
#endif
    fresh();
    while (result == 0 && fread(head, sizeof head, 1, given) == 1) {
        if (head[0] == -1) { fresh(); } else { result = play(head[0], head[1]); }
    }
    fclose(told);
    return result;
}
"""
