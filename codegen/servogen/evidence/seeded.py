"""Which check finds which planted fault: every check on every mutant, as one table.

``steps.plant_faults`` runs it. What a check said of the same C before is taken from a file, so that
an interrupted run goes on and columns can be made one by one. A check that cannot be run here, or
is not chosen and was not run before, is shown as not run; so is one that already fails on the sound
package and thus says nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

from servogen.errors import CheckFailed
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.catalogue import CHECKS
from servogen.evidence.seeded_active_set import ACTIVE_SET_FAULTS
from servogen.evidence.seeded_faults import FAULTS, Fault, plant
from servogen.evidence.seeded_kept import Kept
from servogen.evidence.seeded_quick import Equivalence, Quick, StaticCount, warnings
from servogen.evidence.seeded_table import Row
from servogen.evidence.tools import ToolMissing
from servogen.progress import Progress, Silent

STEPS = 60  # random steps per controller for the equivalence of a mutant
PERIODS = 60  # and slow periods of its closed loop
# Checks whose every call costs are given fewer: steps at most, slow periods at most.
SHORTENED = {"sanitizers": (10, 40), "pil": (10, 20), "prove": (10, 20)}
# Fuzzing a mutant: a time that suits a table, and nothing of it goes to the kept corpus.
FUZZING = {"FUZZ_SECONDS": "20", "FUZZ_KEEP": "0"}


@dataclass(frozen=True)
class Column:
    """A check as it is used here: ``obstacle`` says why it is not run."""

    title: str
    judge: Quick
    obstacle: str = ""


def run_seeded(
    bench: Bench, columns: Sequence[Column], progress: Progress, kept: Kept | None = None
) -> list[Row]:
    """Plant every fault in every subject and ask every check that has not been asked before.

    Raises:
        CheckFailed: a fault cannot be planted.
    """
    rows = []
    faults = faults_for(bench)
    with progress.task("Planting faults", total=len(faults)) as task:
        for fault in faults:
            mutant = with_fault(bench, fault)
            said = {c.title: _asked(c, mutant, kept) for c in columns}
            rows.append(Row(fault, said))
            task.advance()
    return rows


def faults_for(bench: Bench) -> tuple[Fault, ...]:
    """Those of the method that solves the MPC's program."""
    own = bench.subjects[0].package.declarations
    return ACTIVE_SET_FAULTS if any(d.facts.get("active_set") for d in own) else FAULTS


def with_fault(bench: Bench, fault: Fault) -> Bench:
    """The bench with the fault in the C of every subject; calls and counts are the sound one's."""
    planted = [replace(s, package=plant(fault, s.package)) for s in bench.subjects]
    return replace(bench, subjects=tuple(planted))


def _asked(column: Column, mutant: Bench, kept: Kept | None) -> str:
    """``caught``, ``missed``, or why the check was not run."""
    before = kept.find(column.title, mutant) if kept is not None else None
    if before is not None or column.obstacle:
        return before or column.obstacle
    try:
        said = "caught" if column.judge(mutant) else "missed"
    except CheckFailed:  # refused: does not compile, cannot be counted, no answer
        said = "caught"
    except Exception as error:  # not the fault's doing: shown, and hours of work are not lost
        return f"broke: {type(error).__name__}"
    if kept is not None:
        kept.keep(column.title, mutant, said)
    return said


def columns_for(bench: Bench, names: Sequence[str], kept: Kept) -> list[Column]:
    """The quick checks, learned from the sound bench, and the catalogue's, tried on it first."""
    equivalence = Equivalence(
        {s.precision.name: [*s.suite(STEPS), *s.closed_loops(PERIODS)] for s in bench.subjects}
    )
    equivalence.learn(bench)
    counts = StaticCount()
    counts.learn(bench)
    quick: dict[str, Quick] = {
        "gcc -Werror": warnings,
        "sil": equivalence,
        "count of the head": counts,
    }
    columns = [_tried(Column(title, judge), bench, kept) for title, judge in quick.items()]
    for name in CHECKS:
        chosen = not names or name in names
        column = Column(name, _judge_of(name), "" if chosen else "not chosen")
        columns.append(_tried(column, bench, kept) if chosen else column)
    return columns


def _judge_of(name: str) -> Quick:
    def judge(bench: Bench) -> list[str]:
        finding = CHECKS[name].run(shortened(bench, *SHORTENED.get(name, (None, None))), Silent())
        return [] if finding.passed else list(finding.faults) or [finding.summary]

    return judge


def _tried(column: Column, bench: Bench, kept: Kept) -> Column:
    """The column with its obstacle, if it has one: tool missing, or faults in sound C."""
    if kept.find(column.title, bench) == "missed":
        return column
    try:
        faults = column.judge(bench)
    except ToolMissing:
        return replace(column, obstacle="tool missing")
    except ModuleNotFoundError:
        return replace(column, obstacle="no such check yet")
    except CheckFailed as refused:
        faults = [str(refused)]
    for fault in faults[:3]:
        print(f"seeded: {column.title} fails on the sound C: {fault}", file=sys.stderr)
    if faults:
        return replace(column, obstacle="fails on the sound C")
    kept.keep(column.title, bench, "missed")
    return column


def shortened(bench: Bench, steps: int | None, periods: int | None) -> Bench:
    """The bench with no more than so many random steps and slow periods; None for all."""
    if steps is None:
        return bench

    def fewer(subject: Subject) -> Subject:
        return replace(
            subject,
            suite=lambda count: subject.suite(min(count, steps)),
            closed_loops=lambda asked: subject.closed_loops(periods),
        )

    return replace(bench, subjects=tuple(fewer(s) for s in bench.subjects))


def remembered(bench: Bench) -> Bench:
    """The bench in its own precision alone; what is costly to record is recorded once."""
    own = bench.subjects[0]
    kept: Subject = replace(own, suite=cache(own.suite), closed_loops=cache(own.closed_loops))
    return replace(bench, subjects=(kept,))
