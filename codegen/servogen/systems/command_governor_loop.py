"""The extended command governor of paper 4 around its machine, both axes simulated at T_f, exactly.

In every slow period the tool is at the points that the governor gave it, one each T_f, and then
waits at the last of them; the fast stage makes up what the slow one is away from it (9).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servogen.controllers.command_governor_declaration import AXES
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Declaration, Status, Value
from servogen.errors import InputError
from servogen.plants.statespace import StateSpace
from servogen.precision import BoolArray, FloatArray, IntArray
from servogen.systems.closed_loop import STALLED, Stalled, interval_propagation

# A reference on the end of its tube is rounded there: metres of some 0.2, a few units in the last.
ROUNDING_M = 1e-12


class Governor(Protocol):
    """A reference or its C."""

    @property
    def declaration(self) -> Declaration: ...

    def call(
        self, operation: str, inputs: dict[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]: ...


# (count, 2) m of the points from the first number on: where the slow stages are sent while they are
# machined, as far as it is known by then.
Ahead = Callable[[int, int], FloatArray]


class Unreachable(Stalled):
    """The governor says that a path cannot be followed; ``point`` is the first out of reach."""

    def __init__(self, point: int) -> None:
        super().__init__(f"UNREACHABLE: both stages stand, and point {point} is out of reach")
        self.point = point


@dataclass(frozen=True)
class GovernedRun:
    """What a closed loop did. K slow periods, M fast samples in each.

    Attributes:
        status: (K,); status_axis, iterations: (K, 2).
        taken: (K,) points of each period. first: (K,) number of the last one before it.
        slow: (K, 2, n) states at the slow samples; command: (K, 2).
        slow_fine: (K M + 1, 2, n) states at T_f. tool: (K M + 1, 2) where the tool is.
        complete: whether the last point was reached.
        period_s: T_s.
    """

    status: IntArray
    status_axis: IntArray
    iterations: IntArray
    taken: IntArray
    first: IntArray
    slow: FloatArray
    command: FloatArray
    slow_fine: FloatArray
    tool: FloatArray
    complete: bool
    period_s: float

    @property
    def time_s(self) -> float:
        """From the first command to the end of the period of the last point."""
        return self.status.size * self.period_s


@dataclass(frozen=True)
class Excess:
    """By how much a limit was passed at the worst of some instants, as a share of it; negative:
    what was left. ``position`` in shares of half its range."""

    position: float
    velocity: float
    acceleration: float
    stroke: float


def run_governed(
    design: CommandGovernorDesign,
    slow: tuple[StateSpace, StateSpace],
    points: FloatArray,
    reference: FloatArray | Ahead,
    governor: Governor,
    max_periods: int | None = None,
    advance: Callable[[], None] | None = None,
) -> GovernedRun:
    """Machine a path from its first point, where both stages stand.

    Args:
        points: (J, 2) the pattern (7), m. reference: (J, 2) of the slow stages (19), m, or what
            makes it while the path is machined.
        max_periods: stop there; None for the whole path.
        advance: called after every slow period.

    Raises:
        Stalled: the tool waits for good; Unreachable: the governor says that it does.
    """
    ratio, n, last = design.points, design.axes[0].plant.order, len(points) - 1
    period = design.axes[0].plant.sample_time_s
    parts = [interval_propagation(stage, period / ratio, ratio) for stage in slow]
    rows: list[tuple[int, ...]] = []
    states, commands, fine = [], [], []
    state = np.zeros((2, n))
    state[:, 0] = points[0]
    names = [p.name for p in governor.declaration.operation("step").inputs[: 2 * n]]
    window = {f"{k}_{a}": np.zeros(design.window) for k in ("points", "slow") for a in AXES}
    governor.call("reset", {f"position_{a}": points[0, i] for i, a in enumerate(AXES)})
    first, waited, limit = 0, 0, _longest_wait(design)
    while first < last and (max_periods is None or len(rows) < max_periods):
        count = min(design.window, last - first)
        ahead = reference(first + 1, count) if callable(reference) else reference[first + 1 :]
        for i, axis in enumerate(AXES):
            window[f"points_{axis}"][:count] = points[first + 1 : first + 1 + count, i]
            window[f"slow_{axis}"][:count] = ahead[:count, i]
        inputs: dict[str, Value] = dict(zip(names, state.ravel(), strict=True))
        status, out = governor.call("step", {**inputs, **window, "n_points": count})
        command = np.array([float(np.asarray(out[f"command_{a}"])) for a in AXES])
        taken = int(np.asarray(out["points_taken"]))
        of_axes = [int(np.asarray(out[f"{k}_{a}"])) for k in ("status", "iterations") for a in AXES]
        rows.append((int(status), *of_axes, taken, first))
        states.append(state)
        commands.append(command)
        moved = np.stack([p[0] @ state[i] + p[1] * command[i] for i, p in enumerate(parts)], axis=1)
        fine.append(moved[:-1])
        state, first = moved[-1], first + taken
        waited = 0 if taken else waited + 1
        if advance is not None:
            advance()
        if status is Status.UNREACHABLE:  # of the same points for ever
            raise Unreachable(first + 1)
        if waited > limit:
            told = f"after {len(rows)} slow periods only {first} of {last} points"
            raise Stalled(f"{told}, none in the last {waited}")
    table = np.array(rows, dtype=np.int64).reshape(-1, 7)
    along = np.minimum(np.arange(ratio)[None, :], table[:, 5:6]) + table[:, 6:7]
    return GovernedRun(
        status=table[:, 0],
        status_axis=table[:, 1:3],
        iterations=table[:, 3:5],
        taken=table[:, 5],
        first=table[:, 6],
        slow=np.array(states),
        command=np.array(commands),
        slow_fine=np.concatenate([*fine, state[None]]),
        tool=points[np.append(along.ravel(), first)],
        complete=first == last,
        period_s=period,
    )


def _longest_wait(design: CommandGovernorDesign) -> int:
    """Periods without a point after which a loop has stalled: many times what a stage takes, from
    rest to rest, for the longest step between two points; and what a stage at rest may be at the
    cap, which the controller tells itself."""
    most = 0.0
    for axis in design.axes:
        step, limits = 2.0 * axis.program.stroke_m, axis.reach
        quick = 2.0 * float(np.sqrt(step / limits.acceleration_m_per_s2))
        time = step / limits.velocity_m_per_s + quick
        most = max(most, time / axis.plant.sample_time_s)
    return int(STALLED * (100.0 + 2.0 * most)) + max(axis.patience for axis in design.axes)


def excess(design: CommandGovernorDesign, run: GovernedRun, every: int) -> Excess:
    """The worst of every ``every``-th fast sample: M / N for the instants of the constraints, M for
    the slow samples alone, 1 for all that happened."""
    worst = np.full(4, -np.inf)
    for i, axis in enumerate(design.axes):
        state, limits = run.slow_fine[::every, i], axis.reach
        centre = axis.program.centre_m
        half = limits.position_m - abs(centre)
        shares = (
            np.abs(state[:, 0] - centre) / half,
            np.abs(state[:, 1]) / limits.velocity_m_per_s,
            np.abs(state[:, 2]) / limits.acceleration_m_per_s2,
            np.abs(run.tool[::every, i] - state[:, 0]) / limits.fast_range_m,
        )
        worst = np.maximum(worst, [np.max(share) - 1.0 for share in shares])
    return Excess(*(float(value) for value in worst))


_AXIS = ("machine.{axis}.slow.position_limit_m", "controller.governor.steady_state_tightening")
_REACH = ("machine.{axis}.fast.range_m", "controller.motion.stroke_reserve_m")


@dataclass(frozen=True)
class DrawingFault:
    """The first point of a path at which the governor might stop for ever, what it lacks, and the
    ``keys`` of a project file that ask for it."""

    point: int
    expected: str
    keys: tuple[str, ...] = ()


def check_drawing(
    design: CommandGovernorDesign, points: FloatArray, reference: FloatArray, epsilon_m: float
) -> None:
    """Refuse a path that the governor might not finish, before it is begun; see ``drawing_fault``.

    Raises:
        InputError: with the first point at which it fails.
    """
    fault = drawing_fault(design, points, reference, epsilon_m)
    if fault is not None:
        raise InputError(None, f"point {fault.point}", None, fault.expected)


def drawing_fault(
    design: CommandGovernorDesign, points: FloatArray, reference: FloatArray, epsilon_m: float
) -> DrawingFault | None:
    """Why the governor might not finish a path, None where it does.

    It goes on as long as the stage, once at rest at the reference of the next point, has that in
    reach: the reference is within the stroke less ``epsilon_m`` of its point and inside V', two
    points in succession can be in reach of one position, and the first one is where a stage can
    stand.

    Args:
        points: (J, 2), reference: (J, 2), m. epsilon_m: of (19), above zero.
    """
    for i, (name, axis) in enumerate(zip(AXES, design.axes, strict=True)):
        program = axis.program
        steady = float(program.limit[-1]) * program.scale_m  # V' is the last row
        own, slow = points[:, i], reference[:, i]
        reach = program.stroke_m - epsilon_m + ROUNDING_M
        step = 2.0 * program.stroke_m - program.settle_m - epsilon_m
        start = np.full(own.size, False)
        start[0] = abs(own[0] - program.centre_m) > steady
        beyond = np.abs(slow - program.centre_m) > steady
        far = np.append(False, np.abs(np.diff(own)) > step)
        asked: tuple[tuple[BoolArray, str, tuple[str, ...]], ...] = (
            (start, f"a start {steady:g} m or less from the middle of {name}", _AXIS),
            (
                beyond,
                f"a reference {steady:g} m or less from the middle of {name}, inside the axis",
                _AXIS,
            ),
            (np.abs(own - slow) > reach, f"a reference within {reach:g} m of it in {name}", _REACH),
            (far, f"a step of at most {step:g} m to it in {name}", _REACH),
        )
        for bad, expected, keys in asked:
            if np.any(bad):
                told = tuple(key.format(axis=name) for key in keys)
                return DrawingFault(int(np.argmax(bad)), expected, told)
    return None
