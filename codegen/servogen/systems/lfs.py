"""Linear frequency separation: the conventional baseline of Table I.

The slow command is the reference through a first-order low pass; every interval takes the most
points, at most M, that the fast stage can reach from the slow stage's position at both its ends.
Nothing keeps velocity and acceleration: the cutoff is tuned so that they stay within limits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from servogen.controllers.design import Declaration, Status, Value
from servogen.controllers.fast_design import FastDesign
from servogen.controllers.fast_stage import FastStage
from servogen.controllers.governor_design import AXES
from servogen.plants.statespace import discretise
from servogen.precision import FloatArray
from servogen.systems.closed_loop import Run, run_closed_loop
from servogen.systems.two_stage import Machine


class LfsController:
    """The baseline behind the cascade's interface, so that the same loop runs it."""

    def __init__(self, machine: Machine, fast: FastDesign, declaration: Declaration) -> None:
        self.machine = machine
        self.declaration = declaration
        self._plants = [discretise(slow, machine.slow_period_s) for slow in machine.slow]
        self._fast = FastStage(fast)
        cutoff = machine.project.controller.lfs.cutoff_hz
        self._keep = float(np.exp(-2.0 * np.pi * cutoff * machine.slow_period_s))
        order = self._plants[0].order
        self._names = [port.name for port in declaration.operation("plan").inputs[: 2 * order]]
        self._state: FloatArray = np.zeros((2, order))
        self._last = np.zeros(2)
        self._command = np.zeros(2)

    def call(
        self, operation: str, inputs: dict[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                self._last = np.array([float(np.asarray(given[f"position_{a}"])) for a in AXES])
                self._command = self._last.copy()
                return self._fast.call("reset", given)
            case "predict":
                ahead = [
                    plant.a @ state + plant.b * command
                    for plant, state, command in zip(
                        self._plants, self._states(given), self._command, strict=True
                    )
                ]
                return Status.OK, dict(zip(self._names, np.concatenate(ahead), strict=True))
            case "plan":
                return self._plan(given)
            case "start":
                return self._start()
        raise KeyError(operation)

    def _states(self, given: dict[str, Value]) -> FloatArray:
        values = np.array([given[name] for name in self._names], dtype=float)
        return values.reshape(2, -1)

    def repeat(self, operation: str, count: int) -> FloatArray:
        return np.array([list(self._outputs().values()) for _ in range(count)])

    def _outputs(self) -> dict[str, Value]:
        out = self._fast.step()
        return {p.name: out[p.name] for p in self._fast.declaration.operation("step").outputs}

    def _plan(self, given: dict[str, Value]) -> tuple[Status, dict[str, Value]]:
        count = int(np.asarray(given["n_points"]))
        self._state = self._states(given)
        ahead = [np.asarray(given[f"points_{a}"])[:count] for a in AXES]
        path = np.vstack([self._last, np.stack(ahead, axis=1)])
        taken = self._reachable(path, self._state)
        self._command = self._keep * self._command + (1.0 - self._keep) * path[taken]
        self._last = path[taken]
        self._fast.call("push", {**given, "n_points": taken})
        nothing = dict.fromkeys(("iterations_x", "iterations_y", "status_x", "status_y"), 0)
        return Status.OK, {"points_taken": taken, **nothing}

    def _start(self) -> tuple[Status, dict[str, Value]]:
        begin: dict[str, Value] = dict(zip(self._names, self._state.ravel(), strict=True))
        begin |= {f"slow_command_{a}": self._command[i] for i, a in enumerate(AXES)}
        status, began = self._fast.call("begin", begin)
        commands = {f"command_{a}": self._command[i] for i, a in enumerate(AXES)}
        return status, {**commands, "interval_points": began["interval_points"]}

    def _reachable(self, path: FloatArray, state: FloatArray) -> int:
        """Most points within the fast range of the slow position at both ends of the interval."""
        allowed = np.ones(len(path), dtype=bool)
        for i, plant in enumerate(self._plants):
            reach = self.machine.limits[i].fast_range_m
            command = self._keep * self._command[i] + (1.0 - self._keep) * path[:, i]
            ends = plant.a[0] @ state[i] + plant.b[0] * command
            low = np.minimum.accumulate(path[:, i])
            high = np.maximum.accumulate(path[:, i])
            for position in (state[i, 0], ends):
                allowed &= (high - position <= reach) & (position - low <= reach)
        return int(np.flatnonzero(allowed)[-1]) if np.any(allowed) else 0


def run_lfs(
    machine: Machine,
    fast: FastDesign,
    declaration: Declaration,
    advance: Callable[[], None] | None = None,
) -> Run:
    """Process the path with the baseline; ``fast`` as of the governor alone."""
    return run_closed_loop(machine, LfsController(machine, fast, declaration), advance=advance)
