"""``servogen sil``: the compiled C against the reference, in both precisions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Agreement, Stepwise, Twin, compare
from servogen.steps.prepare import Prepared
from servogen.steps.system import ClosedLoop, LoopEnd, Simulated, Studied, System

SCHEMA = "servogen.sil/1"
# The references compute the bits of the C, so values may not differ at all.
BOUND = 0.0
RANDOM_CALLS = 400
SEED = 20260


@dataclass(frozen=True)
class Scenario:
    """One comparison: which controller, under what, in which precision."""

    controller: str
    name: str
    precision: str
    agreement: Agreement


@dataclass(frozen=True)
class LoopCheck:
    """A closed loop in one precision: finished where all of it was run, and its limits kept."""

    precision: str
    loop: ClosedLoop
    end: LoopEnd
    whole: bool

    @property
    def passed(self) -> bool:
        return self.end.kept and (self.end.complete or not self.whole)


@dataclass(frozen=True)
class SilResult:
    """All comparisons and closed loops."""

    scenarios: list[Scenario]
    loops: list[LoopCheck]

    @property
    def passed(self) -> bool:
        return all(s.agreement.passed for s in self.scenarios) and all(
            loop.passed for loop in self.loops
        )

    def lines(self) -> list[str]:
        lines = []
        for precision in dict.fromkeys(s.precision for s in self.scenarios):
            own = [s for s in self.scenarios if s.precision == precision]
            calls = sum(s.agreement.calls for s in own)
            decisions = sum(s.agreement.decisions for s in own)
            worst = max(s.agreement.worst for s in own)
            lines.append(
                f"sil       {precision}: {calls} calls, {decisions} decisions, "
                f"{sum(not s.agreement.passed for s in own)} scenarios differ, "
                f"largest difference {worst:g}"
            )
        lines += [
            f"          {s.precision} {s.controller}, {s.name}: "
            f"{s.agreement.difference or 'no call'}"
            for s in self.scenarios
            if not s.agreement.passed
        ]
        for check in self.loops:
            state = "kept" if check.end.kept else f"BROKEN: {'; '.join(check.end.faults)}"
            short = check.whole and not check.end.complete
            lines.append(
                f"          {check.precision} {check.loop.name}: {check.end.periods} "
                f"{check.loop.steps}{', not finished' if short else ''}, constraints {state}"
                f"{'' if check.passed else ', FAILED'}"
            )
        return lines

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "bound": BOUND,
            "scenarios": [
                {
                    "controller": s.controller,
                    "name": s.name,
                    "precision": s.precision,
                    "passed": s.agreement.passed,
                    "calls": s.agreement.calls,
                    "decisions": s.agreement.decisions,
                    "largest_difference": s.agreement.worst,
                    "statuses": dict(sorted(s.agreement.statuses.items())),
                    "difference": str(s.agreement.difference) if s.agreement.difference else None,
                }
                for s in self.scenarios
            ],
            "closed_loops": [
                {
                    "controller": check.loop.prefix,
                    "name": check.loop.name,
                    "precision": check.precision,
                    "periods": check.end.periods,
                    "whole_path": check.whole,
                    "complete": check.end.complete,
                    "constraints_kept": check.end.kept,
                    "faults": list(check.end.faults),
                    "passed": check.passed,
                }
                for check in self.loops
            ],
        }


def equivalence(
    prepared: Prepared[Simulated, Studied], steps: int | None, progress: Progress
) -> SilResult:
    """Compare every controller of the design on its own and those that users call in their loops.

    Args:
        steps: periods of a loop to compare; None: all.

    Raises:
        CheckFailed: a closed loop stalled.
    """
    scenarios: list[Scenario] = []
    loops: list[LoopCheck] = []
    order = sorted((FLOAT64, FLOAT32), key=lambda p: p is not prepared.precision)
    for precision in order:
        with built(prepared.package_in(precision)) as module:
            scenarios += _suite(module, prepared.system, precision, progress)
            for loop in prepared.system.loops(precision):
                scenario, check = _closed_loop(loop, module, precision, steps, progress)
                scenarios.append(scenario)
                loops.append(check)
    return SilResult(scenarios, loops)


def _suite(
    module: Any, system: System[Simulated, Studied], precision: Precision, progress: Progress
) -> list[Scenario]:
    found = []
    with progress.task(f"Random calls and edges, {precision.name}") as task:
        for case in system.scenarios(precision, SEED, RANDOM_CALLS):
            reference = case.reference()
            compiled = CompiledController(module, reference.declaration)
            agreement = compare(reference, compiled, case.calls, BOUND)
            controller, _, name = case.name.partition(": ")
            found.append(Scenario(controller, name, precision.name, agreement))
            task.advance()
    return found


def _closed_loop(
    loop: ClosedLoop, module: Any, precision: Precision, steps: int | None, progress: Progress
) -> tuple[Scenario, LoopCheck]:
    reference = loop.reference()
    twin = Twin(Stepwise(reference), CompiledController(module, reference.declaration), BOUND)
    title = f"{loop.name[:1].upper()}{loop.name[1:]}, reference beside C, {precision.name}"
    with progress.task(title, steps or loop.total) as task:
        end = loop.run(twin, steps, task.advance)
    scenario = Scenario(loop.prefix, loop.name, precision.name, twin.agreement)
    return scenario, LoopCheck(precision.name, loop, end, steps is None)
