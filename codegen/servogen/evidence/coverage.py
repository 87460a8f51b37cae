"""Which branches of the emitted C the equivalence suite and the closed loop reach."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servogen.evidence.bench import Bench, Subject
from servogen.evidence.coverage_build import Measured, Tally, measure
from servogen.evidence.coverage_list import Branch, Compared, Entry, Placed, compare, reviewed
from servogen.evidence.finding import Finding
from servogen.evidence.tools import version_of
from servogen.progress import Progress
from servogen.sil.player import Play, encode

STEPS = 400  # random steps per controller; the edges come on top


@dataclass(frozen=True)
class Covered:
    """One package's result: what was measured, per file, and beside the list."""

    calls: int
    measured: Measured
    files: dict[str, tuple[int, int]]
    compared: Compared

    @property
    def total(self) -> int:
        return sum(total for total, _ in self.files.values())

    @property
    def reached(self) -> int:
        return sum(reached for _, reached in self.files.values())

    @property
    def faults(self) -> list[str]:
        found = [*self.measured.faults, *map(str, self.compared.unlisted)]
        return found if self.total and self.calls else [*found, "no branch or no call to look at"]


def run(bench: Bench, progress: Progress) -> Finding:
    """See ``evidence.catalogue``.

    Raises:
        ToolMissing: no gcc or gcov.
        CheckFailed: the C does not compile here, or holds a statement that is not read.
    """
    entries = reviewed()
    results: dict[str, Covered] = {}
    with progress.task("Branches reached", total=len(bench.subjects)) as task:
        for subject in bench.subjects:
            plays = [*subject.suite(STEPS), *subject.closed_loops(None)]
            results[subject.precision.name] = cover(subject, plays, entries)
            task.advance()
    faults = [f"{name}: {fault}" for name, r in results.items() for fault in r.faults]
    own = results[bench.subjects[0].precision.name]
    return Finding(
        check="coverage",
        passed=not faults,
        summary=", ".join(_summary(name, r) for name, r in results.items()),
        tools={"gcc": version_of(["gcc", "--version"]), "gcov": version_of(["gcov", "--version"])},
        subjects=bench.digests,
        figures={name: _figures(r) for name, r in results.items()},
        faults=tuple(faults),
        details=tuple(f"{place}: {entry.reason}" for place, entry in own.compared.justified),
    )


def cover(subject: Subject, plays: Sequence[Play], entries: Sequence[Entry]) -> Covered:
    """Play the calls on the package and hold what they reached against the list."""
    stream = encode(subject.package.declarations, plays)
    with tempfile.TemporaryDirectory(prefix="servogen-coverage-") as folder:
        measured = measure(subject, stream, Path(folder))
    reached, unreached = branches(measured.tallies)
    files: dict[str, tuple[int, int]] = {}
    for place in sorted(reached | unreached):
        total, seen = files.get(place.file, (0, 0))
        files[place.file] = total + 1, seen + (place in reached)
    calls = sum(times for play in plays for _, times in play.counted())
    kinds = {d.kind for d in subject.package.declarations}
    here = [entry for entry in entries if not entry.only_with or kinds & set(entry.only_with)]
    return Covered(calls, measured, files, compare(reached, unreached, here))


def branches(tallies: Sequence[Tally]) -> tuple[set[Placed], set[Placed]]:
    """The branches reached and those not; a shared kernel's count where any unit has them."""
    every: set[Placed] = set()
    reached: set[Placed] = set()
    for t in tallies:
        for way, count in ((False, t.false), (True, t.true)):
            placed = Placed(t.site.file, Branch(t.site.decision, way))
            every.add(placed)
            if count:
                reached.add(placed)
    return reached, every - reached


def _summary(precision: str, r: Covered) -> str:
    return (
        f"{precision}: {r.reached} of {r.total} branches, {len(r.compared.justified)} justified"
        f"{f', {len(r.compared.unlisted)} not' if r.compared.unlisted else ''}"
    )


def _figures(r: Covered) -> dict[str, Any]:
    units: dict[str, dict[str, list[int]]] = {}
    for t in r.measured.tallies:
        pair = units.setdefault(t.unit, {}).setdefault(t.site.file, [0, 0])
        pair[0] += 2
        pair[1] += (t.true > 0) + (t.false > 0)
    return {
        "calls": r.calls,
        "branches": r.total,
        "reached": r.reached,
        "justified": len(r.compared.justified),
        "mcdc": not r.measured.faults,
        "files": {f: {"branches": n, "reached": m} for f, (n, m) in r.files.items()},
        "units": {
            unit: {f: {"branches": n, "reached": m} for f, (n, m) in files.items()}
            for unit, files in units.items()
        },
        "gcov": {"branches": r.measured.gcov_branches, "taken": r.measured.gcov_taken},
        "unreached": [str(place) for place, _ in r.compared.justified],
        "listed_but_reached_here": [str(entry.branch) for entry in r.compared.unneeded],
    }
