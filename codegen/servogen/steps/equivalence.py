"""``servogen sil``: the compiled C against the reference, in both precisions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from servogen.controllers.cascade import Cascade
from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.errors import CheckFailed
from servogen.precision import FLOAT32, FLOAT64, Precision
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Agreement, Twin, compare
from servogen.sil.scenarios import suite
from servogen.steps.prepare import Prepared
from servogen.systems.closed_loop import Stalled, run_closed_loop
from servogen.systems.metrics import bounds

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
    """The closed loop of one precision: finished, and its constraints kept."""

    precision: str
    periods: int
    whole_path: bool
    complete: bool
    constraints_kept: bool

    @property
    def passed(self) -> bool:
        return self.constraints_kept and (self.complete or not self.whole_path)


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
        for loop in self.loops:
            state = "kept" if loop.constraints_kept else "BROKEN"
            lines.append(
                f"          {loop.precision} closed loop: {loop.periods} slow periods, "
                f"constraints {state}{'' if loop.passed else ', FAILED'}"
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
                    "precision": loop.precision,
                    "periods": loop.periods,
                    "whole_path": loop.whole_path,
                    "complete": loop.complete,
                    "constraints_kept": loop.constraints_kept,
                    "passed": loop.passed,
                }
                for loop in self.loops
            ],
        }


def equivalence(prepared: Prepared, steps: int | None, progress: Progress) -> SilResult:
    """Compare every controller of the design on its own and the cascade in its closed loop.

    Raises:
        CheckFailed: a closed loop stalled.
    """
    scenarios: list[Scenario] = []
    loops: list[LoopCheck] = []
    order = sorted((FLOAT64, FLOAT32), key=lambda p: p is not prepared.machine.precision)
    for precision in order:
        design = prepared.in_precision(precision)
        with built(prepared.package_in(precision)) as module:
            scenarios += _suite(module, design, precision, progress)
            scenario, loop = _closed_loop(prepared, module, design, precision, steps, progress)
            scenarios.append(scenario)
            loops.append(loop)
    return SilResult(scenarios, loops)


def _suite(
    module: Any, design: CascadeDesign, precision: Precision, progress: Progress
) -> list[Scenario]:
    found = []
    with progress.task(f"Random calls and edges, {precision.name}") as task:
        for case in suite(design, SEED, RANDOM_CALLS):
            reference = case.reference()
            compiled = CompiledController(module, reference.declaration)
            agreement = compare(reference, compiled, case.calls, BOUND)
            controller, _, name = case.name.partition(": ")
            found.append(Scenario(controller, name, precision.name, agreement))
            task.advance()
    return found


def _closed_loop(
    prepared: Prepared,
    module: Any,
    design: CascadeDesign,
    precision: Precision,
    steps: int | None,
    progress: Progress,
) -> tuple[Scenario, LoopCheck]:
    machine = prepared.machine
    twin = Twin(Cascade(design), CompiledController(module, declare_parts(design)[-1]), BOUND)
    total = steps or int(np.ceil(len(machine.timed.points) / machine.ratio))
    with progress.task(f"Closed loop, reference beside C, {precision.name}", total) as task:
        try:
            run = run_closed_loop(machine, twin, steps, task.advance)
        except Stalled as stalled:
            raise CheckFailed(
                f"the closed loop in {precision.name} stalled: {stalled}"
            ) from stalled
    kept = all(bound.passed for bound in bounds(run))
    scenario = Scenario(design.prefix, "closed loop", precision.name, twin.agreement)
    return scenario, LoopCheck(precision.name, run.periods, steps is None, run.complete, kept)
