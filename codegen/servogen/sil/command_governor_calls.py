"""Random calls of the extended command governor: the stage near its plan, paths that it can follow
and paths that it cannot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_declaration import AXES
from servogen.controllers.command_governor_design import AxisGovernorDesign, CommandGovernorDesign
from servogen.controllers.design import Port, Status, Value
from servogen.controllers.mpc_design import POSITION_FACTOR
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# Shares of the calls whose measurement is no use, and of those that are a push of the stage.
_BAD, _PUSHED = 0.06, 0.15
# Of the paths of both axes, those with a jump that no stage can follow, at which it comes to rest.
_APART = 0.25
# Of an axis' calls, those whose points leave it next to no room.
_SLIT = 0.1
# Half of the room of stages that are to stay at the cap, in strokes, and the steps of all but the
# first, which takes its patience.
_WAITING, _WAITING_STEPS = (0.002, 0.3, 0.001), (30, 30)
# Calls between two resets, of an axis and of both, and of the windows that are whole and those that
# are cut short.
_RUN, _PATH = 25, 50
_SEEN = (0.8, 0.2)


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
        if rng.random() < 0.3:
            centre = np.full_like(centre, centre[-1])  # to stay at: what binds is the end of it
        spread = rng.choice([0.0, 0.05, 0.3]) * np.abs(half)
        stroke, far = design.program.stroke_m, _far(design)
        if rng.random() < _SLIT:  # about as wide as the stroke: a position serves them all, or none
            reserve = design.tol.margin * design.program.scale_m
            spread = stroke - reserve * rng.choice([0.0, 0.999, 1.0, 1.001, 1.1])
        low = np.clip(centre + spread - stroke, -far - stroke, far + stroke)
        high = np.clip(centre - spread + stroke, -far - stroke, far + stroke)
        ahead = centre[:-1] + stroke * rng.normal(size=centre.size - 1) * rng.choice(
            [0.0, 0.1, 1.0]
        )
        step = {**inputs, "reference": np.clip(ahead, -far, far), "low": low, "high": high}
        _spoil(own.declaration.operation("step").inputs, step, rng)
        yield _made(own, Call("step", step))
        if rng.random() < 0.05:  # a period without a measurement
            yield _made(own, Call("step", {**step, names[0]: np.nan}))
        if rng.random() < 0.1:
            yield _made(own, Call("predict", inputs))


def waiting_axis_calls(design: AxisGovernorDesign, rng: np.random.Generator) -> Iterator[Call]:
    """Steps of a stage at rest until its patience ends, and some more; then a reference that stays.

    It is in a slit, and the reference turns round from period to period and with the periods of a
    plan: no working set is of use to the next step, and all of them are at the cap.
    """
    own = AxisGovernor(design)
    names = [port.name for port in own.declaration.operation("foresee").inputs]
    far, stroke = _far(design), design.program.stroke_m
    for slit, count in zip(_WAITING, (design.patience + 10, *_WAITING_STEPS), strict=True):
        where = 0.5 * (_somewhere(design, rng) + design.program.centre_m)
        yield _made(own, Call("reset", {"position": where}))
        step: dict[str, Value] = {
            "low": np.full(design.intervals, where - slit * stroke),
            "high": np.full(design.intervals, where + slit * stroke),
        }
        for index in range(count + 5):
            if index < count:
                turns = (-1.0) ** (index + np.arange(design.program.variables))
                ahead = stroke * turns * rng.choice([1.0, 10.0], turns.size)
                step["reference"] = np.clip(where + ahead, -far, far)
            step |= dict(zip(names, own.predicted.tolist(), strict=True))
            yield _made(own, Call("step", dict(step)))


def command_governor_calls(
    design: CommandGovernorDesign, rng: np.random.Generator, count: int, bad: float = _BAD
) -> Iterator[Call]:
    """``count`` periods of both axes around a reference of their own: paths machined to their end,
    windows that are cut short, and what is beyond them no number. ``bad``: share of no use."""
    own = CommandGovernor(design)
    names = [port.name for port in own.declaration.operation("step").inputs]
    n = design.axes[0].plant.order
    path: FloatArray = np.zeros((0, 2))
    first, ended, apart = 0, 0, False
    for index in range(count):
        if index % _PATH == 0 or ended > 1:
            path, first, ended = _figures(design, rng), 0, 0
            apart = rng.random() < _APART
            if apart:
                path = _apart(design, rng)
            start: dict[str, Value] = {f"position_{a}": path[0, i] for i, a in enumerate(AXES)}
            yield _made(own, Call("reset", start))
        left = min(design.window, len(path) - 1 - first)
        seen = int(rng.choice([left, min(left, int(rng.integers(0, design.points + 2)))], p=_SEEN))
        seen = left if apart else seen
        inputs: dict[str, Value] = {"n_points": seen}
        for i, axis in enumerate(design.axes):
            predicted = own.axes[i].predicted
            state = (_nudged if apart else _measured)(axis, predicted, rng)
            inputs |= dict(zip(names[i * n : (i + 1) * n], state.tolist(), strict=True))
            part = path[first + 1 : first + 1 + seen, i]
            away = 0.0 if apart else rng.uniform(-0.5, 0.5)
            slow = part + axis.program.stroke_m * away
            for name, values in (("points", part), ("slow", slow)):
                window = np.full(design.window, rng.choice([np.nan, np.inf, 1e30, 0.0]))
                window[:seen] = np.clip(values, -_far(axis), _far(axis))
                inputs[f"{name}_{AXES[i]}"] = window
        _spoil(own.declaration.operation("step").inputs, inputs, rng, bad)
        status, out = own.call("step", inputs)
        first += int(np.asarray(out["points_taken"]))
        ended += status is Status.FINISHED and left == 0
        yield Call("step", inputs)
        if rng.random() < 0.1:
            yield Call("predict", {name: inputs[name] for name in names[: 2 * n]})


def _figures(design: CommandGovernorDesign, rng: np.random.Generator) -> FloatArray:
    """(J, 2) m from where a stage can stand: figures of about a stroke that drift away, at the
    speed that the stage has and at more; a jump now and then."""
    size = int(rng.choice([1, 3, int(rng.integers(4, 4 * design.window))], p=[0.04, 0.06, 0.9]))
    t = np.arange(size)
    columns = []
    for axis in design.axes:
        stroke, centre = axis.program.stroke_m, axis.program.centre_m
        speed = axis.reach.velocity_m_per_s * axis.plant.sample_time_s / design.points
        drift = speed * float(rng.choice([0.0, 0.1, 0.5, 1.0])) * rng.choice([-1.0, 1.0]) * t
        wide = stroke * float(rng.choice([0.2, 0.8, 1.0, 1.3]))
        figure = wide * np.sin(rng.choice([0.3, 2.0, 6.0]) * t / design.points + rng.uniform(0, 6))
        if rng.random() < 0.1:
            figure[int(rng.integers(size)) :] += stroke * rng.uniform(0.5, 2.5)
        half = axis.reach.position_m - abs(centre)
        here = rng.uniform(-0.7, 0.7) * half + figure + drift
        # folded back at the end of the axis, a little inside of it or beyond
        end = half * float(rng.choice([0.9, 1.05]))
        columns.append(centre + end - np.abs(np.mod(here + end, 4.0 * end) - 2.0 * end))
    path: FloatArray = np.stack(columns, axis=1)
    for i, axis in enumerate(design.axes):
        half = axis.reach.position_m - abs(axis.program.centre_m)
        path[0, i] = np.clip(path[0, i], axis.program.centre_m - half, axis.program.centre_m + half)
    return path


def _apart(design: CommandGovernorDesign, rng: np.random.Generator) -> FloatArray:
    """(J, 2) m: some points at one place, the others more than two strokes away in an axis or in
    both."""
    path = np.empty((4 * design.window, 2))
    far = [(True, False), (False, True), (True, True)][int(rng.integers(3))]
    begin = int(rng.integers(1, 3 * design.points + 2))
    for i, axis in enumerate(design.axes):
        half = axis.reach.position_m - abs(axis.program.centre_m)
        way = axis.program.stroke_m * rng.uniform(2.1, 3.0) * rng.choice([-1.0, 1.0])
        path[:, i] = axis.program.centre_m + rng.uniform(-0.3, 0.3) * half
        path[begin:, i] += way if far[i] else 0.3 * way
    return path


def _made(own: AxisGovernor | CommandGovernor, call: Call) -> Call:
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


def _nudged(
    design: AxisGovernorDesign, predicted: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """(n,) about as far from there as a stage at rest may be."""
    state = np.asarray(predicted, dtype=np.float64).copy()
    if rng.random() < _PUSHED:
        state[0] += rng.uniform(-4.0, 4.0) * design.standing_m
        state[1] += rng.uniform(-4.0, 4.0) * design.standing_m / design.plant.sample_time_s
    return state


def _spoil(
    ports: tuple[Port, ...], inputs: dict[str, Value], rng: np.random.Generator, bad: float = _BAD
) -> None:
    """One of the values becomes none, infinite or too large."""
    if rng.random() >= bad:
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
