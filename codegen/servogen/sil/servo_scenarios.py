"""What is tried on every controller of a servo axis, besides its closed loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from servogen.controllers.design import Declaration, Reference, Value
from servogen.controllers.lookup import Lookup
from servogen.controllers.pid import Pid
from servogen.controllers.pid_design import PidDesign
from servogen.controllers.servo_mpc_design import ServoMpcDesign
from servogen.controllers.servo_parts import ServoParts
from servogen.controllers.wrapping import Wrapping
from servogen.sil.edges import edge_calls, resting_inputs
from servogen.sil.harness import Call
from servogen.sil.lookup_calls import lookup_calls
from servogen.sil.scenarios import Scenario
from servogen.sil.servo_calls import mpc_calls, pid_calls


def servo_suite(parts: ServoParts, seed: int, count: int) -> Iterator[Scenario]:
    """Edges, angles at half a turn where the axis comes round, and ``count`` random calls for every
    controller. The same seed gives the same scenarios."""
    rng = np.random.default_rng(seed)

    def lookup() -> Reference:
        return Lookup(parts.lookup)

    declaration = lookup().declaration
    yield Scenario(f"{declaration.prefix}: edges", lookup, list(edge_calls(declaration)))
    calls = list(lookup_calls(parts.lookup, rng, count))
    yield Scenario(f"{declaration.prefix}: random", lookup, calls)
    yield from _axis(parts.mpc, parts.controller, list(mpc_calls(parts, rng, count)))
    if parts.pid is not None:
        pid = parts.pid
        yield from _axis(pid, lambda: Pid(pid), list(pid_calls(pid, rng, count)))


def _axis(
    design: ServoMpcDesign | PidDesign, factory: Callable[[], Reference], calls: list[Call]
) -> Iterator[Scenario]:
    declaration = factory().declaration
    yield Scenario(f"{design.prefix}: edges", factory, list(edge_calls(declaration)))
    if design.turn:
        turning = list(half_turns(design, declaration))
        yield Scenario(f"{design.prefix}: half turns", factory, turning)
    yield Scenario(f"{design.prefix}: random", factory, calls)


def half_turns(design: ServoMpcDesign | PidDesign, declaration: Declaration) -> Iterator[Call]:
    """Steps of the encoder by half a turn and its neighbours in the scalar type, with any number of
    whole turns besides; of some, the nearest number of turns is rounded the wrong way."""
    wrapping = Wrapping(design.turn, design.reach, design.precision)
    real = design.precision.dtype.type
    most = int(min(2.0 * design.reach // design.turn, 40.0))
    for whole in range(-most, most + 1):
        for side in (-1.0, 1.0):
            exact = real(whole * design.turn + side * 0.5 * design.turn)
            around = [np.nextafter(exact, real(-np.inf)), exact, np.nextafter(exact, real(np.inf))]
            for difference in around:
                to = real(min(max(float(difference) / 2.0, -design.reach), design.reach))
                yield from _step(declaration, float(-to), float(to))
                assert abs(wrapping.shortest(difference)) <= real(0.5 * design.turn)


def _step(declaration: Declaration, start: float, end: float) -> Iterator[Call]:
    size = declaration.operation("step").inputs[0].size

    def shown(value: float) -> Value:
        return np.full(size, value) if size else value

    yield Call("reset", {"position": shown(start)})
    inputs = resting_inputs(declaration, "step")
    reference = declaration.operation("step").inputs[1].size
    inputs["position"] = shown(end)
    inputs["reference"] = np.full(reference, end) if reference else end
    yield Call("step", inputs)
