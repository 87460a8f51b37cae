"""What a closed loop of paper 4's machine is judged by: time, motion, work, limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import Status
from servogen.plants.statespace import StateSpace
from servogen.precision import FloatArray, Precision
from servogen.systems.closed_loop import interval_propagation
from servogen.systems.command_governor import GovernorMachine
from servogen.systems.command_governor_loop import Excess, GovernedRun

# By which a limit may be passed where it is kept: what two simulations of a metre differ by, and
# what float32 leaves of the bounds it was given.
ROUNDING = {"float64": 1e-9, "float32": 1e-5}
NAMES = ("position", "velocity", "acceleration", "stroke")


@dataclass(frozen=True)
class SlowMotion:
    """How much the slow stages of x and y moved.

    Attributes:
        distance_m: that they covered. work_j_per_kg: the integral of |v a|.
    """

    largest_velocity: tuple[float, float]
    largest_acceleration: tuple[float, float]
    mean_acceleration: tuple[float, float]
    rms_acceleration: tuple[float, float]
    distance_m: tuple[float, float]
    work_j_per_kg: tuple[float, float]


@dataclass(frozen=True)
class GovernorRow:
    """One controller on one reference, judged.

    Attributes:
        ideal_s: of the ideal machine. motion: of the slow stages.
        iterations: of the axis steps: mean and most. backups, infeasible: axis steps that ended so.
        instants: limits at the N instants of every period and the stroke at its ends; between: at
            every T_f. Shares of the limits, below zero what was left.
        promised: whether the controller is to keep ``instants``.
        stopped: why it did not come to the end of the path.
    """

    name: str
    time_s: float
    ideal_s: float
    periods: int
    complete: bool
    motion: SlowMotion
    iterations: tuple[float, int]
    backups: int
    infeasible: int
    instants: Excess
    between: Excess
    promised: bool
    tolerance: float
    stopped: str = ""

    @property
    def faults(self) -> list[str]:
        """One sentence for each promise that was not kept."""
        if not self.promised:
            return []
        missed = f"the path was not finished: {self.stopped or 'it was ended before'}"
        return [*([] if self.complete else [missed]), *self.broken]

    @property
    def broken(self) -> list[str]:
        """One sentence for each limit that was not kept where the governor keeps it."""
        found = []
        if self.infeasible:
            found.append(f"{self.infeasible} axis steps had no plan that keeps the limits")
        for name in NAMES:
            over = getattr(self.instants, name)
            if over > self.tolerance:
                found.append(f"{name} over its limit by {over:.3g} of it at an instant it is kept")
        return found

    @property
    def passed(self) -> bool:
        return not self.faults


def judge_governed(
    name: str,
    machine: GovernorMachine,
    run: GovernedRun,
    promised: bool = True,
    precision: Precision | None = None,
) -> GovernorRow:
    """A run as a row; ``precision`` of what was inside, by default the project's."""
    fine = run.slow_fine
    of_axes = run.status_axis
    return GovernorRow(
        name=name,
        time_s=run.time_s,
        ideal_s=machine.ideal_s,
        periods=int(run.status.size),
        complete=run.complete,
        motion=slow_motion(fine, machine.period_s / machine.ratio),
        iterations=(float(np.mean(run.iterations)), int(run.iterations.max(initial=0))),
        # an axis whose patience is over is at the cap as well
        backups=int(np.isin(of_axes, (Status.BACKUP, Status.SUBOPTIMAL)).sum()),
        infeasible=int(np.count_nonzero(of_axes == Status.INFEASIBLE)),
        instants=kept_excess(machine, run),
        between=worst_excess(machine, fine, run.tool),
        promised=promised,
        tolerance=ROUNDING[(precision or machine.precision).name],
    )


def stopped_row(name: str, machine: GovernorMachine, why: str, promised: bool) -> GovernorRow:
    """A controller that came to a standstill."""
    none = Excess(*(float("nan"),) * 4)
    return GovernorRow(
        name=name,
        time_s=float("nan"),
        ideal_s=machine.ideal_s,
        periods=0,
        complete=False,
        motion=SlowMotion(*((float("nan"), float("nan")),) * 6),
        iterations=(float("nan"), 0),
        backups=0,
        infeasible=0,
        instants=none,
        between=none,
        promised=promised,
        tolerance=ROUNDING[machine.precision.name],
        stopped=why,
    )


def slow_motion(states: FloatArray, step_s: float) -> SlowMotion:
    """Of states (K, 2, n) at instants ``step_s`` apart."""
    position, velocity, acceleration = (states[:, :, i] for i in range(3))
    return SlowMotion(
        largest_velocity=_two(np.max(np.abs(velocity), axis=0)),
        largest_acceleration=_two(np.max(np.abs(acceleration), axis=0)),
        mean_acceleration=_two(np.mean(np.abs(acceleration), axis=0)),
        rms_acceleration=_two(np.sqrt(np.mean(acceleration**2, axis=0))),
        distance_m=_two(np.sum(np.abs(np.diff(position, axis=0)), axis=0)),
        work_j_per_kg=_two(np.sum(np.abs(velocity * acceleration), axis=0) * step_s),
    )


def kept_excess(machine: GovernorMachine, run: GovernedRun) -> Excess:
    """Where the design keeps its limits: the N instants of each period, which need be no multiple
    of T_f, and the stroke at the ends of periods (or at these instants, if asked for)."""
    governor, ratio = machine.project.controller.governor, machine.ratio
    subs = governor.sub_samples
    states = instant_states(machine.slow, run, subs)
    along = np.arange(len(run.status))[:, None] * ratio + np.arange(subs) * ratio // subs
    tool = run.tool[np.append(along.ravel(), len(run.tool) - 1)]
    found = worst_excess(machine, states, tool)
    every = 1 if governor.sub_step_stroke else subs
    stroke = worst_excess(machine, states[::every], tool[::every]).stroke
    return Excess(found.position, found.velocity, found.acceleration, stroke)


def instant_states(slow: tuple[StateSpace, StateSpace], run: GovernedRun, subs: int) -> FloatArray:
    """(K N + 1, 2, n) at the N instants of every period, and the last one."""
    parts = []
    for i, stage in enumerate(slow):
        on_state, on_command = interval_propagation(stage, run.period_s / subs, subs)
        moved = np.einsum("jab,kb->kja", on_state[:-1], run.slow[:, i])
        moved += run.command[:, i, None, None] * on_command[None, :-1]
        parts.append(np.vstack([moved.reshape(-1, stage.order), run.slow_fine[-1:, i]]))
    return np.stack(parts, axis=1)


def worst_excess(machine: GovernorMachine, states: FloatArray, tool: FloatArray) -> Excess:
    """The worst of some instants.

    Args:
        states: (K, 2, n) of the slow stages. tool: (K, 2) m.
    """
    worst = np.full(4, -np.inf)
    for i, target in enumerate(machine.sets):
        state, limits = states[:, i], target.limits
        shares = (
            np.abs(state[:, 0] - target.centre_m) / limits.position_m,
            np.abs(state[:, 1]) / limits.velocity_m_per_s,
            np.abs(state[:, 2]) / limits.acceleration_m_per_s2,
            np.abs(tool[:, i] - state[:, 0]) / limits.fast_range_m,
        )
        worst = np.maximum(worst, [np.max(share) - 1.0 for share in shares])
    return Excess(*(float(value) for value in worst))


def _two(values: FloatArray) -> tuple[float, float]:
    return float(values[0]), float(values[1])
