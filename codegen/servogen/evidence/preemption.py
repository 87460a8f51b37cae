"""That ``fast_step`` may interrupt ``plan``: what both touch is on a list, with the reason.

Members of the controller that the two read and write are taken from the C's syntax tree
(``wcet.access``), an array as a whole. One that only one of them knows, or that neither writes, is
safe; every other must be in ``SAFE``.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from servogen.evidence.bench import Subject
from servogen.wcet.access import accesses, kept_outside, shared
from servogen.wcet.program import Program

INTERRUPTED, INTERRUPTS = ("predict", "plan"), "fast_step"

_RING = """\
plan writes behind the newest point, fast_step reads from the interval's first point to its last; \
the ring holds one interval more than may wait, so that the present one is never written over"""
SAFE = {"fast.path_x": _RING, "fast.path_y": _RING}


def examine_preemption(subject: Subject) -> tuple[list[str], dict[str, Any]]:
    """Faults, and for each entry point that may be interrupted what it shares.

    Raises:
        CheckFailed: C in which a pointer cannot be followed.
    """
    prefix = subject.package.declarations[-1].prefix
    with tempfile.TemporaryDirectory(prefix="servogen-preemption-") as name:
        folder = Path(name)
        program = Program(subject.write(folder), [folder])
        other = accesses(program, f"{prefix}_{INTERRUPTS}")
        outside = kept_outside(program)
        found = {
            entry: sorted(shared(accesses(program, f"{prefix}_{entry}"), other))
            for entry in INTERRUPTED
        }
    faults = [
        f"{prefix}_{INTERRUPTS} may interrupt {prefix}_{entry}, and both touch {member}"
        for entry, members in found.items()
        for member in members
        if member not in SAFE
    ]
    every = {member for members in found.values() for member in members}
    faults += [
        f"{member} is listed as shared and safe, and is not shared"
        for member in SAFE
        if member not in every
    ]
    faults += [f"{name} outlives a call and is no part of the controller" for name in outside]
    if not other.writes:
        faults.append(f"{prefix}_{INTERRUPTS} writes nothing: it was not read")
    return faults, {"interrupts": INTERRUPTS, "shared": found, "safe": SAFE}
