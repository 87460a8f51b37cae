"""Random calls of the extended command governor: the stage near its plan, paths that it can follow
and paths that it cannot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.command_governor import AxisGovernor
from servogen.controllers.command_governor_design import AxisGovernorDesign
from servogen.controllers.design import Port, Value
from servogen.controllers.mpc_design import POSITION_FACTOR
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# Shares of the calls whose measurement is no use, and of those that are a push of the stage.
_BAD, _PUSHED = 0.03, 0.15
# Calls between two resets.
_RUN = 25


def axis_governor_calls(
    design: AxisGovernorDesign, rng: np.random.Generator, count: int
) -> Iterator[Call]:
    """``count`` steps of one axis, each foreseen first, around a reference of its own."""
    own = AxisGovernor(design)
    names = [port.name for port in own.declaration.operation("foresee").inputs]
    for index in range(count):
        if index % _RUN == 0:
            where = _somewhere(design, rng)
            yield _made(own, Call("reset", {"position": where}))
        state = _measured(design, own.predicted, rng)
        inputs: dict[str, Value] = dict(zip(names, state.tolist(), strict=True))
        _spoil(own.declaration.operation("foresee").inputs, inputs, rng)
        yield _made(own, Call("foresee", inputs))
        own_reach = own.foresee(state.astype(design.precision.dtype))
        least, greatest = (
            np.asarray(bound, dtype=np.float64) for bound in (own_reach.least, own_reach.greatest)
        )
        middle, half = 0.5 * (least + greatest), 0.5 * (greatest - least)
        # points of an interval about what is in reach, up to its ends and a little beyond
        centre = middle + rng.choice([0.0, 0.5, 0.9, 1.0, 1.0 + 1e-6, 1.2]) * half * rng.choice(
            [-1.0, 1.0]
        )
        spread = rng.choice([0.0, 0.05, 0.3]) * np.abs(half)
        stroke, far = design.program.stroke_m, _far(design)
        low = np.clip(centre + spread - stroke, -far - stroke, far + stroke)
        high = np.clip(centre - spread + stroke, -far - stroke, far + stroke)
        ahead = centre[:-1] + stroke * rng.normal(size=centre.size - 1) * rng.choice(
            [0.0, 0.1, 1.0]
        )
        step = {**inputs, "reference": np.clip(ahead, -far, far), "low": low, "high": high}
        _spoil(own.declaration.operation("step").inputs, step, rng)
        yield _made(own, Call("step", step))
        if rng.random() < 0.05:
            yield _made(own, Call("hold"))


def _made(own: AxisGovernor, call: Call) -> Call:
    own.call(call.operation, call.inputs)
    return call


def _far(design: AxisGovernorDesign) -> float:
    return design.reach.position_m * POSITION_FACTOR


def _somewhere(design: AxisGovernorDesign, rng: np.random.Generator) -> float:
    """Inside V', now and then at its end."""
    steady = float(np.min(design.program.limit[design.program.settle > 0.0]))
    share = rng.choice([rng.uniform(-1.0, 1.0), -1.0, 1.0])
    return float(design.program.centre_m + share * steady * design.program.scale_m)


def _measured(
    design: AxisGovernorDesign, predicted: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """(n,) where the stage was expected, or pushed away from there."""
    state = np.asarray(predicted, dtype=np.float64).copy()
    if rng.random() < _PUSHED:
        reach = design.reach
        scale = np.full(state.size, reach.acceleration_m_per_s2)
        scale[:2] = reach.fast_range_m, reach.velocity_m_per_s
        state += rng.choice([1e-6, 1e-2, 0.3]) * scale * rng.normal(size=state.size)
    return state


def _spoil(ports: tuple[Port, ...], inputs: dict[str, Value], rng: np.random.Generator) -> None:
    """One of the values becomes none, infinite or too large."""
    if rng.random() >= _BAD:
        return
    port = ports[int(rng.integers(len(ports)))]
    high = float(port.high or 0.0)
    value = float(rng.choice([np.nan, np.inf, -np.inf, 1.001 * high, -1.001 * high]))
    if port.integer:
        inputs[port.name] = int(rng.choice([-1, int(high) + 1]))
    elif port.size:
        array = np.array(inputs[port.name])
        array[int(rng.integers(port.size))] = value
        inputs[port.name] = array
    else:
        inputs[port.name] = value
