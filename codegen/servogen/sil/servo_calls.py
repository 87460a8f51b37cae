"""Random calls of a servo axis' controllers: at work around their plant, and disturbed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.design import Value
from servogen.controllers.pid import Pid
from servogen.controllers.pid_design import PidDesign
from servogen.controllers.servo_parts import ServoParts
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# Samples between one reset and the next, and the share of inputs that are no use.
_STRETCH, _BAD = 60, 0.06


def mpc_calls(parts: ServoParts, rng: np.random.Generator, count: int) -> Iterator[Call]:
    """``count`` samples of the MPC around its own model, following steps, ramps and swings; with
    jumps of encoder and references to half a turn and its neighbours, and values of no use."""
    design = parts.mpc
    own, plant = parts.controller(), design.problem.plant
    m, taken = plant.outputs, design.problem.horizons.trajectory
    start: FloatArray = np.zeros(m)
    path: FloatArray = np.zeros((0, m))
    state = np.zeros(plant.order)
    for index in range(count):
        if index % _STRETCH == 0:
            start = _place(rng, design.reach, m)
            path = _motion(rng, _STRETCH + taken + 1, m, _swing(design.reach))
            signal = design.problem.constraints.signal
            if signal is not None and rng.random() < 0.5:  # beyond the bounds of (12)
                side = rng.choice([-1.0, 1.0])
                bound = signal.bounds.upper if side > 0.0 else signal.bounds.lower
                start = bound - side * 0.3 * _swing(design.reach)
                path = side * np.abs(path)
            path = start + path
            reset = Call("reset", {"position": _port(_told(start, design.turn, design.reach))})
            own.call(reset.operation, reset.inputs)
            yield reset
        k = index % _STRETCH
        position = _told(start + plant.c @ state, design.turn, design.reach)
        ahead = _told(path[k + 1 : k + 1 + taken], design.turn, design.reach).ravel()
        if rng.random() < _BAD:
            position, ahead = _spoilt(rng, position, ahead, design.reach, design.turn)
        inputs: dict[str, Value] = {"position": _port(position), "reference": ahead}
        yield Call("step", inputs)
        _, out = own.call("step", inputs)
        current = np.atleast_1d(np.asarray(out["current"], dtype=np.float64))
        state = plant.a @ state + plant.b @ current


def pid_calls(design: PidDesign, rng: np.random.Generator, count: int) -> Iterator[Call]:
    """The same of the PID, on an axis that follows what it asks for as a mass would."""
    own = Pid(design)
    position: FloatArray = np.zeros(1)
    speed, path = 0.0, np.zeros((0, 1))
    # a mass that the limit accelerates within a tenth of a second to a swing in that time
    push = 10.0 * _swing(design.reach) / max(-design.current_low, design.current_high)
    for index in range(count):
        k = index % _STRETCH
        if k == 0:
            position, speed = _place(rng, design.reach, 1), 0.0
            path = position + _motion(rng, _STRETCH, 1, _swing(design.reach))
            reset = Call("reset", {"position": _port(_told(position, design.turn, design.reach))})
            own.call(reset.operation, reset.inputs)
            yield reset
        seen = _told(position, design.turn, design.reach)
        wanted = _told(path[k], design.turn, design.reach)
        if rng.random() < _BAD:
            seen, wanted = _spoilt(rng, seen, wanted, design.reach, design.turn)
        inputs: dict[str, Value] = {"position": _port(seen), "reference": _port(wanted)}
        yield Call("step", inputs)
        own.call("step", inputs)
        current = 0.0
        for _ in range(design.ratio):
            yield Call("filter_step")
            current = float(np.asarray(own.call("filter_step")[1]["current"]))
        speed += push * current * design.sample_time_s
        position = position + speed * design.sample_time_s


def _swing(reach: float) -> float:
    return 0.01 * min(reach, 1000.0)


def _place(rng: np.random.Generator, reach: float, m: int) -> FloatArray:
    """Where an axis stands: at zero, anywhere, or at the end of its range."""
    share = float(rng.choice([0.0, 0.3, 0.97]))
    result: FloatArray = rng.uniform(-share, share, m) * reach
    return result


def _motion(rng: np.random.Generator, samples: int, m: int, size: float) -> FloatArray:
    """(samples, m) from zero: stillness, a step, a ramp, or a swing, of either sign."""
    time = np.arange(samples) / samples
    kind = int(rng.integers(4))
    shape = (
        np.zeros(samples),
        np.where(time > 0.1, 1.0, 0.0),
        time,
        np.sin(2.0 * np.pi * float(rng.choice([1.0, 3.0, 10.0])) * time),
    )[kind]
    scale = size * rng.choice([-1.0, 1.0], m) * 10.0 ** min(rng.uniform(-3.0, 1.0), 0.0)
    result: FloatArray = shape[:, None] * scale
    return result


def _told(position: FloatArray, turn: float, reach: float) -> FloatArray:
    """As an encoder says it: modulo a turn where the axis comes round, within its range if not."""
    result: FloatArray = np.mod(position, turn) if turn else np.clip(position, -reach, reach)
    return result


def _spoilt(
    rng: np.random.Generator, position: FloatArray, ahead: FloatArray, reach: float, turn: float
) -> tuple[FloatArray, FloatArray]:
    """One of the two is no use, far away, or half a turn from where the axis is."""
    position, ahead = position.copy(), ahead.copy()
    half = 0.5 * turn if turn else reach
    turns = float(rng.integers(-3, 4)) * turn
    beside = half * (1.0 + float(rng.choice([0.0, 1e-16, -1e-16, 1e-7, -1e-7])))
    value = float(
        rng.choice(
            [np.nan, np.inf, -np.inf, 2.0 * reach, reach, -reach, position[0] + turns + beside,
             position[0] + turns - beside, beside, -beside]
        )
    )  # fmt: skip
    target = position if rng.random() < 0.5 else ahead
    target[int(rng.integers(target.size))] = value
    return position, ahead


def _port(values: FloatArray) -> Value:
    return float(values[0]) if values.size == 1 else values
