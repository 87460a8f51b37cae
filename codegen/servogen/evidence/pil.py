"""Processor in the loop: the emitted C, compiled for ARM and run on QEMU's boards, gives the host's
bits, and executes no more than the static count allows.

Every call of the SIL suite and of the closed loop is played in both precisions on a Cortex-M4F
(whose double is libgcc's software) and a Cortex-M7. A plugin of QEMU counts the instructions of
each call by class. The first calls are played again with other optimisation. QEMU is no model of
time: nothing here is a cycle.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.errors import CheckFailed
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.children import in_order
from servogen.evidence.finding import Finding
from servogen.evidence.pil_build import (
    CORES,
    Core,
    build_plugin,
    build_target,
    tool_versions,
)
from servogen.evidence.pil_counts import EXACT, EntryPoint, compare_all
from servogen.evidence.pil_levels import PLAIN, Level, play_levels
from servogen.evidence.pil_run import play_board
from servogen.evidence.pil_stand import Stand, make_stand, within
from servogen.evidence.same_bits import first_difference
from servogen.precision import FLOAT64, Precision
from servogen.progress import Progress

RANDOM_STEPS = 200  # of each controller
# Operations on scalars that are played where each is a function of fifty instructions or more:
# about a minute. Beyond it calls are left out, and the finding says so.
SOFTWARE_BUDGET = 500_000_000
LEVEL_BUDGET = 10_000_000  # the same for the calls that are played again with other optimisation
# Instructions of a call, beyond pil_counts.CALL, for each operation that the C counts in it, all
# classes together.
HARDWARE_FACTOR, SOFTWARE_FACTOR = 2.5, 45.0


@dataclass(frozen=True)
class Outcome:
    """What one board did with one package.

    Attributes:
        played, of: calls made, calls there were.
        difference: the first, as a sentence; None where all bits are equal.
        software: arithmetic of this type is done by functions.
        limit: stated factor of instructions to operations.
        kernels: how the names of the kernels' entry points begin.
    """

    precision: str
    core: Core
    played: int
    of: int
    difference: str | None
    software: bool
    limit: float
    kernels: str
    points: tuple[EntryPoint, ...]
    levels: tuple[Level, ...]
    faults: tuple[str, ...]

    @property
    def label(self) -> str:
        return f"{self.precision} on {self.core.title}"

    @property
    def factor(self) -> float:
        """Largest ratio of a call."""
        return max((p.factor for p in self.points), default=0.0)

    def all_faults(self) -> list[str]:
        told = [] if self.difference is None else [self.difference]
        levels = [fault for level in self.levels for fault in level.all_faults()]
        return [f"{self.label}: {fault}" for fault in (*told, *self.faults, *levels)]

    def to_json(self) -> dict[str, object]:
        return {
            "calls_played": self.played,
            "calls_of": self.of,
            "bit_equal": self.difference is None,
            "first_difference": self.difference,
            "arithmetic": "software" if self.software else "hardware",
            "stated_factor": self.limit,
            "largest_factor": round(self.factor, 3),
            "levels": {level.level: level.to_json() for level in self.levels},
            "kernels": self._kernels(),
            "straight_line": [p.name for p in self._own() if p.straight],
            "entry_points": {p.name: p.to_json() for p in self._own()},
        }

    def _own(self) -> list[EntryPoint]:
        """The package's entry points, without the kernels."""
        return [p for p in self.points if not p.name.startswith(self.kernels)]

    def _kernels(self) -> dict[str, object]:
        """The kernels together; operations of one call of each, added up."""
        points = [p for p in self.points if p.name.startswith(self.kernels)]
        return {
            "entry_points": len(points),
            "executed": {c: sum(p.executed.get(c, 0) for p in points) for c in EXACT},
            "static": {c: sum(p.static.get(c, 0) for p in points) for c in EXACT},
        }


def run(bench: Bench, progress: Progress) -> Finding:
    """Play every subject on every board.

    Raises:
        ToolMissing: no cross compiler or no QEMU.
        CheckFailed: something does not compile or stops with an error.
    """
    tools = tool_versions()
    with tempfile.TemporaryDirectory(prefix="servogen-pil-") as name:
        folder = Path(name)
        plugin = build_plugin(folder)
        stands = []
        with progress.task("Building for the host", total=len(bench.subjects)) as task:
            for subject in bench.subjects:
                stands.append(_stands(subject, folder / subject.precision.name))
                task.advance()
        outcomes = _examine_all(bench.subjects, stands, plugin, progress)
    return finding_of(bench, outcomes, tools)


def examine(
    stand: Stand, short: Stand | None, precision: Precision, core: Core, plugin: Path
) -> Outcome:
    """One package on one board.

    Args:
        short: the same with fewer calls, for the other levels of optimisation; None for none.

    Raises:
        ToolMissing: no cross compiler or no QEMU.
        CheckFailed: it does not compile, or stops with an error.
    """
    program = build_target(core, stand.folder, stand.package.sources)
    software = precision is FLOAT64 and not core.float64_in_hardware
    if software != bool(program.map.software):
        raise CheckFailed(
            f"{precision.name} on {core.title}: arithmetic is in "
            f"{'hardware' if software else 'software'}, where the processor has "
            f"{'none' if software else 'instructions'} for it"
        )
    if software:
        stand = within(stand, core.name, SOFTWARE_BUDGET)
    board = play_board(core, program, stand.stream, stand.folder / f"{core.name}-run", plugin)
    limit = SOFTWARE_FACTOR if software else HARDWARE_FACTOR
    points, faults = compare_all(
        stand.names, stand.which, stand.counted, board.rows, stand.static, limit, stand.kernels
    )
    return Outcome(
        precision.name, core, len(stand.which), stand.all_calls,
        first_difference(stand.declarations, stand.plays, stand.told, board.told),
        software, limit, stand.kernels, tuple(points),
        () if short is None else play_levels(short, core, plugin),
        tuple(faults),
    )  # fmt: skip


def _stands(subject: Subject, folder: Path) -> tuple[Stand, Stand]:
    """With all calls, and with the first."""
    plays = [*subject.suite(RANDOM_STEPS), *subject.closed_loops(None)]
    stand = make_stand(subject, plays, folder)
    return stand, within(stand, "short", LEVEL_BUDGET)


def _examine_all(
    subjects: Sequence[Subject],
    stands: Sequence[tuple[Stand, Stand]],
    plugin: Path,
    progress: Progress,
) -> list[Outcome]:
    """Two boards at a time; the order of what comes back is that of the subjects and boards."""
    jobs = [
        (stand, short, subject.precision, core)
        for subject, (stand, short) in zip(subjects, stands, strict=True)
        for core in CORES
    ]
    outcomes = []
    with progress.task("Running on emulated boards", total=len(jobs)) as task:
        for outcome in in_order(lambda job: examine(*job, plugin), jobs, workers=2):
            outcomes.append(outcome)
            task.advance()
    return outcomes


def finding_of(bench: Bench, outcomes: Sequence[Outcome], tools: dict[str, str]) -> Finding:
    """What the boards did, as one finding."""
    faults = [fault for outcome in outcomes for fault in outcome.all_faults()]
    if not outcomes:
        faults.append("nothing was played")
    figures: dict[str, dict[str, object]] = {}
    for o in outcomes:
        figures.setdefault(o.precision, {})[o.core.name] = o.to_json()
    equal = sum(o.difference is None for o in outcomes)
    return Finding(
        check="pil",
        passed=not faults,
        summary=(
            f"{_played(outcomes)} calls on {len(CORES)} emulated processors, "
            f"all bits the host's in {equal} of {len(outcomes)} runs; instructions per operation "
            f"at most {_largest(outcomes, software=False)} in hardware, "
            f"{_largest(outcomes, software=True)} in software"
        ),
        tools=tools,
        subjects=bench.digests,
        figures=figures,
        faults=tuple(faults),
        details=tuple(line for o in outcomes for line in _details(o)),
    )


def _played(outcomes: Sequence[Outcome]) -> str:
    """How many calls; of how many, where some were left out."""
    played, whole = sum(o.played for o in outcomes), sum(o.of for o in outcomes)
    return f"{played}" if played == whole else f"{played} of {whole}"


def _largest(outcomes: Sequence[Outcome], software: bool) -> str:
    factors = [o.factor for o in outcomes if o.software == software]
    return f"{max(factors):.2f}" if factors else "none"


def _details(o: Outcome) -> list[str]:
    part = "" if o.played == o.of else f" of {o.of} (software arithmetic: the rest is left out)"
    straight = sum(p.straight for p in o.points)
    first = (
        f"{o.label}: {o.played}{part} calls, straight-line entry points {straight} of "
        f"{len(o.points)}, instructions per operation at most {o.factor:.2f} (stated {o.limit:g})"
    )
    again = [
        f"  {level.level}: {level.calls} calls"
        + ("" if level.difference else ", bits equal")
        + (
            ", executed equal to counted in each"
            if level.level == PLAIN and not level.faults
            else ""
        )
        for level in o.levels
    ]
    most = max(o.points, key=lambda p: p.instructions, default=None)
    if most is None:
        return [first, *again]
    return [
        first,
        f"  most instructions: {most.name} {most.instructions}, static count of operations "
        f"{most.operations}; executed, counted, static "
        + ", ".join(
            f"{c} {most.executed[c]} {most.counted[c]} {most.static[c]}" for c in most.executed
        ),
        *again,
    ]
