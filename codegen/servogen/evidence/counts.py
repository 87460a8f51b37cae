"""The check that a run never does more than was counted, and just that where nothing is decided.

With it goes what else the syntax tree tells of a run's time: what may be interrupted by what.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from servogen.evidence.bench import Bench, Subject
from servogen.evidence.counts_run import EntryRuns, Offence, Runs, count_runs, entry_names
from servogen.evidence.finding import Finding
from servogen.evidence.preemption import examine_preemption, shared_lines
from servogen.evidence.tools import version_of
from servogen.progress import Progress
from servogen.sil.player import Play
from servogen.wcet.operations import CLASSES
from servogen.wcet.package import Count

CHECK = "counts"
# Random calls with inputs of their own, over all controllers of a project, in each precision.
RANDOM_CALLS = 10_000


def run(bench: Bench, progress: Progress) -> Finding:
    """Every entry point of every controller, in both precisions."""
    faults: list[str] = []
    figures: dict[str, Any] = {}
    preemption: dict[str, Any] = {}
    for subject in bench.subjects:
        with progress.task(f"Counting while it runs, {subject.precision.name}"):
            plays = played(subject)
            runs = count_runs(subject, plays)
        interrupted, preemption[subject.precision.name] = examine_preemption(subject)
        told = [*judge(subject, plays, runs), *interrupted]
        faults += [f"{subject.precision.name}, {fault}" for fault in told]
        figures[subject.precision.name] = _figures(subject, plays, runs)
    return Finding(
        check=CHECK,
        passed=not faults,
        summary=_summary(figures),
        tools={"gcc": version_of(["gcc", "--version"])},
        subjects=bench.digests,
        figures={**figures, "preemption": preemption},
        faults=tuple(faults),
        details=(
            *(line for name, found in figures.items() for line in _lines(name, found)),
            *dict.fromkeys(line for own in preemption.values() for line in shared_lines(own)),
        ),
    )


def played(subject: Subject) -> list[Play]:
    """Edges, the random calls, the whole closed loop."""
    steps = -(-RANDOM_CALLS // len(subject.package.declarations))
    return [*subject.suite(steps), *subject.closed_loops(None)]


def judge(subject: Subject, plays: Sequence[Play], runs: Runs) -> list[str]:
    """A sentence for each entry point whose runs are not covered, or that was never run."""
    faults = []
    random = _random_calls(subject, plays)
    if random < RANDOM_CALLS:
        faults.append(f"{random} random calls where {RANDOM_CALLS} are wanted")
    for name in entry_names(subject):
        entry = runs.entries[name]
        if entry.calls == 0:
            faults.append(f"{name} was never called")
        if entry.above is not None:
            faults.append(f"{name}: {_told(entry.above, plays)}, counted at most")
        elif entry.unequal is not None:
            faults.append(f"{name}: {_told(entry.unequal, plays)}, counted for every run")
        elif not subject.counts.entry_points[name].total().covers(entry.largest):
            faults.append(f"{name} does more turns of a loop than its bound")
    return faults


def _told(offence: Offence, plays: Sequence[Play]) -> str:
    return (
        f"{offence.ran} {offence.kind} in {_place(offence.call, plays)} where {offence.static} are"
    )


def _place(call: int, plays: Sequence[Play]) -> str:
    """Which play, and which call of it."""
    for play in plays:
        length = sum(times for _, times in play.counted())
        if call < length:
            return f"call {call} of '{play.name}'"
        call -= length
    return "a call of init"


def _random_calls(subject: Subject, plays: Sequence[Play]) -> int:
    """Calls with inputs, in the random plays; steps that only repeat are left out."""
    having = {
        (d.prefix, op.name)
        for d in subject.package.declarations
        for op in d.operations
        if op.inputs
    }
    return sum(
        (play.prefix, call.operation) in having
        for play in plays
        if play.name.endswith("random")
        for call in play.calls
    )


def _figures(subject: Subject, plays: Sequence[Play], runs: Runs) -> dict[str, Any]:
    entries = {
        name: _entry(subject.counts.entry_points[name], runs.entries[name])
        for name in entry_names(subject)
    }
    return {
        "calls": sum(entry.calls for entry in runs.entries.values()),
        "random_calls": _random_calls(subject, plays),
        "bounds_seen_turn_by_turn": list(runs.watched),
        "equal": sum(entry["equal"] for entry in entries.values()),
        "entry_points": entries,
    }


def _entry(count: Count, runs: EntryRuns) -> dict[str, Any]:
    """Static count, largest and least run side by side.

    ``held``: no call broke the count; ``equal``: every call did just what is counted.
    ``ratio``: largest run by static count; ``ratio_of_turns_done``: the same of the closest call,
    by the count for the turns it did.
    """
    static = count.total()
    return {
        "calls": runs.calls,
        "static": static.as_dict(),
        "largest_run": runs.largest.as_dict(),
        "least_run": runs.least.as_dict(),
        "same_in_every_run": list(count.exact),
        "held": runs.calls > 0
        and runs.above is None
        and runs.unequal is None
        and static.covers(runs.largest),
        "equal": static == runs.largest == runs.least,
        "ratio": _share(runs.largest.as_dict(), static.as_dict()),
        "ratio_of_turns_done": runs.closest,
        "caps": dict(count.caps),
        "most_turns": {bound: n for bound, n in runs.turns.items() if bound in count.caps},
    }


def _share(ran: dict[str, int], static: dict[str, int]) -> float:
    """Largest run by static count, all classes added up."""
    total = sum(static.values())
    return sum(ran.values()) / total if total else 1.0


def _summary(figures: dict[str, Any]) -> str:
    told = []
    for name, found in figures.items():
        entries = found["entry_points"].values()
        rest = [e["ratio_of_turns_done"] for e in entries if not e["equal"]]
        near = f", the others from {min(rest):.1%} to {max(rest):.1%} of it" if rest else ""
        told.append(
            f"{name}: {found['calls']} calls, {found['equal']} of {len(entries)} entry points "
            f"always equal to their count{near}"
        )
    return "; ".join(told)


def _lines(precision: str, found: dict[str, Any]) -> list[str]:
    """A row for each entry point."""
    lines = []
    for name, e in found["entry_points"].items():
        told = f"up to {e['ratio_of_turns_done']:.1%} of the count for the turns done"
        if e["equal"]:
            told = "always equal to the count"
        parts = [f"{e['largest_run'][c]} of {e['static'][c]} {c}" for c in CLASSES[:4]]
        shown = [p for p, c in zip(parts, CLASSES[:4], strict=True) if e["static"][c]]
        turns = [f"{n} of {e['caps'][bound]} turns" for bound, n in e["most_turns"].items()]
        lines.append(f"{precision} {name}: {e['calls']} calls, {', '.join([told, *turns, *shown])}")
    return lines
