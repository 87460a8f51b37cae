"""What a controller declares, once, for the reference, the C, the harness, the counts and the docs.

A ``Declaration`` names everything the emitted C will contain: constants, tables, state, operations
with their ports. The Python reference offers methods of the same names; one harness drives both.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol

import numpy as np

from servogen.precision import FloatArray, IntArray, Precision

Value = int | float | np.floating | FloatArray


class Status(IntEnum):
    """What a step says about itself; the values are those of ``sg_status`` in the C runtime."""

    OK = 0
    PRIMING = 1  # the horizon is being filled; the machine stands
    FINISHED = 2  # the whole path is processed
    SUBOPTIMAL = 3  # iteration cap reached, a feasible plan short of the optimum is used
    BACKUP = 4  # iteration cap reached, it is not; the shifted plan (Corollary 1) is used
    INFEASIBLE = 5  # not even the shifted plan is feasible from the measured state; it is held
    NOT_FINITE = 6  # an input is NaN or infinite; the plan goes on without the measurement
    OUT_OF_RANGE = 7  # an input is outside its declared range; likewise
    OVERFLOW = 8  # more points or intervals than there is room for; nothing was taken
    NOT_READY = 9  # called before reset
    UNREACHABLE = 10  # the path cannot be followed: the machine stands until it is given another


@dataclass(frozen=True)
class Port:
    """One input or output of an operation.

    Attributes:
        name: C identifier.
        unit: for the comment, ``m``.
        doc: what it is.
        size: 0 for a scalar, else the array's length.
        integer: ``int32_t`` instead of the scalar type.
        low, high: declared range. An input beyond it is refused by status; an output is never
            beyond it, whatever came in (but for the rounding of a sum). None: any finite value.
    """

    name: str
    unit: str
    doc: str
    size: int = 0
    integer: bool = False
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Operation:
    """An entry point ``<prefix>_<name>(self, in, out)``; no struct where there are no ports.

    ``shares`` names an operation with the same ports, whose structs this one uses too.
    ``reads_only``: it leaves the state as it is.
    ``returns_status`` is False for operations that cannot fail and have nothing to say.
    ``period_s``: it is called once in this time by the user; 0 where it is called now and then, by
    another controller, or in place of others. ``deadline_s``: it has to be done within this time of
    its call, and nothing with a longer one may keep it from that; 0: within its period.
    """

    name: str
    doc: str
    inputs: tuple[Port, ...] = ()
    outputs: tuple[Port, ...] = ()
    returns_status: bool = True
    shares: str = ""
    reads_only: bool = False
    period_s: float = 0.0
    deadline_s: float = 0.0


@dataclass(frozen=True)
class Table:
    """A constant table of the scalar type, or of ``int32_t``; one or two dimensions."""

    name: str
    values: FloatArray | IntArray
    doc: str
    integer: bool = False

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.int32 if self.integer else np.float64)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)


@dataclass(frozen=True)
class Constant:
    """A scalar of the scalar type."""

    name: str
    value: float
    doc: str


@dataclass(frozen=True)
class Dimension:
    """An integer constant: an array size, a loop bound, a cap."""

    name: str
    value: int
    doc: str


@dataclass(frozen=True)
class StateField:
    """One member of ``<prefix>_t``.

    Attributes:
        size: name of a ``Dimension``, or empty for a scalar.
        type: empty for the scalar type, ``int32_t``, or the prefix of a controller used.
        bound: name of the table whose entries the elements never exceed in absolute value,
            whatever came in. Only such members may be read by a controller that uses this one.
    """

    name: str
    doc: str
    size: str = ""
    type: str = ""
    bound: str = ""


@dataclass(frozen=True)
class Map:
    """For the caller: what an input of an operation is of the user's own quantities.

    Attributes:
        values: matrix from those to the input, in float64; it is told, not emitted.
    """

    name: str
    values: FloatArray
    doc: str


@dataclass(frozen=True)
class Declaration:
    """All that emission, counting and proof need to know of one controller.

    Attributes:
        kind: which template lays it out (``governor``, ``mpc``, ...).
        prefix: C prefix of all names.
        summary: one line for the head of the file.
        sample_time_s: period at which ``step`` is called.
        uses: prefixes of the controllers it calls.
        replaces: prefix of the controller that it stands in for: one of the two runs, never both.
        facts: decisions a template may need that are not numbers in the C (flags, sub-prefixes).
        trusting: entry points for a controller that uses this one and has bounded their inputs
            itself: these are not looked at, and the proof of the caller shows that they keep their
            ranges. No harness calls them with anything else.
        maps: what a caller may need to make inputs of what the user knows.
    """

    kind: str
    prefix: str
    summary: str
    precision: Precision
    sample_time_s: float
    dimensions: tuple[Dimension, ...]
    constants: tuple[Constant, ...]
    tables: tuple[Table, ...]
    operations: tuple[Operation, ...]
    state: tuple[StateField, ...]
    uses: tuple[str, ...] = ()
    replaces: str = ""
    facts: Mapping[str, object] = field(default_factory=dict)
    trusting: tuple[Operation, ...] = ()
    maps: tuple[Map, ...] = ()

    @property
    def entries(self) -> tuple[Operation, ...]:
        """All entry points but ``init``."""
        return self.operations + self.trusting

    @property
    def table_bytes(self) -> int:
        reals = len(self.constants) + sum(t.values.size for t in self.tables if not t.integer)
        whole = sum(t.values.nbytes for t in self.tables if t.integer)
        return reals * self.precision.bytes + whole

    def operation(self, name: str) -> Operation:
        return next(op for op in self.operations if op.name == name)

    def fingerprint(self) -> dict[str, object]:
        """A plain structure with every decision in it, in a fixed order."""
        trusting = {"trusting": [op.name for op in self.trusting]} if self.trusting else {}
        return {
            **trusting,
            "kind": self.kind,
            "prefix": self.prefix,
            "precision": self.precision.name,
            "sample_time_s": self.sample_time_s.hex(),
            "dimensions": [[d.name, d.value] for d in self.dimensions],
            "constants": [[c.name, float(c.value).hex()] for c in self.constants],
            "tables": [
                [t.name, list(t.values.shape), hashlib.sha256(t.values.tobytes()).hexdigest()]
                for t in self.tables
            ],
            "operations": [
                [op.name, [[p.name, p.size, p.low, p.high] for p in op.inputs + op.outputs]]
                for op in self.operations
            ],
            "state": [[f.name, f.size, f.type, f.bound] for f in self.state],
            "uses": list(self.uses),
            "facts": {key: str(self.facts[key]) for key in sorted(self.facts)},
        }


def design_hash(declarations: tuple[Declaration, ...]) -> str:
    """Names a build: sha-256 over every decision of every controller in it."""
    text = json.dumps([d.fingerprint() for d in declarations], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


class Reference(Protocol):
    """A Python reference: operations are methods of the declared names.

    ``call("step", inputs)`` returns the status and the outputs by port name.
    """

    @property
    def declaration(self) -> Declaration: ...

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]: ...
