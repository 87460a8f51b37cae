"""The cascade around the plant: both stages simulated at T_f, exactly, between slow steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.signal

from servogen.controllers.design import Declaration, Status, Value
from servogen.plants.statespace import StateSpace, discretise
from servogen.precision import FloatArray, IntArray
from servogen.systems.two_stage import Machine

AXES = ("x", "y")
# A loop this many times slower than the ideal machine has stalled.
STALLED = 5.0


class Stalled(RuntimeError):
    """The path is not finished in a multiple of its ideal time."""


class Cascade(Protocol):
    """A reference, its C, or both at once."""

    @property
    def declaration(self) -> Declaration: ...

    def call(
        self, operation: str, inputs: dict[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]: ...

    def repeat(self, operation: str, count: int) -> FloatArray: ...


@dataclass(frozen=True)
class Run:
    """What a closed loop did. K slow periods, M fast samples in each.

    Attributes:
        status: (K,) of the cascade; status_axis: (K, 2); iterations: (K, 2).
        interval_points: (K,) points of each interval; first_point: (K,) index of its first.
        slow: (K, 2, n) states at the slow samples; command: (K, 2).
        slow_fine: (K M, 2, n) states at T_f; fast_command, reference: (K M, 2); along: (K M,)
            index of the reference along the path.
        fast_position: (K M, 2); complete: whether the last point was reached.
    """

    machine: Machine
    status: IntArray
    status_axis: IntArray
    iterations: IntArray
    interval_points: IntArray
    first_point: IntArray
    slow: FloatArray
    command: FloatArray
    slow_fine: FloatArray
    fast_command: FloatArray
    reference: FloatArray
    along: FloatArray
    fast_position: FloatArray
    complete: bool

    @property
    def periods(self) -> int:
        return int(self.status.size)

    @property
    def time_s(self) -> float:
        """From the first command to the end of the interval of the last point."""
        return self.periods * self.machine.slow_period_s

    @property
    def ratio(self) -> float:
        """Completion time over the ideal machine's."""
        return self.time_s / self.machine.timed.duration_s

    @property
    def tool(self) -> FloatArray:
        """(K M, 2) position of the tool: the sum of the stages (2)."""
        result: FloatArray = self.slow_fine[:, :, 0] + self.fast_position
        return result


@dataclass
class _Recorder:
    """Grows the arrays of a run, period by period."""

    rows: list[tuple[int, int, int, int, int, int, int]]
    slow: list[FloatArray]
    command: list[FloatArray]
    fine: list[FloatArray]
    outputs: list[FloatArray]


def interval_propagation(
    slow: StateSpace, fast_period_s: float, ratio: int
) -> tuple[FloatArray, FloatArray]:
    """States at the M fast samples of a period: (M+1, n, n) on its start, (M+1, n) on u."""
    step = discretise(slow, fast_period_s)
    n = slow.order
    on_state, on_command = np.zeros((ratio + 1, n, n)), np.zeros((ratio + 1, n))
    on_state[0] = np.eye(n)
    for j in range(ratio):
        on_state[j + 1] = step.a @ on_state[j]
        on_command[j + 1] = step.a @ on_command[j] + step.b
    return on_state, on_command


def run_closed_loop(
    machine: Machine,
    cascade: Cascade,
    max_periods: int | None = None,
    advance: Callable[[], None] | None = None,
) -> Run:
    """Process the machine's path as a target would: during a period the controller predicts the
    state at the next slow sample and plans for it; at the sample the plan is started.

    Args:
        max_periods: stop there; None for the whole path.
        advance: called after every slow period.

    Raises:
        Stalled: the path takes more than ``STALLED`` times the ideal time.
    """
    points, ratio = machine.timed.points, machine.ratio
    n = machine.slow[0].order
    parts = [interval_propagation(slow, machine.fast_period_s, ratio) for slow in machine.slow]
    record = _Recorder([], [], [], [], [])
    state = np.zeros((2, n))
    state[:, 0] = points[0]
    feeder = _Feeder(cascade, points, ratio, n)
    cascade.call("reset", {f"position_{a}": points[0, i] for i, a in enumerate(AXES)})
    first, last = 0, len(points) - 1
    planned = feeder.plan(state)
    limit = int(STALLED * (len(points) / ratio + 100))
    while first < last and (max_periods is None or len(record.rows) < max_periods):
        started, out = cascade.call("start")
        status = max(planned[0], started if started is not Status.FINISHED else Status.OK)
        _record(record, cascade, Status(status), planned[1] | out, state, first, ratio, parts)
        first += _int(out["interval_points"])
        if first < last:
            planned = feeder.plan(state)
        state = record.fine[-1][-1].copy()
        record.fine[-1] = record.fine[-1][:-1]
        if advance is not None:
            advance()
        if len(record.rows) > limit:
            raise Stalled(f"after {len(record.rows)} slow periods only {first} of {last} points")
    return _finish(machine, record, first == last)


class _Feeder:
    """Gives the controller the measured state and the points that come next."""

    def __init__(self, cascade: Cascade, points: FloatArray, ratio: int, order: int) -> None:
        self.cascade, self.points, self.ratio = cascade, points, ratio
        ports = cascade.declaration.operation("plan").inputs
        self.names = [port.name for port in ports[: 2 * order]]
        self.window = np.zeros((2, ratio))
        self.given = 0

    def plan(self, measured: FloatArray) -> tuple[Status, dict[str, Value]]:
        """Plan from the state (2, n) measured at the last slow sample; primes where asked to."""
        state: dict[str, Value] = dict(zip(self.names, measured.ravel(), strict=True))
        _, ahead = self.cascade.call("predict", state)
        while True:
            count = min(self.ratio, len(self.points) - 1 - self.given)
            self.window[:, :count] = self.points[self.given + 1 : self.given + 1 + count].T
            offered: dict[str, Value] = {
                "points_x": self.window[0],
                "points_y": self.window[1],
                "n_points": count,
            }
            status, out = self.cascade.call("plan", {**ahead, **offered})
            self.given += _int(out["points_taken"])
            if status is not Status.PRIMING:
                return status, out


def _int(value: Value) -> int:
    return int(np.asarray(value))


def _record(
    record: _Recorder,
    cascade: Cascade,
    status: Status,
    out: dict[str, Value],
    state: FloatArray,
    first: int,
    ratio: int,
    parts: list[tuple[FloatArray, FloatArray]],
) -> None:
    command = np.array([float(np.asarray(out[f"command_{a}"])) for a in AXES])
    record.rows.append(
        (
            int(status),
            _int(out["status_x"]),
            _int(out["status_y"]),
            _int(out["iterations_x"]),
            _int(out["iterations_y"]),
            _int(out["interval_points"]),
            first,
        )
    )
    record.slow.append(state.copy())
    record.command.append(command)
    fine = np.stack([parts[i][0] @ state[i] + parts[i][1] * command[i] for i in range(2)], axis=1)
    record.fine.append(fine)
    record.outputs.append(cascade.repeat("fast_step", ratio))


def _finish(machine: Machine, record: _Recorder, complete: bool) -> Run:
    rows = np.array(record.rows, dtype=np.int64).reshape(-1, 7)
    outputs = np.concatenate(record.outputs).astype(np.float64)
    first = np.repeat(rows[:, 6], machine.ratio)
    fast_command = outputs[:, 0:2]
    return Run(
        machine=machine,
        status=rows[:, 0],
        status_axis=rows[:, 1:3],
        iterations=rows[:, 3:5],
        interval_points=rows[:, 5],
        first_point=rows[:, 6],
        slow=np.array(record.slow),
        command=np.array(record.command),
        slow_fine=np.concatenate(record.fine),
        fast_command=fast_command,
        reference=outputs[:, 2:4],
        along=first + outputs[:, 4],
        fast_position=fast_stage_motion(machine, fast_command),
        complete=complete,
    )


def fast_stage_motion(machine: Machine, command: FloatArray) -> FloatArray:
    """(K M, 2) response of the fast stages to their held commands, from rest."""
    columns = []
    for i, fast in enumerate(machine.fast):
        step = discretise(fast, machine.fast_period_s)
        numerator, denominator = scipy.signal.ss2tf(
            step.a, step.b[:, None], step.c[None, :], np.zeros((1, 1))
        )
        columns.append(scipy.signal.lfilter(numerator[0], denominator, command[:, i]))
    return np.stack(columns, axis=1)
