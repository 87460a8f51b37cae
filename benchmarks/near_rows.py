"""How programs whose rows nearly depend end: what docs/library-qp.md says of them.

    python benchmarks/near_rows.py [--seeds N] [--lines L ...]

Each seed is one H and A with ten times f and bounds, all kept by a known point to a rounding
(tests/sil/near_programs.py), the working set carried from one to the next. A program counts as
solvable if its point keeps all rows, as rounded, within half of ``accept``: of such ones INFEASIBLE
is wrong. A refinement is a step taken once more because rounding leaves a row of a working set away
from its bound by more than ``accept``. What was missed after one is that of the answer's own set,
where it called for a second one.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "sil"))

import numpy as np
from near_programs import APART, Turn, near_design, near_program

from servogen.controllers.design import Status
from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_design import QpSolverDesign
from servogen.qp import dual_active_set
from servogen.qp.errors import ProgramError

SEEDS = 300


@dataclass(frozen=True)
class Setting:
    """``apart``: powers of ten by which a row stands off from another one."""

    precision: str
    apart: tuple[float, float]
    accept: float


SETTINGS = (
    Setting("float64", APART["float64"], 1e-10),
    Setting("float64", (-7.0, -1.0), 1e-10),
    Setting("float32", APART["float32"], 1e-6),
    Setting("float32", APART["float32"], 1e-4),
    Setting("float32", (-4.0, -1.0), 1e-3),
    Setting("float32", (-5.0, -1.0), 1e-4),
)


class Watch:
    """What the rows of the set miss at the points that are optimal for it, in one call: a list for
    every set that was left unchanged."""

    def __init__(self) -> None:
        self.runs: list[list[float]] = []
        method: Any = dual_active_set._Method
        measure, drop, append = method.measure, method.drop, dual_active_set.append

        def measured(own: Any, rows: Any) -> None:
            measure(own, rows)
            if rows is not own.free_rows and own.work.size:
                missed = float(np.max(np.abs(own.missed[: own.work.size])))
                self.runs[-1].append(missed)

        def changed(of: Any) -> Any:
            def change(*given: Any) -> Any:
                self.runs.append([])
                return of(*given)

            return change

        method.measure, method.drop = measured, changed(drop)
        dual_active_set.append = changed(append)  # type: ignore[assignment]

    def begin(self) -> None:
        """A new call."""
        self.runs = [[]]

    def refined(self, accept: float) -> bool:
        """Whether some step was taken once more."""
        return any(run[0] > accept for run in self.runs if run)

    def again(self, accept: float) -> bool:
        """Whether some was taken more often than that."""
        return any(len(run) > 1 and run[1] > accept for run in self.runs)

    def second(self, accept: float) -> float:
        """What the last set missed after one refinement, where it called for another; or 0."""
        last = self.runs[-1]
        return last[1] if len(last) > 1 and last[1] > accept else 0.0


@dataclass
class Ends:
    """Counts of one setting."""

    programs: int = 0
    solvable: int = 0
    refined: int = 0
    statuses: Counter[str] = field(default_factory=Counter)
    of_solvable: Counter[str] = field(default_factory=Counter)
    again: Counter[str] = field(default_factory=Counter)
    missed: float = 0.0
    wrong: list[tuple[int, int]] = field(default_factory=list)

    def line(self, setting: Setting) -> str:
        """One row of the table."""
        low, high = setting.apart
        share = self.statuses["BACKUP"] / max(self.programs, 1)
        return (
            f"| {setting.precision} | {10.0**low:.0e} to {10.0**high:.0e} | {setting.accept:.0e} "
            f"| {self.programs:,} | {self.statuses['OK']:,} "
            f"| {self.statuses['BACKUP']:,} ({100.0 * share:.0f} %) "
            f"| {self.statuses['INFEASIBLE']} "
            f"| {self.of_solvable['INFEASIBLE']} of {self.solvable:,} "
            f"| {self.refined:,} | {self.again.total()}, {self.again['BACKUP']} of them BACKUP "
            f"| {self.missed:.2g} |"
        )


HEAD = """\
| line | scalar type | rows stand off by | accept | programs | OK | BACKUP | INFEASIBLE \
| of solvable ones | refined | more than once | most missed after one, of those OK |
|---|---|---|---|---|---|---|---|---|---|---|---|"""


def is_solved(design: QpSolverDesign, turn: Turn, accept: float) -> bool:
    """Whether the known point keeps all rows within half of ``accept``, as the solver measures."""
    rows = np.array([design.tables.rows.row(i) for i in range(design.tables.rows.count)])
    scale = design.scale.astype(float)
    values = rows.astype(float) @ turn.point
    beyond = np.maximum(values - turn.high * scale, turn.low * scale - values)
    return bool(np.max(beyond) <= 0.5 * accept)


def ends(setting: Setting, seeds: int, watch: Watch) -> Ends:
    """How the programs of so many seeds end."""
    found = Ends()
    for seed in range(seeds):
        precision, apart, accept = setting.precision, setting.apart, setting.accept
        try:
            design = near_design(seed, precision, accept, apart)
        except ProgramError:  # a Hessian that the precision cannot hold
            continue
        solver = QpSolver(design)
        solver.call("reset")
        for number, turn in enumerate(near_program(seed, precision, apart)[2]):
            watch.begin()
            given = {"linear": turn.linear, "low": turn.low, "high": turn.high}
            status = solver.call("step", given)[0]
            assert status in (Status.OK, Status.BACKUP, Status.INFEASIBLE)
            found.programs += 1
            found.statuses[status.name] += 1
            if is_solved(design, turn, accept):
                found.solvable += 1
                found.of_solvable[status.name] += 1
                if status is Status.INFEASIBLE:
                    found.wrong.append((seed, number))
            found.refined += watch.refined(accept)
            found.again[status.name] += int(watch.again(accept))
            if status is Status.OK:
                found.missed = max(found.missed, watch.second(accept))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="ten programs each")
    every = range(1, len(SETTINGS) + 1)
    parser.add_argument("--lines", type=int, nargs="+", choices=every, default=every)
    given = parser.parse_args()
    watch = Watch()
    print(HEAD)
    for line in given.lines:
        setting = SETTINGS[line - 1]
        found = ends(setting, given.seeds, watch)
        print(f"| {line} {found.line(setting)}", flush=True)
        if found.wrong:
            told = ", ".join(f"{seed}.{number}" for seed, number in found.wrong)
            print(f"line {line}, called INFEASIBLE wrongly, seed.turn: {told}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
