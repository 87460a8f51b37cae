"""What ``servogen sil`` tries on every controller of a cascade, besides the closed loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from servogen.controllers.cascade import Cascade
from servogen.controllers.cascade_design import CascadeDesign
from servogen.controllers.design import Reference
from servogen.controllers.fast_stage import FastStage
from servogen.controllers.governor import Governor
from servogen.controllers.mpc_design import MpcDesign
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call
from servogen.sil.random_calls import Design, random_calls


class Scenario(NamedTuple):
    """``name``: controller prefix and what is tried; ``reference``: makes a fresh one, whose
    ``declaration`` names the C; ``calls``: for the harness, from a fresh instance on."""

    name: str
    reference: Callable[[], Reference]
    calls: list[Call]


def suite(design: CascadeDesign, seed: int, count: int) -> Iterator[Scenario]:
    """Edges and ``count`` random slow steps or states for every controller of a cascade.

    The same seed gives the same scenarios; about 20 ms of reference time per step at a cap of 500.
    """
    parts: list[tuple[str, Design, Callable[[], Reference]]] = [
        (design.governor.prefix, design.governor, lambda: Governor(design.governor)),
        *((m.prefix, m, _mpc_factory(m)) for m in {m.prefix: m for m in design.mpc or ()}.values()),
        (design.fast.prefix, design.fast, lambda: FastStage(design.fast)),
        (design.prefix, design, lambda: Cascade(design)),
    ]
    for number, (prefix, part, factory) in enumerate(parts):
        declaration = factory().declaration
        yield Scenario(f"{prefix}: edges", factory, list(edge_calls(declaration)))
        calls = list(random_calls(part, seed + number, count))
        yield Scenario(f"{prefix}: random", factory, calls)


def _mpc_factory(design: MpcDesign) -> Callable[[], Reference]:
    return lambda: TrackingMpc(design)
