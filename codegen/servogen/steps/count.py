"""``servogen wcet``: counts of the emitted C against the target's budget."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from servogen.controllers.design import Declaration
from servogen.emit.package import CPackage
from servogen.errors import InputError
from servogen.steps.count_text import entry_table, target_table
from servogen.steps.counted import budgets, memory
from servogen.steps.prepare import Prepared
from servogen.steps.system import Simulated, Studied
from servogen.steps.target import project_target
from servogen.wcet.allowance import Allowance
from servogen.wcet.memory import Memory
from servogen.wcet.package import PackageCount
from servogen.wcet.targets import Target, bundled_targets, load_target

SCHEMA = "servogen.wcet/2"


@dataclass(frozen=True)
class Fit:
    """What the package needs of one target.

    Attributes:
        budgets: for each window of time, the longest first; empty where ``missing`` says why.
        missing: a sentence, if the target has no cycles for the precision.
        too_large: a sentence for each dimension that the target's int does not hold.
    """

    target: Target
    budgets: tuple[Allowance, ...]
    memory: Memory
    missing: str = ""
    too_large: tuple[str, ...] = ()

    @property
    def faults(self) -> list[str]:
        """One sentence for each thing that does not fit, the culprit named."""
        over = [
            f"over the budget of {b.label} by {b.culprit}: {b.total_cycles:.0f} of "
            f"{b.budget_cycles:.0f} cycles on {b.target}"
            for b in self.budgets
            if not b.fits
        ]
        full = [f"{self.target.name} is too small: {fault}" for fault in self.memory.faults()]
        return [self.missing] * bool(self.missing) + over + full + list(self.too_large)

    def to_json(self) -> dict[str, object]:
        return {
            "passed": not self.faults,
            "faults": self.faults,
            "budgets": {b.label: b.to_json() for b in self.budgets},
            "memory": self.memory.to_json(),
        }


@dataclass(frozen=True)
class WcetResult:
    """The counts and what they mean on the target that decides; others for comparison.

    Attributes:
        fit: on the target that decides whether the step passed.
        periods: periodic entry point -> its period, s.
        others: every bundled target by name, where they were asked for.
        cheaper: what its user may change where a budget is passed; empty where nothing is known.
        brief: the lines for people leave out the tables; the JSON has everything.
    """

    counts: PackageCount
    fit: Fit
    share: float
    periods: Mapping[str, float]
    others: Mapping[str, Fit] = field(default_factory=dict)
    cheaper: str = ""
    brief: bool = False

    @property
    def passed(self) -> bool:
        return not self.fit.faults

    @property
    def summary(self) -> str:
        """One line: what is used of time and memory."""
        times = [f"{b.utilisation:.1%} of the budget of {b.label}" for b in self.fit.budgets]
        m = self.fit.memory
        times.append(f"{m.data_bytes} of {m.data_limit} bytes of data")
        times.append(f"{m.table_bytes} of {m.program_limit} bytes of tables")
        return f"{', '.join(times)} on {self.fit.target.name}"

    def cycles(self, entry: str) -> float:
        """Of one call in the worst case."""
        return self.fit.target.cost(self.counts.entry_points[entry].total(), self.counts.precision)

    def utilisation(self, entry: str) -> float | None:
        """Share of its period that one call takes; None for what is not periodic."""
        period = self.periods.get(entry)
        return (
            None
            if period is None
            else self.cycles(entry) / (self.fit.target.clock_hz.value * period)
        )

    def lines(self) -> list[str]:
        target, memory = self.fit.target, self.fit.memory
        lines = [f"wcet      {self.counts.precision} on {target.name}: {target.description}"]
        lines += [] if self.brief else _under(entry_table(self))
        lines += _under(
            [f"within {b.label}: {_calls(b.calls)}: {b.sentence()}" for b in self.fit.budgets]
        )
        lines += _under(
            [
                f"data {memory.data_bytes} of {memory.data_limit} bytes: "
                f"state {sum(memory.state.values())}, arguments {sum(memory.arguments.values())}, "
                f"stack of C objects {sum(memory.stack.values())}; "
                f"tables {memory.table_bytes} of {memory.program_limit} bytes",
            ]
        )
        if self.others and not self.brief:
            lines += _under(["", *target_table(self.others)])
        lines += _under(
            [
                "operations are counted in the C; cycles are the target file's estimates",
                *(f"FAILED: {fault}" for fault in self.fit.faults),
            ]
        )
        if self.cheaper and not all(b.fits for b in self.fit.budgets):
            lines += _under([f"what makes it cheaper: {self.cheaper}; or target.share"])
        return [line.rstrip() for line in lines]

    def to_json(self) -> dict[str, object]:
        counted = self.counts.to_json()
        entries = {
            name: {
                **count.to_json(),
                "cycles": self.cycles(name),
                "period_s": self.periods.get(name),
                "utilisation_of_period": self.utilisation(name),
            }
            for name, count in self.counts.entry_points.items()
        }
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.fit.faults,
            "target": self.fit.target.name,
            "share": self.share,
            "budgets": {b.label: b.to_json() for b in self.fit.budgets},
            "memory": self.fit.memory.to_json(),
            **counted,
            "entry_points": entries,
            "targets": {name: fit.to_json() for name, fit in self.others.items()},
        }


def _under(lines: list[str]) -> list[str]:
    return [f"          {line}" for line in lines]


def _calls(calls: Mapping[str, int]) -> str:
    return " + ".join(f"{number} {name}" if number > 1 else name for name, number in calls.items())


def count(
    prepared: Prepared[Simulated, Studied], target_name: str | None, all_targets: bool = False
) -> WcetResult:
    """Count every entry point; hold those that run periodically to the target's budget.

    Raises:
        InputError: no such target, or one without cycles for the precision.
    """
    project, precision = prepared.project, prepared.precision
    target = project_target(project, target_name)
    package, counts = prepared.package_in(precision), prepared.counts_in(precision)
    fit = fit_of(package, counts, target, project.target.share)
    if fit.missing:
        raise InputError(None, "target", target.name, f"one with cycles for {precision.name}")
    others = [load_target(name) for name in bundled_targets()] if all_targets else []
    return WcetResult(
        counts=counts,
        fit=fit,
        share=project.target.share,
        periods=periods_of(package.declarations),
        others={t.name: fit_of(package, counts, t, project.target.share) for t in others},
        cheaper=prepared.system.cheaper,
    )


def survey(prepared: Prepared[Simulated, Studied]) -> WcetResult:
    """On the project's target and on all others, told briefly."""
    return replace(count(prepared, None, all_targets=True), brief=True)


def fit_of(package: CPackage, counts: PackageCount, target: Target, share: float) -> Fit:
    """Cycles and memory of a package on a target."""
    occupied, large = memory(package, counts, target), too_large(package, target)
    if counts.precision not in target.cycles:
        known = " or ".join(target.cycles)
        missing = f"{target.name} has no cycles for {counts.precision}, only for {known}"
        return Fit(target, (), occupied, missing, large)
    found = tuple(budgets(package, counts, target, share))
    return Fit(target, found, occupied, too_large=large)


def too_large(package: CPackage, target: Target) -> tuple[str, ...]:
    """Dimensions beyond the target's int. They are enumeration constants, loop bounds and indices,
    all of them int; only the place in a matrix, which is larger, is computed in 32 bits."""
    most = 2 ** (target.int_bits - 1) - 1
    return tuple(
        f"{dim.name} of {d.prefix} is {dim.value}, more than an int of {target.int_bits} bits on "
        f"{target.name} holds"
        for d in package.declarations
        for dim in d.dimensions
        if dim.value > most
    )


def periods_of(declarations: tuple[Declaration, ...]) -> dict[str, float]:
    return {
        f"{d.prefix}_{op.name}": op.period_s
        for d in declarations
        for op in d.operations
        if op.period_s
    }
