"""All sequences of the benchmark, in the order of the table."""

from __future__ import annotations

from collections.abc import Iterator

from qp import literature, machine, published
from qp.sequence import Sequence, with_optima

HORIZONS = (5, 10, 20, 30, 50)
TIGHT = (0.02, 0.1)
# Programs of a sequence that no promise is about.
STEPS = 300


def suite(quick: bool = False) -> Iterator[Sequence]:
    """``quick``: short ones of each kind, for trying the benchmark out."""
    steps = 40 if quick else STEPS
    yield with_optima(published.unpack())
    for velocity in TIGHT:
        yield with_optima(machine.tight_loop(velocity, 200 if quick else 1500))
    for horizon in HORIZONS:
        yield with_optima(machine.closed_loops("servogen.toml", horizon, steps)[0])
    # its axis x is the other example's
    yield with_optima(machine.closed_loops("unequal_axes.toml", 20, steps)[1])
    for loop in literature.all_loops(max(steps, 100)):
        yield with_optima(loop)
