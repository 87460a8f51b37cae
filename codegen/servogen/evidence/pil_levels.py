"""The same calls with other optimisation: the bits must not depend on it.

Without any, the compiler translates operation by operation: then the processor executes in every
call exactly the operations on scalars that the C counts, class by class, decisions or not. That
shows the counting itself right, where ``pil_counts`` shows it an upper bound for what ships.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servogen.evidence.pil_build import Core, build_target
from servogen.evidence.pil_map import ARITHMETIC, COLUMNS
from servogen.evidence.pil_run import Rows, play_board
from servogen.evidence.pil_stand import Stand
from servogen.evidence.same_bits import first_difference
from servogen.wcet.operations import CLASSES

PLAIN = "-O0"
LEVELS = (PLAIN, "-Os", "-O3")


@dataclass(frozen=True)
class Level:
    """One level of optimisation on one board; ``difference`` as in ``pil.Outcome``.

    ``faults``: of the counts, at ``PLAIN`` only.
    """

    level: str
    calls: int
    difference: str | None
    faults: tuple[str, ...] = ()

    def all_faults(self) -> list[str]:
        told = [] if self.difference is None else [self.difference]
        return [f"{self.level}: {fault}" for fault in (*told, *self.faults)]

    def to_json(self) -> dict[str, object]:
        told: dict[str, object] = {"calls": self.calls, "bit_equal": self.difference is None}
        return told | ({"counts_equal": not self.faults} if self.level == PLAIN else {})


def play_levels(stand: Stand, core: Core, plugin: Path) -> tuple[Level, ...]:
    """Every level but the one that ``pil`` plays in full.

    Raises:
        ToolMissing: no cross compiler or no QEMU.
        CheckFailed: it does not compile, or stops with an error.
    """
    return tuple(_play(stand, core, plugin, level) for level in LEVELS)


def _play(stand: Stand, core: Core, plugin: Path, level: str) -> Level:
    program = build_target(core, stand.folder, stand.package.sources, level)
    plain = level == PLAIN
    board = play_board(
        core, program, stand.stream, stand.folder / f"{core.name}{level}-run",
        plugin if plain else None,
    )  # fmt: skip
    difference = first_difference(stand.declarations, stand.plays, stand.told, board.told)
    faults: list[str] = []
    if plain:
        faults = unequal_counts(stand, board.rows, bool(program.map.software))
    return Level(level, len(stand.which), difference, tuple(faults))


def unequal_counts(stand: Stand, executed: Rows, software: bool) -> list[str]:
    """One sentence per entry point and class that was executed as often as the C does not say.

    Args:
        software: sign changes are integer instructions and cannot be told from others.
    """
    if len(executed) != len(stand.which):
        return [f"{len(stand.which)} calls were made and {len(executed)} counted on the board"]
    faults = []
    for what in ARITHMETIC:
        if software and what == "neg":
            continue
        theirs = executed[:, COLUMNS.index(what)].astype(np.int64)
        ours = stand.counted[:, CLASSES.index(what)].astype(np.int64)
        for number, name in enumerate(stand.names):
            wrong = np.flatnonzero((stand.which == number) & (theirs != ours))
            if wrong.size:
                at = wrong[0]
                faults.append(f"{name}: {theirs[at]} {what} executed, the C has {ours[at]}")
    return faults
