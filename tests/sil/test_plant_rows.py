"""Rows of a plant of the kinds that leave a table of it empty, in C."""

from __future__ import annotations

import numpy as np
import pytest
from core_designs import temporary_folder

from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_design import declare_qp_solver, design_plant_qp_solver
from servogen.emit.package import emit_package
from servogen.precision import FLOAT64
from servogen.qp.errors import ProgramError
from servogen.qp.row_tables import StageRows, stage_rows
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, compare

STEPS = 5
STAGE = np.array([[1.0, 0.1, 0.005], [0.0, 1.0, 0.1]])  # position and speed of a mass
END = np.array([[1.0, 0.5]])


def plant(limited: int, terminal: bool, bounds: bool) -> StageRows:
    last = END if terminal else np.zeros((0, 2))
    own = np.ones(1) if bounds else None
    return stage_rows(STAGE, last, STEPS, limited, FLOAT64.dtype, bounds=own)


@pytest.mark.parametrize(("limited", "terminal", "bounds"), [(0, True, True), (1, False, False)])
def test_few_kinds_of_rows_are_c(limited: int, terminal: bool, bounds: bool) -> None:
    rows = plant(limited, terminal, bounds)
    design = design_plant_qp_solver("few", FLOAT64, np.eye(STEPS), rows, 40, 1e-9)
    declared = declare_qp_solver(design)
    folder = temporary_folder(f"rows_{limited}_{terminal:d}_{bounds:d}")
    module = compile_package([emit_package("few", (declared,))], folder, ("-O1",))
    rng, calls = np.random.default_rng(1), [Call("reset", {})]
    for _ in range(30):
        linear, width = rng.normal(size=STEPS), rng.uniform(0.1, 0.5, rows.count)
        calls.append(Call("step", {"linear": linear, "low": -width, "high": width}))
    agreement = compare(QpSolver(design), CompiledController(module, declared), calls)
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0
    assert set(agreement.statuses) == {"OK"}


@pytest.mark.parametrize("terminal", [True, False])
def test_a_program_that_needs_no_plant_is_led_to_the_other_design(terminal: bool) -> None:
    with pytest.raises(ProgramError, match=r"design_qp_solver\(bounds=\.\.\.\)"):
        plant(0, terminal, bounds=not terminal)
