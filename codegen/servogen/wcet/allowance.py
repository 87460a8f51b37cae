"""What a target's share of the period allows: the largest iteration cap that fits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from servogen.errors import CheckFailed
from servogen.wcet.package import Count
from servogen.wcet.targets import Target


@dataclass(frozen=True)
class Allowance:
    """Budget of one entry point on one target.

    Attributes:
        target: its name.
        precision: of the cycle costs.
        budget_cycles: clock * period * share.
        fixed_cycles: what does not depend on the caps.
        cycles_per_iteration: of one more iteration of every capped loop together.
        cap: the largest cap in the emitted C (0 if nothing is capped).
        total_cycles: worst case with the caps as emitted.
        utilisation: total_cycles / budget_cycles.
        largest_cap: the largest common cap that fits; None if nothing is capped.
        culprit: what breaks the budget: ``fixed part``, or the name of the cap that costs most;
            None if the caps as emitted fit.
    """

    target: str
    precision: str
    budget_cycles: float
    fixed_cycles: float
    cycles_per_iteration: float
    cap: int
    total_cycles: float
    utilisation: float
    largest_cap: int | None
    culprit: str | None

    @property
    def fits(self) -> bool:
        return self.culprit is None

    def to_json(self) -> dict[str, object]:
        return {
            "target": self.target,
            "precision": self.precision,
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
        if self.largest_cap is None:
            return f"{used} ({self.utilisation:.1%})"
        rest = f"{self.cycles_per_iteration:.0f} per iteration, at most {self.largest_cap} fit"
        blame = "" if self.culprit is None else f"; over budget: {self.culprit}"
        return f"{used} ({self.utilisation:.1%}) at a cap of {self.cap}: {rest}{blame}"

    def require(self) -> None:
        """Raise CheckFailed, naming the culprit, if the caps as emitted do not fit."""
        if not self.fits:
            raise CheckFailed(f"the budget does not hold: {self.sentence()}")


def iteration_allowance(
    count: Count, target: Target, precision: str, period_s: float, share: float
) -> Allowance:
    """Budget of ``count`` in ``share`` of ``period_s`` seconds.

    All capped loops of the entry point (both axes) draw on the one budget, with equal caps. The
    cycles of the classes are added up; what they stand for, the target's file says.

    Raises:
        InputError: the target states no cycles for this precision.
    """
    budget = target.clock_hz.value * period_s * share
    fixed = target.cost(count.fixed, precision)
    parts = {cap: target.cost(part, precision) for cap, part in count.per_iteration.items()}
    each = math.fsum(parts.values())
    total = math.fsum([fixed, *(parts[cap] * count.caps[cap] for cap in parts)])
    return Allowance(
        target=target.name,
        precision=precision,
        budget_cycles=budget,
        fixed_cycles=fixed,
        cycles_per_iteration=each,
        cap=max(count.caps.values(), default=0),
        total_cycles=total,
        utilisation=total / budget,
        largest_cap=_largest_cap(budget - fixed, each),
        culprit=None if total <= budget else _culprit(count, parts, fixed, budget),
    )


def _largest_cap(cycles: float, each: float) -> int | None:
    return None if each <= 0 else max(0, math.floor(cycles / each))


def _culprit(count: Count, parts: dict[str, float], fixed: float, budget: float) -> str:
    """The fixed part if it alone is too much, else the costliest cap."""
    if not parts or fixed > budget:
        return "fixed part"
    return max(sorted(parts), key=lambda cap: parts[cap] * count.caps[cap])
