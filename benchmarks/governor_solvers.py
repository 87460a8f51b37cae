"""PQP beside the dual active set on the programs of a command governor, one setting a line.

    python benchmarks/governor_solvers.py [--project FILE] [--programs 100] [--cap 3000]

The closed loop of the project (the bundled one, at a cap of 150) runs on minimal motion and on the
pattern, with the paper's weight R of (17) and with 100; of the programs of both axes whose
reference itself does not keep every row, ``--programs`` are taken, evenly over the run. Both
methods begin each without a guess. A program counts as unanswered where the last of ``--cap``
iterations does not keep the rows, and as unsettled where it does and the duality gap is not closed.
The iterations are counted in float64; the rows are multiplied as one dense matrix.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_design import AxisGovernorDesign
from servogen.controllers.mpc_solver import ActiveSetSolver, Answer
from servogen.precision import FLOAT64, FloatArray
from servogen.progress import Silent
from servogen.project.governor_load import GovernorProject, load_governor_project
from servogen.qp.pqp import PqpTables, pqp_tables, solve
from servogen.qp.tolerances import tolerances
from servogen.resources import resource_dir
from servogen.steps.governor import prepare_governor
from servogen.systems.command_governor_sweeps import run_machine

BUNDLED = resource_dir("examples") / "command_governor" / "servogen.toml"
WEIGHTS, REFERENCES = (0.01, 100.0), ("minimal_motion", "pattern")
# Of the bundled two-stage machine: what PQP runs with there.
PHI, PERIOD, GAP = 0.1, 6, 1e-4


@dataclass(frozen=True)
class Program:
    """What a solver is given: unconstrained optimum, start of the rows, their bounds."""

    free: FloatArray
    start: FloatArray
    below: FloatArray
    above: FloatArray


class Recorder(ActiveSetSolver):
    """The governor's own solver; keeps the programs that ask for an iteration."""

    def __init__(self, solver: ActiveSetSolver, kept: list[Program]) -> None:
        super().__init__(solver.tables)
        self._kept = kept

    def solve(
        self,
        free: FloatArray,
        start: FloatArray,
        below: FloatArray,
        above: FloatArray,
        resume: bool = False,
    ) -> Answer:
        rows = self.tables.rows.product(free, start)
        if np.any(rows > above) or np.any(rows < below):
            self._kept.append(Program(free.copy(), start.copy(), below.copy(), above.copy()))
        return super().solve(free, start, below, above, resume)


@dataclass(frozen=True)
class Dense:
    """Rows (m, N) as one matrix, as far as PQP asks."""

    matrix: FloatArray

    @property
    def variables(self) -> int:
        return int(self.matrix.shape[1])

    def product(self, z: FloatArray) -> FloatArray:
        result: FloatArray = self.matrix @ z
        return result

    def adjoint(self, y: FloatArray) -> FloatArray:
        result: FloatArray = self.matrix.T @ y
        return result


def changed(project: GovernorProject, reference: str, weight: float) -> GovernorProject:
    """The project on another reference and weight, at a cap that no program needs."""
    own = project.controller
    controller = own.model_copy(
        update={
            "motion": own.motion.model_copy(update={"reference": reference}),
            "governor": own.governor.model_copy(update={"weight_reference": weight}),
            "solver": own.solver.model_copy(update={"iteration_cap": 150}),
        }
    )
    return replace(project, controller=controller)


def pqp_of(axis: AxisGovernorDesign, cap: int) -> PqpTables:
    """PQP's tables of the program of an axis."""
    program = axis.program
    tol = tolerances(FLOAT64, axis.tol.margin, GAP, program.hessian, program.scale_m)
    return pqp_tables(
        program.hessian, program.written, Dense(program.written), PHI, PERIOD, cap, tol,
        FLOAT64.dtype, program.rows.per_step, program.rows.steps,
    )  # fmt: skip


def table_bytes(tables: PqpTables, rows: object) -> int:
    """Of the iteration and, as they are shared, of the rows as a plant."""
    return sum(
        v.nbytes for own in (tables, rows) for v in vars(own).values() if hasattr(v, "nbytes")
    )


def judged(axis: AxisGovernorDesign, programs: list[Program], cap: int) -> str:
    """One line of the table."""
    tables = pqp_of(axis, cap)
    tol = tolerances(FLOAT64, axis.tol.margin, GAP, axis.program.hessian, axis.program.scale_m)
    exact, unanswered, unsettled, own, off = ActiveSetSolver(axis.solver), 0, 0, [], []
    counted = []
    for program in programs:
        exact.forget()
        answer = exact.solve(program.free, program.start, program.below, program.above)
        own.append(answer.iterations)
        rows = axis.solver.rows.product(program.free, program.start)
        found = solve(
            tables, tol, program.above - rows, rows - program.below, tables.floor, tables.floor
        )
        counted.append(found.iterations)
        unanswered += not found.feasible
        unsettled += found.feasible and not found.converged
        if found.feasible and answer.z is not None:
            off.append(float(np.abs((program.free - found.correction)[0] - answer.z[0])))
    worst = f"{1e6 * max(off):.3g}" if off else "-"
    return (
        f"{len(programs)} | {np.median(own):.0f}, {max(own)} | {np.median(counted):.0f} | "
        f"{unanswered} | {unsettled} | {worst}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--project", type=Path, default=BUNDLED)
    parser.add_argument("--programs", type=int, default=100)
    parser.add_argument("--cap", type=int, default=3000)
    asked = parser.parse_args()
    project = load_governor_project(asked.project)
    print("| reference, R | programs | active set: median, most | PQP: median | unanswered | "
          "unsettled | first command off by at most, um |")  # fmt: skip
    print("|---|---|---|---|---|---|---|")
    for reference in REFERENCES:
        for weight in WEIGHTS:
            system = prepare_governor(changed(project, reference, weight), Silent())
            governor, kept = CommandGovernor(system.design), list[Program]()
            for axis in governor.axes:
                axis.solver = Recorder(axis.solver, kept)
            run_machine(system.machine, system.design, governor)
            step = max(len(kept) // asked.programs, 1)
            line = judged(system.design.axes[0], kept[::step][: asked.programs], asked.cap)
            print(f"| {reference}, {weight:g} | {line} |", flush=True)
    axis = system.design.axes[0]
    own = sum(table.values.nbytes for table in governor.axes[0].declaration.tables)
    pqp = table_bytes(pqp_of(axis, asked.cap), axis.solver.rows)
    print(f"\ntables of an axis in float64: active set {own} bytes, PQP {pqp} bytes")


if __name__ == "__main__":
    main()
