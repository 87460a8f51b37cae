"""One package on the test stand: its calls, what the host answers, what the C counts in each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from servogen.controllers.design import Declaration
from servogen.emit.package import CPackage
from servogen.errors import CheckFailed
from servogen.evidence.bench import Subject
from servogen.evidence.pil_build import build_counted, build_host, write_package
from servogen.evidence.pil_kernels import with_kernels
from servogen.evidence.pil_run import Rows, play_counted, play_host
from servogen.sil.player import Play, encode, entry_points
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.package import count_package

SCALAR_CLASSES = 8  # the first of CLASSES: arithmetic on scalars


@dataclass(frozen=True)
class Stand:
    """Everything a board is compared with.

    Attributes:
        folder: sources, the stream of calls and what is built.
        plays: what is played, in this order; ``all_calls``: how many there were to choose from.
        static: entry point -> worst case.
        kernels: how the names of the kernels' entry points begin.
        which: (calls,) index into ``names`` of each call.
        told: the host's answers.
        counted: (calls, classes) operations of each call.
    """

    package: CPackage
    folder: Path
    stream: Path
    plays: tuple[Play, ...]
    all_calls: int
    static: Mapping[str, OperationCounts]
    kernels: str
    which: NDArray[np.integer]
    told: bytes
    counted: Rows

    @property
    def declarations(self) -> tuple[Declaration, ...]:
        return self.package.declarations

    @property
    def names(self) -> list[str]:
        return [f"{d.prefix}_{op.name}" for d, op in entry_points(self.declarations)]

    @property
    def scalar_operations(self) -> int:
        """Arithmetic on scalars in all calls together."""
        return int(self.counted[:, :SCALAR_CLASSES].sum())

    def of(self, play_name: str) -> int:
        """Calls of the play of this name."""
        return sum(calls_in(p) for p in self.plays if p.name == play_name)


def calls_in(play: Play) -> int:
    return sum(times for _, times in play.counted())


def make_stand(subject: Subject, plays: Sequence[Play], folder: Path) -> Stand:
    """Build for the host, plain and counting, and play everything there.

    The runtime's kernels on the package's tables join the package, and their calls the plays.

    Raises:
        CheckFailed: something does not compile, or the two builds on the host disagree.
        ToolMissing: no gcc.
    """
    package, kernels, to_count = with_kernels(subject.package)
    sources = write_package(package, folder)
    names = [f"{d.prefix}_{op.name}" for d, op in entry_points(package.declarations)]
    start = f"{kernels.prefix}_"
    own = [n for n in names if n.startswith(start)]
    counts = count_package([folder / to_count], [folder], own).entry_points
    static = {n: (counts[n] if n in counts else subject.counts.entry_points[n]).total()
              for n in names}  # fmt: skip
    build_host(folder, sources)
    build_counted(folder, sources)
    stand = Stand(
        package, folder, folder, (), 0, static, start, np.zeros(0, int), b"",
        np.zeros((0, len(CLASSES)), np.uint64),
    )  # fmt: skip
    return replay(stand, "all", (*plays, kernels))


def replay(stand: Stand, name: str, plays: Sequence[Play]) -> Stand:
    """The same builds with other calls; ``name``: of the folders it makes.

    Raises:
        CheckFailed: the two builds on the host disagree.
    """
    stream = stand.folder / f"{name}.stream"
    stream.write_bytes(encode(stand.declarations, plays))
    told = play_host(stand.folder / "host_player", stream, stand.folder / f"{name}-host")
    counting = play_counted(
        stand.folder / "counted_player", stream, stand.folder / f"{name}-counted"
    )
    if counting.told != told:
        raise CheckFailed("the counting twin of the C computes other bits than the C")
    number = {n: i for i, n in enumerate(stand.names)}
    which = [
        np.full(times, number[f"{play.prefix}_{call.operation}"])
        for play in plays
        for call, times in play.counted()
    ]
    if not which:
        raise CheckFailed("there is no call to play")
    return replace(
        stand, stream=stream, plays=tuple(plays), told=told, counted=counting.rows,
        which=np.concatenate(which), all_calls=sum(map(calls_in, plays)),
    )  # fmt: skip


def within(stand: Stand, name: str, budget: int) -> Stand:
    """The stand with as many calls as fit into ``budget`` operations on scalars.

    Short plays are kept whole; what is left is shared evenly by the long ones, of which the
    first calls are kept. ``all_calls`` still says how many there were.
    """
    if stand.scalar_operations <= budget:
        return stand
    kept = cut_plays(stand.plays, _costs(stand), budget)
    cut = replay(stand, name, [p for p in kept if p.calls])
    return replace(cut, all_calls=stand.all_calls)


def _costs(stand: Stand) -> list[NDArray[np.int64]]:
    """Per play, operations on scalars of each of its calls, repeated ones singly."""
    each = stand.counted[:, :SCALAR_CLASSES].sum(axis=1).astype(np.int64)
    ends = np.cumsum([calls_in(p) for p in stand.plays])
    return np.split(each, ends[:-1])


def cut_plays(plays: Sequence[Play], costs: Sequence[NDArray[np.int64]], budget: int) -> list[Play]:
    """First calls of each play, for ``budget`` in all; ``costs`` are those of ``_costs``."""
    order = sorted(range(len(plays)), key=lambda i: int(costs[i].sum()))
    cut, left = list(plays), budget
    for done, i in enumerate(order):
        share = left // (len(order) - done)
        room = int(np.searchsorted(np.cumsum(costs[i]), share, side="right"))
        cut[i] = _first(plays[i], room)
        left -= int(costs[i][: calls_in(cut[i])].sum())
    return cut


def _first(play: Play, room: int) -> Play:
    """The calls that are over within the first ``room``, repeated ones counted singly."""
    kept, repeats = [], []
    for call, times in play.counted():
        if times > room:
            break
        room -= times
        kept.append(call)
        repeats.append(times)
    return Play(play.name, play.prefix, tuple(kept), tuple(repeats))
