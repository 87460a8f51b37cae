"""What a target's share of a period allows: the largest iteration cap that fits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from servogen.errors import CheckFailed
from servogen.wcet.package import Count
from servogen.wcet.targets import Target

_CLOSE = 1e-9  # periods are sums of sample times: equal up to rounding


@dataclass(frozen=True)
class Task:
    """An entry point that is called periodically.

    Attributes:
        name: of the entry point.
        count: its worst case.
        period_s: from one call to the next.
        deadline_s: within this time of its call it has to be done.
    """

    name: str
    count: Count
    period_s: float
    deadline_s: float


@dataclass(frozen=True)
class Allowance:
    """Budget of all that has to be done within one window of time, on one target.

    Attributes:
        target: its name.
        precision: of the cycle costs.
        window_s: the time.
        calls: entry point -> how often it runs within it.
        cycles: entry point -> cycles of these calls.
        budget_cycles: clock * window * share.
        fixed_cycles: what does not depend on the iteration caps.
        cycles_per_iteration: of one more iteration of every capped loop together.
        cap: the largest iteration cap in the emitted C (0 if nothing is capped).
        total_cycles: worst case with the caps as emitted.
        largest_cap: the largest common cap that fits; None if nothing is capped.
        culprit: what breaks the budget: the fixed part of an entry point, or the iteration cap that
            costs most; None if the caps as emitted fit.
        instead: the controller that runs instead of the one it replaces; empty for none.
    """

    target: str
    precision: str
    window_s: float
    calls: Mapping[str, int]
    cycles: Mapping[str, float]
    budget_cycles: float
    fixed_cycles: float
    cycles_per_iteration: float
    cap: int
    total_cycles: float
    largest_cap: int | None
    culprit: str | None
    instead: str = ""

    @property
    def utilisation(self) -> float:
        return self.total_cycles / self.budget_cycles

    @property
    def fits(self) -> bool:
        return self.culprit is None

    @property
    def label(self) -> str:
        """The window, for people and as a key: ``30 ms``, ``0.5 ms with axis_pid``."""
        instead = f" with {self.instead}" if self.instead else ""
        return f"{1e3 * self.window_s:.6g} ms{instead}"

    def to_json(self) -> dict[str, object]:
        return {
            "target": self.target,
            "precision": self.precision,
            "window_s": self.window_s,
            "calls": dict(self.calls),
            "cycles": dict(self.cycles),
            "budget_cycles": self.budget_cycles,
            "fixed_cycles": self.fixed_cycles,
            "cycles_per_iteration": self.cycles_per_iteration,
            "cap": self.cap,
            "total_cycles": self.total_cycles,
            "utilisation": self.utilisation,
            "largest_cap": self.largest_cap,
            "fits": self.fits,
            "culprit": self.culprit,
        }

    def sentence(self) -> str:
        """The result for people, in one sentence."""
        used = f"{self.total_cycles:.0f} of {self.budget_cycles:.0f} cycles on {self.target}"
        used = f"{used} ({self.utilisation:.1%})"
        if self.largest_cap is not None:
            used = f"{used} at a cap of {self.cap}: {self.cycles_per_iteration:.0f} per iteration"
            used = f"{used}, at most {self.largest_cap} fit"
        return used if self.culprit is None else f"{used}; over budget: {self.culprit}"

    def require(self) -> None:
        """Raise CheckFailed, naming the culprit, if the caps as emitted do not fit."""
        if not self.fits:
            raise CheckFailed(f"the budget of {self.label} does not hold: {self.sentence()}")


def allowances(
    tasks: Sequence[Task], target: Target, precision: str, share: float
) -> list[Allowance]:
    """One budget for each deadline, the longest first.

    In a window as long as the deadline the processor has to finish every call with that deadline or
    a shorter one: one that is called more often counts as often as it can fall into the window.

    Args:
        tasks: the periodic entry points.
        target: the processor.
        precision: ``float32`` or ``float64``.
        share: part of the processor that they may use.

    Raises:
        InputError: the target states no cycles for this precision.
    """
    windows: list[float] = []
    for deadline in sorted((task.deadline_s for task in tasks), reverse=True):
        if not windows or deadline < windows[-1] * (1.0 - _CLOSE):
            windows.append(deadline)
    found = []
    for window in windows:
        inside = {
            task.name: (task.count, math.ceil(window / task.period_s * (1.0 - _CLOSE)))
            for task in tasks
            if task.deadline_s <= window * (1.0 + _CLOSE)
        }
        found.append(allowance(inside, target, precision, window, share))
    return found


def allowance(
    calls: Mapping[str, tuple[Count, int]],
    target: Target,
    precision: str,
    window_s: float,
    share: float,
) -> Allowance:
    """Budget of so many calls of each entry point in ``share`` of ``window_s`` seconds.

    All capped loops (both axes, every entry point) draw on the one budget, with equal caps. The
    cycles of the classes are added up; what they stand for, the target's file says.

    Raises:
        InputError: the target states no cycles for this precision.
    """
    budget = target.clock_hz.value * window_s * share
    fixed = {name: n * target.cost(c.base, precision) for name, (c, n) in calls.items()}
    each: dict[tuple[str, str], float] = {}  # entry point, cap -> cycles of one iteration
    for name, (count, number) in calls.items():
        for cap, part in count.per_iteration.items():
            each[name, cap] = number * target.cost(part, precision)
    capped = {key: part * calls[key[0]][0].caps[key[1]] for key, part in each.items()}
    cycles = {
        name: math.fsum([fixed[name], *(c for key, c in capped.items() if key[0] == name)])
        for name in calls
    }
    caps = [number for count, _ in calls.values() for number in count.iteration_caps.values()]
    total, base = math.fsum(cycles.values()), math.fsum(fixed.values())
    return Allowance(
        target=target.name,
        precision=precision,
        window_s=window_s,
        calls={name: number for name, (_, number) in calls.items()},
        cycles=cycles,
        budget_cycles=budget,
        fixed_cycles=base,
        cycles_per_iteration=math.fsum(each.values()),
        cap=max(caps, default=0),
        total_cycles=total,
        largest_cap=_largest_cap(budget - base, math.fsum(each.values())),
        culprit=None if total <= budget else _culprit(fixed, capped, budget),
    )


def _largest_cap(cycles: float, each: float) -> int | None:
    return None if each <= 0 else max(0, math.floor(cycles / each))


def _culprit(
    fixed: Mapping[str, float], capped: Mapping[tuple[str, str], float], budget: float
) -> str:
    """The costliest fixed part if these alone are too much, else the costliest cap."""
    if not capped or math.fsum(fixed.values()) > budget:
        return f"fixed part of {max(sorted(fixed), key=lambda name: fixed[name])}"
    by_cap: dict[str, float] = {}
    for (_, cap), cycles in capped.items():
        by_cap[cap] = by_cap.get(cap, 0.0) + cycles
    return max(sorted(by_cap), key=lambda cap: by_cap[cap])
