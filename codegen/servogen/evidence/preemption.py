"""That an entry point may interrupt another: what both touch is on a list, with the reason.

Members of the controller that the two read and write are taken from the C's syntax tree
(``wcet.access``), an array as a whole. One that only one of them knows, or that neither writes, is
safe; every other must be on the rule's list.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servogen.evidence.bench import Subject
from servogen.wcet.access import accesses, kept_outside, shared
from servogen.wcet.program import Program

_RING = """\
plan writes behind the newest point, fast_step reads from the interval's first point to its last; \
the ring holds one interval more than may wait, so that the present one is never written over"""
SAFE = {"fast.path_x": _RING, "fast.path_y": _RING}
SAFE_PID = {
    "wanted": "step writes it once, and filter_step reads what this sample or the one before asked "
    "for, where the target stores a scalar by one instruction"
}


@dataclass(frozen=True)
class Rule:
    """``interrupts`` may interrupt each of ``interrupted``, entry points of one controller; what
    they share is ``safe``: member -> why."""

    interrupted: tuple[str, ...]
    interrupts: str
    safe: Mapping[str, str]


RULES = (Rule(("predict", "plan"), "fast_step", SAFE), Rule(("step",), "filter_step", SAFE_PID))


def examine_preemption(subject: Subject) -> tuple[list[str], dict[str, Any]]:
    """Faults, and for each entry point that may be interrupted what it shares; nothing of a package
    that no rule is about, whose users keep its entry points from interrupting each other.

    Raises:
        CheckFailed: C in which a pointer cannot be followed.
    """
    for rule in RULES:
        for declaration in subject.package.declarations:
            entries = {operation.name for operation in declaration.operations}
            if entries >= {*rule.interrupted, rule.interrupts}:
                return _examine(subject, declaration.prefix, rule)
    return [], {}


def _examine(subject: Subject, prefix: str, rule: Rule) -> tuple[list[str], dict[str, Any]]:
    with tempfile.TemporaryDirectory(prefix="servogen-preemption-") as name:
        folder = Path(name)
        program = Program(subject.write(folder), [folder])
        other = accesses(program, f"{prefix}_{rule.interrupts}")
        outside = kept_outside(program)
        found = {
            entry: sorted(shared(accesses(program, f"{prefix}_{entry}"), other))
            for entry in rule.interrupted
        }
    faults = [
        f"{prefix}_{rule.interrupts} may interrupt {prefix}_{entry}, and both touch {member}"
        for entry, members in found.items()
        for member in members
        if member not in rule.safe
    ]
    every = {member for members in found.values() for member in members}
    faults += [
        f"{member} is listed as shared and safe, and is not shared"
        for member in rule.safe
        if member not in every
    ]
    faults += [f"{name} outlives a call and is no part of the controller" for name in outside]
    if not other.reads | other.writes:
        faults.append(f"{prefix}_{rule.interrupts} touches nothing: it was not read")
    return faults, {"interrupts": rule.interrupts, "shared": found, "safe": dict(rule.safe)}


def shared_lines(found: Mapping[str, Any]) -> list[str]:
    """What is shared, and why that is safe, for people."""
    return [
        f"shared by {entry} and {found['interrupts']}, {member}: {found['safe'].get(member, '')}"
        for entry, members in found.get("shared", {}).items()
        for member in members
    ]
