"""Quadratic programs solved in C by the active-set method, against the reference and DAQP."""

from __future__ import annotations

import numpy as np
import pytest
from core_designs import temporary_folder
from qp_programs import (
    CAP,
    FEW,
    PLANTS,
    PROGRAMS,
    Oracle,
    as_calls,
    designs,
    in_c,
    plant,
    program,
    random_inputs,
    run_all,
    written,
)

from servogen.controllers.design import Status
from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_design import declare_qp_solver
from servogen.emit.package import emit_package
from servogen.qp.row_tables import StageRows
from servogen.sil.harness import Call, compare
from servogen.wcet.package import count_package


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_c_is_the_reference_bit_for_bit(precision: str) -> None:
    for name in designs(precision):
        many = 12 if name.endswith("_20") else 40
        given = [Call("reset", {}), *as_calls(random_inputs(name, precision, many, 3))]
        agreement = compare(QpSolver(designs(precision)[name]), in_c(name, precision), given)
        assert agreement.passed, (name, agreement.difference)
        assert agreement.worst == 0.0
        if name in PROGRAMS:
            assert "OK" in agreement.statuses, name
            assert {"INFEASIBLE", "BACKUP"} & set(agreement.statuses), name


def test_a_hundred_thousand_programs_are_daqps() -> None:
    """Right answers or right statuses: 12 programs of six kinds, their right sides at random."""
    each, seen = 8400, np.zeros(len(Status), dtype=int)
    for name, (kind, n, m, seed) in PROGRAMS.items():
        given = random_inputs(name, "float64", each, 5)
        out, status = run_all(name, given)
        seen += np.bincount(status, minlength=len(Status))
        Oracle(*program(kind, n, m, seed)).judge(status, out["z"], given)
    assert seen[[Status.OK, Status.INFEASIBLE, Status.BACKUP]].sum() >= 100_000
    assert seen[Status.OK] >= 50_000
    assert seen[Status.INFEASIBLE] >= 8000
    assert seen[Status.BACKUP] <= 1500


@pytest.mark.parametrize("name", FEW)
def test_programs_of_few_rows_are_daqps(name: str) -> None:
    given = random_inputs(name, "float64", 1000, 7)
    out, status = run_all(name, given)
    Oracle(*program(*FEW[name])).judge(status, out["z"], given)
    assert np.count_nonzero(status == Status.OK) > 500
    assert np.count_nonzero(status == Status.BACKUP) <= 30


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_bounds_alone_store_neither_rows_nor_the_line_of_a_row_too_many(precision: str) -> None:
    """And full sets come and go: every other call has no bound that holds."""
    name = "alone_10"
    made = designs(precision)[name]
    declared = declare_qp_solver(made)
    assert not {"rows", "square"} & {field.name for field in declared.state}
    assert {"FACTOR": 10 * 9 // 2}.items() <= {d.name: d.value for d in declared.dimensions}.items()
    given = random_inputs(name, precision, 20, 12)
    given["low"][::2], given["high"][::2] = -1e-3, 1e-3
    given["low"][1::2], given["high"][1::2] = -1e6, 1e6
    reference, sets = QpSolver(made), []
    reference.call("reset")
    for call in as_calls(given):
        assert reference.call("step", call.inputs)[0] is Status.OK
        sets.append(reference.work.size)
    assert max(sets[::2]) == 10
    assert min(sets[::2]) >= made.tables.keep
    assert max(sets[1::2]) == 0
    calls = [Call("reset", {}), *as_calls(given)]
    agreement = compare(QpSolver(made), in_c(name, precision), calls)
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0


@pytest.mark.parametrize("name", PLANTS)
def test_programs_of_a_plant_are_daqps(name: str) -> None:
    given = random_inputs(name, "float64", 1000, 6)
    out, status = run_all(name, given)
    hessian, own = plant("float64", PLANTS[name])
    Oracle(hessian, written(own)).judge(status, out["z"], given)
    # where no z keeps all rows, multipliers may grow until nothing can be said beyond doubt
    lost = status == Status.BACKUP
    assert np.count_nonzero(lost) <= 30
    assert set(status[~lost]) == {Status.OK, Status.INFEASIBLE}


@pytest.mark.parametrize("name", ["box_7", "box_13", "triangle_20", "two_inputs"])
def test_the_work_of_a_call_is_counted(name: str) -> None:
    """Rows of all kinds: every loop has a bound that is known, the iterations are told apart."""
    package = emit_package("programs", (declare_qp_solver(designs("float64")[name]),))
    folder = temporary_folder(f"qp_count_{name}")
    package.write(folder)
    files = [folder / source for source in package.sources]
    count = count_package(files, [folder], [f"{name}_step"]).entry_points[f"{name}_step"]
    assert count.caps == {f"{name.upper()}_ITERATION_CAP": CAP}


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_a_terminal_row_stays_where_it_is_in_the_next_call(precision: str) -> None:
    """Only rows of the end hold: too few to be kept, and shifted to themselves."""
    name = "two_inputs"
    made = designs(precision)[name]
    rows = made.tables.rows
    assert isinstance(rows, StageRows)
    given = random_inputs(name, precision, 20, 12)
    given["low"], given["high"] = -1e3, 1e3
    given["low"][:, rows.stages :], given["high"][:, rows.stages :] = -1e-3, 1e-3
    reference, sets = QpSolver(made), []
    reference.call("reset")
    for call in as_calls(given):
        assert reference.call("step", call.inputs)[0] is Status.OK
        sets.append(reference.work.row[: reference.work.size])
    assert all(0 < len(found) < made.tables.keep and min(found) >= rows.stages for found in sets)
    agreement = compare(
        QpSolver(made), in_c(name, precision), [Call("reset", {}), *as_calls(given)]
    )
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0
    # found again at once: a second iteration would be one for a row that was not there
    assert all(
        reference.call("step", call.inputs)[1]["iterations"] == 1
        for call in list(as_calls(given))[-1:]
    )
