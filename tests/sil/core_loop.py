"""A cascade around the plant at its slow samples, small enough to be read: an oracle for others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from core_designs import Variant, design, slow_stage

from servogen.controllers.design import Status
from servogen.plants.statespace import discretise


def zigzag(seconds: float = 2.4, speed: float = 0.5, fast_period_s: float = 0.0002) -> np.ndarray:
    """(h+1, 2) m: there and back across 0.2 m in x while y rises and falls; corners are sharp."""
    along = np.arange(round(seconds / fast_period_s) + 1) * speed * fast_period_s
    x = 0.2 - np.abs((along + 0.1) % 0.4 - 0.2) - 0.1
    y = 0.08 * np.sin(along * 12.0)
    return np.stack([x, y], axis=1)


@dataclass
class Record:
    """One row per slow period, priming steps left out."""

    state: np.ndarray  # (K, 2, n)
    status: list[Status]
    outputs: list[dict[str, Any]]
    complete: bool

    @property
    def begun(self) -> int:
        return sum(int(o["interval_points"]) for o in self.outputs)


def run(
    cascade: Any,
    v: Variant,
    path: np.ndarray,
    periods: int = 4000,
    fast_steps: int = 0,
    disturb: Callable[[int, np.ndarray], np.ndarray] | None = None,
) -> Record:
    """Until FINISHED or ``periods``; ``disturb`` changes what is measured in period k."""
    made = design(v)
    bandwidths = (v.bandwidth, 38.0 if v.differing else v.bandwidth)
    plants = [discretise(slow_stage(v.order, w), 0.03) for w in bandwidths]
    names = [p.name for p in cascade.declaration.operation("step").inputs[: 2 * v.order]]
    state = np.zeros((2, v.order))
    state[:, 0] = path[0]
    reset = {f"position_{a}": path[0, i] for i, a in enumerate("xy")}
    assert cascade.call("reset", reset)[0] is Status.OK
    record, given = Record(np.zeros((0, 2, v.order)), [], [], False), 0
    states, window = [], np.zeros((2, made.governor.points))
    while len(states) < periods and not record.complete:
        count = min(v.points, len(path) - 1 - given)
        window[:, :count] = path[given + 1 : given + 1 + count].T
        seen = state if disturb is None else disturb(len(states), state.copy())
        inputs = dict(zip(names, seen.ravel(), strict=True))
        inputs |= {"points_x": window[0], "points_y": window[1], "n_points": count}
        status, outputs = cascade.call("step", inputs)
        given += int(outputs["points_taken"])
        if status is Status.PRIMING:
            continue
        record.complete = status is Status.FINISHED
        states.append(state.copy())
        record.status.append(status)
        record.outputs.append(dict(outputs))
        if fast_steps:
            cascade.repeat("fast_step", fast_steps)
        for i, axis in enumerate("xy"):
            state[i] = plants[i].a @ state[i] + plants[i].b * float(outputs[f"command_{axis}"])
    record.state = np.array(states)
    return record
