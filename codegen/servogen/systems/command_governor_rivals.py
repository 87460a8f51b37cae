"""What the extended command governor is compared with, on the same machine and drawing.

- Path governor: the scheduled-path reference governor's idea on this machine. The command of a
  period is the reference of one of the next M points, the farthest one that the set allows as a
  command held for ever and up to which the stroke is kept at both ends of the period. It plans
  nothing, and where no point can be taken and the command may not change, it stands still.
- Low pass: the pattern at a uniform lower feed through a first-order low pass is the slow command.
  The feed is the highest one, found by halving, at which stroke, velocity and acceleration keep
  their limits at all instants looked at.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.signal

from servogen.controllers.command_governor_declaration import declare_governor_parts
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Status, Value
from servogen.controllers.governor_design import AXES
from servogen.plants.statespace import StateSpace, discretise
from servogen.precision import FloatArray
from servogen.systems.closed_loop import interval_propagation
from servogen.systems.command_governor import GovernorMachine
from servogen.systems.command_governor_loop import Excess
from servogen.systems.command_governor_rows import (
    ROUNDING,
    GovernorRow,
    slow_motion,
    worst_excess,
)

# Instants of a slow period at which the low pass is looked at; 36 ms / 20 is a fiftieth of the
# time that its slowest pole takes.
LOW_PASS_INSTANTS = 20
# Feeds as shares of the ideal one are found to a thousandth.
FEED_HALVINGS = 10


class PathGovernor:
    """Behind the interface of the extended command governor, so that the same loop runs it."""

    def __init__(self, machine: GovernorMachine, design: CommandGovernorDesign) -> None:
        self.declaration = declare_governor_parts(design)[-1]
        self._most = design.points
        self._sets = machine.plain_sets
        self._plants = [axis.plant for axis in design.axes]
        self._stroke = [axis.program.stroke_m for axis in design.axes]
        order = self._plants[0].order
        self._names = [p.name for p in self.declaration.operation("step").inputs[: 2 * order]]
        self._last = np.zeros(2)
        self._command = np.zeros(2)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        if operation == "reset":
            self._last = np.array([float(np.asarray(given[f"position_{a}"])) for a in AXES])
            self._command = self._last.copy()
            return Status.OK, {}
        state = np.array([given[name] for name in self._names], dtype=float).reshape(2, -1)
        count = min(int(np.asarray(given["n_points"])), self._most)
        points = np.stack([np.asarray(given[f"points_{a}"])[:count] for a in AXES], axis=1)
        slow = np.stack([np.asarray(given[f"slow_{a}"])[:count] for a in AXES], axis=1)
        return Status.OK, self._step(state, points, slow)

    def _step(self, state: FloatArray, points: FloatArray, slow: FloatArray) -> dict[str, Value]:
        path = np.vstack([self._last, points])
        commands = np.vstack([self._command, slow])
        good = np.ones(len(path), dtype=bool)
        for i, plant in enumerate(self._plants):
            least, most = self._sets[i].interval(state[i], np.zeros(0))
            good[1:] &= (commands[1:, i] >= least) & (commands[1:, i] <= most)
            ends = plant.a[0] @ state[i] + plant.b[0] * commands[:, i]
            low = np.minimum.accumulate(path[:, i])
            high = np.maximum.accumulate(path[:, i])
            for position in (state[i, 0], ends):
                good &= (high - position <= self._stroke[i]) & (position - low <= self._stroke[i])
        taken = int(np.flatnonzero(good)[-1]) if np.any(good) else 0
        self._last, self._command = path[taken], commands[taken]
        none = {f"{kind}_{a}": 0 for kind in ("status", "iterations") for a in AXES}
        commanded = {f"command_{a}": self._command[i] for i, a in enumerate(AXES)}
        return {"points_taken": taken, **commanded, **none}


@dataclass(frozen=True)
class _Filtered:
    """The low pass at one feed: states (K, 2, n) and tool (K, 2) at the instants looked at."""

    states: FloatArray
    tool: FloatArray
    periods: int


def low_pass_row(
    machine: GovernorMachine, name: str, cutoff_hz: float | None = None
) -> GovernorRow:
    """The low pass, by default the project's, at the highest uniform feed that it can have."""
    cutoff = machine.project.controller.low_pass.cutoff_hz if cutoff_hz is None else cutoff_hz
    fastest, slowest = 1.0, 0.0
    feed, found = 1.0, _low_passed(machine, 1.0, cutoff)
    if not _keeps(machine, found):
        for _ in range(FEED_HALVINGS):
            middle = 0.5 * (fastest + slowest)
            tried = _low_passed(machine, middle, cutoff)
            if _keeps(machine, tried):
                slowest, feed, found = middle, middle, tried
            else:
                fastest = middle
    states, good = found.states, feed == 1.0 or slowest > 0.0
    excess = worst_excess(machine, states, found.tool)
    return GovernorRow(
        name=name,
        time_s=found.periods * machine.period_s if good else float("nan"),
        ideal_s=machine.ideal_s,
        periods=found.periods,
        complete=good,
        motion=slow_motion(states, machine.period_s / LOW_PASS_INSTANTS),
        iterations=(0.0, 0),
        backups=0,
        infeasible=0,
        instants=excess,
        between=excess,
        promised=False,
        tolerance=ROUNDING[machine.precision.name],
        stopped="" if good else f"no feed from {0.5**FEED_HALVINGS:.2g} on keeps the limits",
    )


def _keeps(machine: GovernorMachine, found: _Filtered) -> bool:
    over: Excess = worst_excess(machine, found.states, found.tool)
    return max(over.position, over.velocity, over.acceleration, over.stroke) <= 0.0


def _low_passed(machine: GovernorMachine, feed: float, cutoff: float) -> _Filtered:
    """The whole path at ``feed`` times the ideal one."""
    points, last = machine.points, len(machine.points) - 1
    subs, taken = LOW_PASS_INSTANTS, feed * machine.ratio
    periods = int(np.ceil(last / taken))
    ends = points[np.minimum((np.arange(1, periods + 1) * taken).astype(np.int64), last)]
    keep = float(np.exp(-2.0 * np.pi * cutoff * machine.period_s))
    start = points[0] * keep
    commands, _ = scipy.signal.lfilter([1.0 - keep], [1.0, -keep], ends, axis=0, zi=start[None])
    states = [
        _driven(stage, machine.period_s, subs, points[0, i], commands[:, i])
        for i, stage in enumerate(machine.slow)
    ]
    along = np.minimum((np.arange(periods * subs) * (taken / subs)).astype(np.int64), last)
    return _Filtered(np.stack(states, axis=1), points[along], periods)


def _driven(
    stage: StateSpace, period_s: float, subs: int, start: float, commands: FloatArray
) -> FloatArray:
    """(K subs, n) states of a stage from rest at ``start`` (m), sent to ``commands`` (K,), m."""
    held = discretise(stage, period_s)
    states = np.zeros((commands.size, stage.order))
    states[0, 0] = start
    for k in range(commands.size - 1):
        states[k + 1] = held.a @ states[k] + held.b * commands[k]
    on_state, on_command = interval_propagation(stage, period_s / subs, subs)
    inside = np.einsum("jab,kb->kja", on_state[:-1], states)
    inside += commands[:, None, None] * on_command[None, :-1]
    result: FloatArray = inside.reshape(-1, stage.order)
    return result
