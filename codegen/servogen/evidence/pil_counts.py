"""Instructions executed against operations counted, call for call and in the worst case.

Three counts of each call meet here. *Static*: the worst case read from the C. *Counted*: what the
counting twin of the C did on the host in this very call. *Executed*: instructions of the processor.
For every call and class, executed <= counted <= static. An entry point is straight-line where
additions, multiplications, divisions and square roots do not depend on the data, that is where
every call counted as many as the worst case has: there executed and counted must be equal.
Compilers do a little less elsewhere (a product that both ways of a decision need), never more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servogen.evidence.pil_map import ARITHMETIC, COLUMNS
from servogen.evidence.pil_run import Rows
from servogen.wcet.operations import CLASSES, OperationCounts

EXACT = ("add", "mul", "div", "sqrt")


@dataclass(frozen=True)
class EntryPoint:
    """One entry point on one processor.

    Attributes:
        calls: so many were counted.
        instructions: of the call with the most.
        operations: all classes of the static worst case together.
        factor: the largest ratio, over the calls, of instructions to operations counted.
        straight: see the head of the module.
        executed, counted, static: class -> of the call with the most of it; classes that are
            zero in all three are left out.
    """

    name: str
    calls: int
    instructions: int
    operations: int
    factor: float
    straight: bool
    executed: Mapping[str, int]
    counted: Mapping[str, int]
    static: Mapping[str, int]

    def to_json(self) -> dict[str, object]:
        return {
            "calls": self.calls,
            "instructions": self.instructions,
            "static_operations": self.operations,
            "instructions_per_static_operation": round(self.instructions / self.operations, 3),
            "largest_factor_of_a_call": round(self.factor, 3),
            "straight_line": self.straight,
            "executed": dict(self.executed),
            "counted": dict(self.counted),
            "static": dict(self.static),
        }


def compare_counts(
    name: str, counted: Rows, executed: Rows, static: OperationCounts, limit: float
) -> tuple[EntryPoint, list[str]]:
    """One entry point's calls, (calls, classes) each, and what is wrong with them.

    Args:
        limit: instructions of a call for each operation that the twin counted in it.
    """
    worst = static.as_dict()
    ours = {c: _column(counted, CLASSES.index(c)) for c in CLASSES}
    theirs = {c: _column(executed, COLUMNS.index(c)) for c in COLUMNS}
    straight = all((ours[c] == worst[c]).all() for c in EXACT)
    faults = [
        fault
        for c in ARITHMETIC
        for fault in _judge(name, c, theirs[c], ours[c], worst[c], straight and c in EXACT)
    ]
    if theirs["fused"].any():
        faults.append(f"{name}: {int(theirs['fused'].max())} fused multiply-adds in one call")
    operations = np.sum([ours[c] for c in CLASSES], axis=0)
    ratios = theirs["total"] / np.maximum(operations, 1)
    if ratios.max() > limit:
        faults.append(
            f"{name}: {ratios.max():.2f} instructions for each operation counted, "
            f"the stated factor is {limit:g}"
        )
    shown = [c for c in ARITHMETIC if worst[c] or ours[c].any() or theirs[c].any()]
    point = EntryPoint(
        name, len(operations), int(theirs["total"].max()), sum(worst.values()),
        float(ratios.max()), straight,
        {c: int(theirs[c].max()) for c in shown},
        {c: int(ours[c].max()) for c in shown},
        {c: worst[c] for c in shown},
    )  # fmt: skip
    return point, faults


def _judge(
    name: str, what: str, executed: NDArray[np.int64], counted: NDArray[np.int64], worst: int,
    exactly: bool,
) -> list[str]:  # fmt: skip
    faults = []
    if counted.max() > worst:
        faults.append(f"{name}: a run counted {counted.max()} {what}, the static count is {worst}")
    more = executed - counted
    if more.max() > 0:
        at = int(more.argmax())
        faults.append(
            f"{name}: {executed[at]} {what} executed in one call, the C has {counted[at]}"
        )
    elif exactly and more.min() < 0:
        at = int(more.argmin())
        faults.append(
            f"{name}: {executed[at]} {what} executed in one call of straight-line code, "
            f"the C has {counted[at]}"
        )
    return faults


def compare_all(
    names: Sequence[str],
    which: NDArray[np.integer],
    counted: Rows,
    executed: Rows,
    static: Mapping[str, OperationCounts],
    limit: float,
) -> tuple[list[EntryPoint], list[str]]:
    """All entry points that were called, in the order of ``names``, and the faults.

    Args:
        which: (calls,) index into ``names`` of each call.
    """
    if not len(which) == len(counted) == len(executed):
        return [], [
            f"{len(which)} calls were made, {len(counted)} counted on the host and "
            f"{len(executed)} on the board"
        ]
    points, faults = [], []
    for number, name in enumerate(names):
        mask = which == number
        if not mask.any():
            faults.append(f"{name} was never called")
            continue
        point, found = compare_counts(name, counted[mask], executed[mask], static[name], limit)
        points.append(point)
        faults += found
    if not any(p.straight and sum(p.static[c] for c in EXACT if c in p.static) for p in points):
        faults.append("no straight-line entry point with arithmetic: nothing was held to equality")
    return points, faults


def _column(rows: Rows, index: int) -> NDArray[np.int64]:
    return rows[:, index].astype(np.int64)
