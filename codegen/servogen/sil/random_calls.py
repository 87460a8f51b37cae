"""Random calls of every controller, drawn from its design and a seed.

Calls are plain data, so that both sides of the harness get the same ones. Where a call depends on
what the controller answered before (the cascade around its plant), a reference of its own answers
while the calls are drawn up. The same design and seed give the same calls.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.cascade import Cascade
from servogen.controllers.cascade_design import CascadeDesign
from servogen.controllers.design import Status, Value
from servogen.controllers.fast_design import FastDesign
from servogen.controllers.fast_stage import FastStage
from servogen.controllers.governor_design import AXES, GovernorDesign
from servogen.controllers.mpc_design import POSITION_FACTOR, MpcDesign
from servogen.precision import FloatArray
from servogen.qp.active_set_tables import ActiveSetTables
from servogen.sets.constraints import AxisLimits
from servogen.sil.edges import random_inputs
from servogen.sil.harness import Call

Design = GovernorDesign | MpcDesign | FastDesign | CascadeDesign


def random_calls(design: Design, seed: int, count: int) -> Iterator[Call]:
    """``count`` slow steps or states of one controller, with what belongs to each."""
    rng = np.random.default_rng(seed)
    match design:
        case GovernorDesign():
            return _governor_calls(design, rng, count)
        case MpcDesign():
            return _mpc_calls(design, rng, count)
        case FastDesign():
            return _fast_calls(design, rng, count)
        case CascadeDesign():
            return _cascade_calls(design, rng, count)


def smooth_path(
    rng: np.random.Generator, limits: tuple[AxisLimits, AxisLimits], step_m: float, count: int
) -> FloatArray:
    """(count, 2) m: a curve of wandering heading and speed, at most ``step_m`` per point; now and
    then with a corner."""
    reach = np.array([0.9 * lim.position_m for lim in limits])
    bend = float(rng.choice([5e-4, 5e-3, 5e-2]))
    heading = np.cumsum(rng.normal(0.0, bend, count)) + rng.uniform(-np.pi, np.pi)
    if rng.random() < 0.3:  # a sharp corner
        heading[int(rng.integers(count)) :] += rng.uniform(1.0, np.pi)
    speed = step_m * np.clip(np.abs(np.cumsum(rng.normal(0.0, 0.02, count)) + 0.8), 0.0, 1.0)
    moves = speed[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    path = rng.uniform(-reach, reach) + np.cumsum(moves, axis=0)
    # folded back at the edge of the workspace: continuous, and inside
    folded: FloatArray = np.asarray(reach - np.abs(np.mod(path + reach, 4.0 * reach) - 2.0 * reach))
    return folded


def random_state(
    rng: np.random.Generator, order: int, limits: AxisLimits, around: float
) -> FloatArray:
    """(order,) a state near rest, in motion, with some components on their limits, or anywhere."""
    scale = np.array(
        [limits.fast_range_m, limits.velocity_m_per_s, limits.acceleration_m_per_s2]
        + [limits.acceleration_m_per_s2 * 10.0 ** (i - 2) for i in range(3, order)]
    )
    size = float(rng.choice([0.0, 1e-6, 0.05, 0.5, 1.0, 1.3]))
    state: FloatArray = size * scale * rng.uniform(-1.0, 1.0, order)
    state[0] += around
    if rng.random() < 0.2:
        at = rng.integers(1, 3)
        state[at] = rng.choice([-1.0, 1.0]) * scale[at]
    if rng.random() < 0.1:
        state[0] = rng.choice([-1.0, 1.0]) * limits.position_m
    return state


def _state_inputs(prefix: str, names: list[str], state: FloatArray) -> dict[str, Value]:
    return {f"{prefix}{name}": float(v) for name, v in zip(names, state, strict=True)}


def _points_count(rng: np.random.Generator, points: int) -> int:
    return int(rng.choice(np.array([0, 1, points, int(rng.integers(points + 1))])))


def _names(order: int) -> list[str]:
    return ["position", "velocity", "acceleration", *(f"state_{i}" for i in range(3, order))]


def _on_facet(design: GovernorDesign, axis: int, last: float, state: FloatArray) -> FloatArray:
    """The state moved along (v, a, ...) onto the first row of O-infinity that it meets."""
    section = design.sections[axis]
    rest = section.rows @ state[1:]
    offset = section.shift * state[0] + last - state[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = (np.sign(rest) * section.bound - offset) / rest
    usable = lengths[np.isfinite(lengths) & (lengths > 0.0)]
    moved = state.copy()
    moved[1:] *= float(usable.min()) if usable.size else 0.0
    return moved


def _at_reach(
    design: GovernorDesign, axis: int, rng: np.random.Generator, path: FloatArray, state: FloatArray
) -> float:
    """Position from which some point is the fast range away, a thousandth more or less, at the
    start of the interval or at its end; there the first point may be left too far behind."""
    section = design.sections[axis]
    farthest = int(np.argmax(np.abs(path - path[0])))
    point = float(path[int(rng.choice([farthest, int(rng.integers(1, path.size))]))])
    away = design.limits[axis].fast_range_m * float(np.sign(point - path[0]))
    away *= float(rng.choice([1.0 - 1e-3, 1.0 + 1e-3]))
    if rng.random() < 0.5:
        return point - away
    slope, reference = section.ahead_reference, point
    moved = float(section.ahead @ state[1:])
    if rng.random() < 0.7:
        point, away = float(path[0]), -away
    return (point - away - moved - slope * reference) / (1.0 - slope)


def _governor_calls(design: GovernorDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    names = _names(design.order)
    for _ in range(count):
        step = rng.choice([0.01, 0.3, 1.0]) * design.limits[0].velocity_m_per_s
        step *= design.sample_time_s / design.points
        path = smooth_path(rng, design.limits, step, design.points + 1)
        if rng.random() < 0.5:  # there and back: only then the range says more than (13) does
            turn = int(rng.integers(design.points))
            path[turn:] = path[turn] - 0.5 * (path[turn:] - path[turn])
        inputs: dict[str, Value] = {}
        tried, kind = int(rng.choice([0, 1, 2], p=[0.45, 0.45, 0.1])), rng.random()
        for i, axis in enumerate(AXES):
            last = float(path[0, i])
            state = random_state(rng, design.order, design.limits[i], last)
            if tried not in (i, 2):  # one axis is tried, the other must not decide
                state = 0.05 * random_state(rng, design.order, design.limits[i], 0.0)
                state[0] += last
            elif kind < 0.3:
                state = _on_facet(design, i, last, state)
            elif kind < 0.8:
                # at speed, or the admissible set is narrower than the range of the fast stage
                speed = float(rng.uniform(0.2, 1.0)) * design.limits[i].velocity_m_per_s
                state[1] = speed * float(np.sign(path[-1, i] - last))
                state[2:] *= float(rng.choice([0.0, 0.1]))
                state[0] = _at_reach(design, i, rng, path[:, i], state)
            inputs |= _state_inputs(f"{axis}_", names, state)
            inputs |= {f"last_{axis}": last, f"points_{axis}": path[1:, i].copy()}
        inputs["n_points"] = _points_count(rng, design.points)
        yield Call("step", inputs)


def _mpc_calls(design: MpcDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    limits, horizon = design.limits, design.horizon
    names = _names(design.plant.order)
    here = 0.0
    before: Call | None = None
    apart = rng.spawn(1)[0]
    for index in range(count):
        if index % 10 == 0:
            here = float(rng.uniform(-1.0, 1.0) * limits.position_m)
            yield Call("reset", {"position": here})
            yield Call("step", _contradiction(design, apart, here))
            if isinstance(design.solver, ActiveSetTables):
                # the cap may end the first; the next one goes on from its set
                prescribed = _prescribed(design, here, 10.0 ** (index / 40 % 2 - 3))
                yield from [Call("step", prescribed)] * 3
        path = here + _tour(rng, horizon, limits.velocity_m_per_s * design.plant.sample_time_s)
        path = np.clip(path, -limits.position_m, limits.position_m)
        if rng.random() < 0.2:
            yield Call("seed", {"command": float(path[-1])})
        state = random_state(rng, design.plant.order, limits, here)
        if rng.random() < 0.7:  # as if in the middle of its work: behind the path, at its speed
            state[0] = path[0] + rng.uniform(-0.9, 0.9) * limits.fast_range_m
            state[1] = rng.uniform(0.5, 1.5) * (path[1] - path[0]) / design.plant.sample_time_s
            state[2:] *= rng.choice([0.0, 0.3])
        inputs = _state_inputs("", names, state)
        yield Call("candidate", inputs)
        low, high = mpc_window(path, limits)
        if rng.random() < 0.6:
            _cut(design, rng, state, path, low, high)
        step = Call("step", {**inputs, "reference": path, "low": low, "high": high})
        yield step
        if isinstance(design.solver, ActiveSetTables):
            # begun with the right set, and with another program's
            yield step
            yield before or step
            before = step
        if rng.random() < 0.1:
            yield Call("hold", {"reference": float(path[-1])})


def _contradiction(design: MpcDesign, rng: np.random.Generator, here: float) -> dict[str, Value]:
    """At rest, a bound above the other by little: the duals of both grow, together in the end, and
    what their difference moves is lost in rounding where the precision is low."""
    limits, horizon = design.limits, design.horizon
    low = np.full(horizon, -limits.position_m)
    high = np.full(horizon, limits.position_m)
    k = int(rng.integers(horizon))
    low[k] = here + rng.uniform(-1.0, 1.0) * limits.fast_range_m
    high[k] = low[k] - 10.0 ** rng.uniform(-8.0, -2.0) * limits.fast_range_m
    state = np.zeros(design.plant.order)
    state[0] = here
    inputs = _state_inputs("", _names(design.plant.order), state)
    return {**inputs, "reference": np.full(horizon + 1, here), "low": low, "high": high}


def _prescribed(design: MpcDesign, here: float, share: float) -> dict[str, Value]:
    """Every position prescribed, now to this side and now to the other: as many rows as variables,
    and then, with a larger share of the range, one more."""
    limits, horizon = design.limits, design.horizon
    sides = np.where(np.arange(horizon) % 2 == 0, 1.0, -1.0) * share * limits.fast_range_m
    where = np.clip(here + sides, -limits.position_m, limits.position_m)
    state = np.zeros(design.plant.order)
    state[0] = here
    inputs = _state_inputs("", _names(design.plant.order), state)
    return {**inputs, "reference": np.full(horizon + 1, here), "low": where, "high": where}


def _tour(rng: np.random.Generator, horizon: int, step_m: float) -> FloatArray:
    """(N+1,) m from 0: steady moves, standing still, turning back once, a little noise."""
    move = step_m * float(rng.choice([0.0, 0.1, 0.5, 0.8, 1.0])) * np.ones(horizon)
    move += 0.1 * step_m * rng.normal(size=horizon)
    if rng.random() < 0.7:
        move[int(rng.integers(0, horizon)) :] *= float(rng.choice([-1.0, -0.3, 0.0]))
    return np.concatenate([np.zeros(1), np.cumsum(move)]) * float(rng.choice([-1.0, 1.0]))


def _cut(
    design: MpcDesign,
    rng: np.random.Generator,
    state: FloatArray,
    path: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> None:
    """Draw one bound a little inside of what the free optimum would do: a program that needs the
    solver and has a solution, which the others seldom have at a short horizon."""
    qp, reach = design.qp, design.limits.fast_range_m
    gradient = qp.gradient_state @ state[1:] + qp.gradient_reference @ (path - state[0])
    rows = qp.rows_state @ state[1:] - qp.rows_command @ np.linalg.solve(qp.hessian, gradient)
    position = state[0] + reach * rows[: low.size * qp.rows_per_step : qp.rows_per_step]
    k, depth = int(rng.integers(low.size)), float(rng.uniform(0.0, 0.05)) * reach
    limit = POSITION_FACTOR * design.limits.position_m
    if rng.random() < 0.5:
        high[k] = np.clip(min(high[k], position[k] - depth), -limit, limit)
    else:
        low[k] = np.clip(max(low[k], position[k] + depth), -limit, limit)


def mpc_window(references: FloatArray, limits: AxisLimits) -> tuple[FloatArray, FloatArray]:
    """Bounds (N,) of y_1..y_N for straight intervals between the references (N+1,): the range at
    both ends of every interval, and the position limit, as the cascade draws them."""
    greatest = np.maximum(references[:-1], references[1:])
    least = np.minimum(references[:-1], references[1:])
    low, high = greatest.copy(), least.copy()
    low[:-1] = np.maximum(low[:-1], greatest[1:])
    high[:-1] = np.minimum(high[:-1], least[1:])
    return (
        np.maximum(low - limits.fast_range_m, -limits.position_m),
        np.minimum(high + limits.fast_range_m, limits.position_m),
    )


def _fast_calls(design: FastDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    """Pushes, begins and steps in any order: queues that run over or dry, intervals cut short."""
    declaration = FastStage(design).declaration
    full = design.points
    for index in range(count):
        path = smooth_path(rng, design.limits, 1e-4, full + 1)
        if index % 40 == 0:
            start: dict[str, Value] = {f"position_{a}": path[0, i] for i, a in enumerate(AXES)}
            yield Call("reset", start)
        for _ in range(rng.integers(0, 3)):
            taken = _points_count(rng, full)
            points: dict[str, Value] = {
                f"points_{a}": path[1:, i].copy() for i, a in enumerate(AXES)
            }
            yield Call("push", {**points, "n_points": taken})
        yield Call("begin", random_inputs(declaration, "begin", rng, 0.3))
        steps = int(rng.choice([0, 1, full - 1, full, full + 3], p=[0.1, 0.1, 0.1, 0.6, 0.1]))
        yield from [Call("step")] * steps


def _cascade_calls(design: CascadeDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    """The cascade around its own model, on a random path, with jumps and disturbances."""
    own, full = Cascade(design), design.governor.points
    names, order = _names(design.governor.order), design.governor.order
    models = [axis.model for axis in design.fast.axes]
    state, left, taken_since = np.zeros((2, order)), 0, 0
    path: FloatArray = np.zeros((0, 2))
    status = Status.FINISHED
    for index in range(count + design.horizon):
        if status is Status.FINISHED or index % 60 == 0:
            step = rng.choice([0.1, 0.5, 1.0]) * design.governor.limits[0].velocity_m_per_s
            step *= design.fast.sample_time_s
            kind = rng.random()
            periods = 60 if kind < 0.7 else 3  # now and then so short that it is finished
            length = int(rng.integers(2, periods * full))
            path, left, taken_since = smooth_path(rng, design.governor.limits, step, length), 0, 0
            if kind > 0.9:  # a jump that no interval may take: the machine stands before it
                reach = np.array([lim.position_m for lim in design.governor.limits])
                path[1:] -= np.copysign(0.5 * reach, path[0])
            state[:] = 0.0
            state[:, 0] = path[0]
            start = Call("reset", {f"position_{a}": path[0, i] for i, a in enumerate(AXES)})
            own.call(start.operation, start.inputs)
            yield start
        left = min(full, len(path) - 1 - taken_since)
        window = np.zeros((2, full))
        window[:, :left] = path[taken_since + 1 : taken_since + 1 + left].T
        call = Call("step", _disturbed(rng, names, state, window, left))
        yield call
        status, outputs = own.call(call.operation, call.inputs)
        taken_since += int(np.asarray(outputs["points_taken"]))
        if status is Status.PRIMING:
            continue
        steps = full if rng.random() < 0.9 else int(rng.integers(0, full))
        for _ in range(steps):
            own.call("fast_step")
            yield Call("fast_step")
        for i, axis in enumerate(AXES):
            command = float(np.asarray(outputs[f"command_{axis}"]))
            for _ in range(full):
                state[i] = models[i].a @ state[i] + models[i].b * command


def _disturbed(
    rng: np.random.Generator, names: list[str], state: FloatArray, window: FloatArray, left: int
) -> dict[str, Value]:
    """Inputs of a cascade step; now and then a push, a lost measurement or a jump of the path."""
    inputs: dict[str, Value] = {}
    kind = rng.random()
    if kind < 0.03:
        window = window + 0.1 * rng.normal(size=(2, 1))
    for i, axis in enumerate(AXES):
        measured = state[i].copy()
        if kind > 0.95:
            measured[1:3] += rng.normal(size=2) * [0.2, 3.0]
        if 0.90 < kind < 0.93:
            measured[rng.integers(len(names))] = np.nan
        inputs |= _state_inputs(f"{axis}_", names, measured)
        inputs[f"points_{axis}"] = window[i].copy()
    inputs["n_points"] = left
    return inputs
