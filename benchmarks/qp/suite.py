"""All sequences of the benchmark, in the order of the table."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from qp import literature, machine, packages, published, servo
from qp.chosen import chosen
from qp.counted import PeerFailed
from qp.sequence import Sequence, with_optima

HORIZONS = (5, 10, 20, 30, 50)
MOVES = (1, 2, 3, 5, 10)
TIGHT = (0.02, 0.1)
# Those of 20 variables whose working sets reach 19 of them.
FULL = (*(f"tight_{velocity:g}" for velocity in TIGHT), "afti16_10")
# Programs of a sequence that no promise is about.
STEPS = 300


@dataclass(frozen=True)
class Missing:
    """A sequence that there is not, and why."""

    name: str
    why: str


Makes = Callable[[], list[Sequence]]


def suite(
    folder: Path, quick: bool = False, only: tuple[str, ...] = ()
) -> Iterator[Sequence | Missing]:
    """
    Args:
        folder: for sources of packages.
        quick: short ones of each kind, for trying the benchmark out.
        only: see ``chosen``.

    Raises:
        UnknownName: there is nothing of a name in ``only``; before anything is made.
    """
    made = tuple(_makers(folder, quick))
    return _sequences(made, chosen([name for names, _ in made for name in names], only))


def _sequences(
    made: tuple[tuple[tuple[str, ...], Makes], ...], wanted: frozenset[str]
) -> Iterator[Sequence | Missing]:
    for names, make in made:
        if wanted.isdisjoint(names):
            continue
        try:
            found = make()
        except PeerFailed as why:
            yield from (Missing(name, str(why)) for name in names if name in wanted)
            continue
        for sequence in found:
            if sequence.name in wanted:
                yield with_optima(sequence)


def _makers(folder: Path, quick: bool) -> Iterator[tuple[tuple[str, ...], Makes]]:
    """Names, and what makes the sequences of those names: only those asked for are made."""
    steps = 40 if quick else STEPS
    few = max(steps // 3, 20)
    yield ("qp_mpc20b",), lambda: [published.unpack()]
    tight = 200 if quick else 1500
    for velocity in TIGHT:
        yield (f"tight_{velocity:g}",), lambda v=velocity: [machine.tight_loop(v, tight)]
    for horizon in HORIZONS:
        names = [f"two_stage_x_{horizon}", f"two_stage_y_{horizon}"]
        count = 2 if horizon == 20 else 1
        yield (
            tuple(names[:count]),
            lambda h=horizon, c=count: list(machine.closed_loops("servogen.toml", h, steps)[:c]),
        )
    yield (
        ("unequal_axes_x_20", "unequal_axes_y_20"),
        lambda: list(machine.closed_loops("unequal_axes.toml", 20, steps)),
    )
    yield ("sprg_alone",), lambda: list(machine.closed_loops("sprg_alone.toml", 20, steps))
    for moves in MOVES:
        yield (f"servo_drive_{moves}",), lambda m=moves: [servo.closed_loop(m)]
    for boxes in (False, True):
        names = literature.names(boxes)
        yield names, lambda b=boxes: literature.all_loops(few if b else max(steps, 100), b)
    yield ("boxes_quadrotor_9",), lambda: [packages.quadrotor(few, folder)]
    yield ("qpmpc_pendulum_12",), lambda: [packages.pendulum(steps)]
    yield ("qpmpc_triple_16",), lambda: [packages.triple_integrator(steps)]
