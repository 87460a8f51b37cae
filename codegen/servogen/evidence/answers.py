"""What every answer of a controller has to be, whatever the call was."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from servogen.controllers.design import Declaration, Operation, Port, Status
from servogen.precision import FloatArray
from servogen.sil.player import Play, struct_layout

ROUNDING = 4.0  # units in the last place that a value between two others may lie beyond them


@dataclass
class Answers:
    """All answers of one entry point: ``statuses`` one by one, ``outputs`` as the C laid them."""

    declaration: Declaration
    operation: Operation
    statuses: list[int] = field(default_factory=list)
    outputs: list[bytes] = field(default_factory=list)


def answers(
    declarations: Sequence[Declaration], plays: Sequence[Play], told: bytes
) -> list[Answers]:
    """The player's results for ``plays``, sorted by entry point.

    Raises:
        ValueError: there are fewer or more answers than calls.
    """
    by_prefix = {d.prefix: d for d in declarations}
    found: dict[tuple[str, str], Answers] = {}
    offset = 0
    for play in plays:
        d = by_prefix[play.prefix]
        sizes = {op.name: struct_layout(op.outputs, d).itemsize for op in d.operations}
        for call, times in play.counted():
            name = call.operation
            here = found.setdefault((d.prefix, name), Answers(d, d.operation(name)))
            for _ in range(times):
                end = offset + 4 + sizes[name]
                if end > len(told):
                    raise ValueError("fewer answers than calls")
                here.statuses += struct.unpack_from("<i", told, offset)
                here.outputs.append(told[offset + 4 : end])
                offset = end
    if offset != len(told):
        raise ValueError("more answers than calls")
    return list(found.values())


def misjudged(every: Sequence[Answers]) -> list[str]:
    """A sentence for each status outside of the enumeration and each output that is not finite or
    beyond its declared range."""
    faults = []
    for a in every:
        name = f"{a.declaration.prefix}_{a.operation.name}"
        strange = sorted(set(a.statuses) - {int(status) for status in Status})
        faults += [f"{name}: status {number} is none of the enumeration" for number in strange]
        if a.operation.outputs:
            table = np.frombuffer(
                b"".join(a.outputs), struct_layout(a.operation.outputs, a.declaration)
            )
            for port in a.operation.outputs:
                fault = _misjudged(port, table[port.name], a.declaration)
                faults += [f"{name}: {port.name} {fault}"] if fault else []
    return faults


def _misjudged(port: Port, values: FloatArray, d: Declaration) -> str:
    if not np.all(np.isfinite(values)):
        return "is not finite"
    if port.low is None or port.high is None:
        return ""
    epsilon = 0.0 if port.integer else float(np.finfo(d.precision.dtype).eps)
    room = ROUNDING * epsilon * max(abs(port.low), abs(port.high))
    least, greatest = float(np.min(values)), float(np.max(values))
    if least < port.low - room or greatest > port.high + room:
        return f"goes from {least!r} to {greatest!r}, declared {port.low!r} to {port.high!r}"
    return ""
