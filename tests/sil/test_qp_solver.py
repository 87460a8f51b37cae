"""Quadratic programs solved in C by the active-set method, against the reference and DAQP."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import daqp
import numpy as np
import pytest
from core_designs import temporary_folder

from servogen.controllers.design import Status
from servogen.controllers.qp_solver import QpSolver
from servogen.controllers.qp_solver_design import (
    QpSolverDesign,
    declare_qp_solver,
    design_plant_qp_solver,
    design_qp_solver,
)
from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS
from servogen.qp.row_tables import RowTables, StageRows, stage_rows
from servogen.sil.build import Module, compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, compare
from servogen.sil.player import struct_layout
from servogen.wcet.package import count_package

KINDS = ("random", "duplicate rows", "integers", "box", "triangle", "badly scaled")
# By turns; 5 and 7 are no multiples of the four lines that share a pass.
SIZES = (((2, 5), (20, 60)), ((5, 12), (7, 30)))
CAP = 200
ACCEPT = {"float64": 1e-9, "float32": 1e-4}

Array = np.ndarray


def program(kind: str, n: int, m: int, seed: int) -> tuple[Array, Array]:
    """H (n, n) and A (m, n)."""
    rng = np.random.default_rng(seed)
    square = rng.normal(size=(n, n))
    hessian = square @ square.T + 0.01 * np.eye(n)
    rows = rng.normal(size=(m, n))
    match kind:
        case "duplicate rows":
            rows[m // 2 :] = rows[: m - m // 2] * rng.choice([-2.0, 0.5, 1.0], m - m // 2)[:, None]
        case "integers":
            rows = np.round(rows)
            rows[~np.any(rows, axis=1), 0] = 1.0
        case "box":
            rows[:n] = np.diag(rng.choice([-2.0, 1.0, 3.0], n))
        case "triangle":
            rows *= np.arange(n) <= (np.arange(m) * n // m)[:, None]
        case "badly scaled":
            unit = 10.0 ** rng.uniform(-8.0, 8.0, n)
            hessian = hessian * np.outer(unit, unit)
            rows = rows * unit * 10.0 ** rng.uniform(-8.0, 8.0, m)[:, None]
    return hessian, rows


def plant(precision: str, inputs: int) -> tuple[Array, RowTables]:
    """H and rows of a plant of three states: all kinds of them with two inputs, few with one, and
    fewer than variables with three, but for their bounds."""
    rng = np.random.default_rng(inputs)
    stage = rng.normal(size=(4, 3 + inputs)) * 0.5
    stage[1, 0], stage[2, 2] = 0.0, 1.0
    outer = np.zeros((2, 3 + inputs))
    outer[0, 0], outer[1, 1:] = 2.0, 1.0
    real, none = PRECISIONS[precision].dtype, np.zeros((0, 3))
    match inputs:
        case 1:
            own = stage_rows(stage[:3], none, 6, 3, real)
        case 2:
            end, bounds = rng.normal(size=(2, 3)), np.array([1.0, 0.5])
            own = stage_rows(stage, end, 4, 2, real, 2, outer, bounds)
        case _:
            own = stage_rows(stage[:3], none, 4, 1, real, 3, bounds=np.array([1.0, 0.5, 2.0]))
    square = rng.normal(size=(own.variables, own.variables))
    return square @ square.T + 0.1 * np.eye(own.variables), own


def written(rows: RowTables) -> Array:
    """A, (m, N)."""
    return np.column_stack([rows.product(unit) for unit in np.eye(rows.variables)])


PROGRAMS = {
    f"{kind.split()[0]}_{n}": (kind, n, m, 10 * i + j)
    for i, kind in enumerate(KINDS)
    for j, (n, m) in enumerate(SIZES[i % 2])
}
PLANTS = {"one_input": 1, "two_inputs": 2, "three_inputs": 3}
# Rows that are no bounds: as many as variables, and fewer, where less is stored.
FEW = {"box_10": ("box", 10, 20, 70), "box_13": ("box", 13, 20, 71), "few_9": ("random", 9, 8, 72)}
# One iteration is enough for one row, two for two.
CAPPED = {"cap_1": 1, "cap_2": 2, "cap_3": 3}


@cache
def designs(precision: str) -> dict[str, QpSolverDesign]:
    real, accept = PRECISIONS[precision], ACCEPT[precision]
    made = {
        name: design_qp_solver(
            name, real, *program(kind, n, m, seed), CAP, accept, bounds=n if kind == "box" else 0
        )
        for name, (kind, n, m, seed) in (PROGRAMS | FEW).items()
    }
    for name, inputs in PLANTS.items():
        hessian, own = plant(precision, inputs)
        made[name] = design_plant_qp_solver(name, real, hessian, own, CAP, accept)
    for name, cap in CAPPED.items():
        rows = np.vstack([np.eye(3), np.ones(3)])
        made[name] = design_qp_solver(name, real, np.eye(3), rows, cap, accept, bounds=3)
    if precision == "float32":
        return made
    weak = np.array([[1.0, 1.0 - 1e-9], [1.0 - 1e-9, 1.0]])
    made["weak"] = design_qp_solver("weak", real, weak, np.eye(2), CAP, accept, bounds=2)
    return made


@cache
def compiled(precision: str) -> Module:
    """At -O1: the bits are the same, and the time is the compiler's. What is emitted for the
    machines of the other tests is compiled at -O3."""
    folder = temporary_folder(f"qp_{precision}")
    own = tuple(declare_qp_solver(design) for design in designs(precision).values())
    return compile_package([emit_package("programs", own)], folder, ("-O1",))


def in_c(name: str, precision: str = "float64") -> CompiledController:
    return CompiledController(compiled(precision), declare_qp_solver(designs(precision)[name]))


def random_inputs(name: str, precision: str, count: int, seed: int) -> np.ndarray:
    """Programs that have little to do with each other, so that every working set is a wrong one;
    one in four narrow, one in eight with bounds that no point keeps. As input structs, (count,)."""
    made = designs(precision)[name]
    rng = np.random.default_rng(seed)
    scale = made.scale.astype(np.float64)
    inverse = made.tables.inverse.astype(np.float64)
    size = np.sqrt(np.diag(inverse))
    n, m = size.size, scale.size
    free = rng.normal(size=(count, n)) * size * 10.0 ** rng.uniform(-1.0, 1.0, (count, 1))
    rows = written(made.tables.rows).astype(np.float64)
    middle = (rng.normal(size=(count, n)) * size) @ rows.T
    narrow = np.arange(count)[:, None] % 4 == 0
    width = 10.0 ** rng.uniform(np.where(narrow, -3.0, -1.0), 1.0, (2, count, m))
    middle[7::8] += rng.normal(size=(len(middle[7::8]), m))
    given = np.zeros(count, layout(name, precision, "in"))
    given["linear"] = -np.linalg.solve(inverse / np.outer(size, size), (free / size).T).T / size
    given["low"] = (middle - width[0]) / scale
    given["high"] = (middle + width[1]) / scale
    return given


def layout(name: str, precision: str, side: str) -> np.dtype:
    declared = declare_qp_solver(designs(precision)[name])
    step = declared.operation("step")
    return struct_layout(step.inputs if side == "in" else step.outputs, declared)


def as_calls(given: np.ndarray) -> Iterator[Call]:
    for one in given:
        yield Call("step", {name: one[name] for name in one.dtype.names})


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


def run_all(name: str, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Output structs and statuses, every call with what the last one left."""
    controller, module = in_c(name), compiled("float64")
    controller.call("reset")
    step = getattr(module.lib, f"{name}_step")
    out = np.zeros(len(given), layout(name, "float64", "out"))
    inputs = module.ffi.from_buffer(f"{name}_step_in[]", given.tobytes())
    outputs = module.ffi.from_buffer(f"{name}_step_out[]", out, require_writable=True)
    status = [step(controller.memory, inputs + i, outputs + i) for i in range(len(given))]
    return out, np.array(status)


@pytest.mark.parametrize("name", ["box_7", "box_13", "triangle_20", "two_inputs"])
def test_the_work_of_a_call_is_counted(name: str) -> None:
    """Rows of all kinds: every loop has a bound that is known, the iterations are told apart."""
    package = emit_package("programs", (declare_qp_solver(designs("float64")[name]),))
    folder = temporary_folder(f"qp_count_{name}")
    package.write(folder)
    files = [folder / source for source in package.sources]
    count = count_package(files, [folder], [f"{name}_step"]).entry_points[f"{name}_step"]
    assert count.caps == {f"{name.upper()}_ITERATION_CAP": CAP}


class Oracle:
    """DAQP on the program scaled to its own units: unit diagonal, rows of unit length."""

    def __init__(self, hessian: Array, rows: Array) -> None:
        self.unit = 1.0 / np.sqrt(np.diag(hessian))
        self.hessian = hessian * np.outer(self.unit, self.unit)
        scaled = rows * self.unit
        self.norm = np.sqrt(
            np.einsum("ij,ij->i", scaled, np.linalg.solve(self.hessian, scaled.T).T)
        )
        self.rows = np.ascontiguousarray(scaled / self.norm[:, None])

    def judge(self, status: Array, z: Array, given: np.ndarray) -> None:
        """Statuses (k,) and answers (k, n)."""
        linear = given["linear"] * self.unit
        low, high = given["low"] / self.norm, given["high"] / self.norm
        cost, weight = np.zeros(len(status)), np.zeros(len(status))
        flag = np.zeros(len(status), dtype=int)
        sense = np.zeros(low.shape[1], dtype=np.int32)
        for i in range(len(status)):
            _, cost[i], flag[i], info = daqp.solve(
                self.hessian, linear[i], self.rows, high[i], low[i], sense, primal_tol=1e-10
            )
            weight[i] = np.abs(info["lam"]).sum()
        unsolved = (status == Status.INFEASIBLE) | (status == Status.BACKUP)
        assert not np.any(unsolved & (flag == 1))
        own = z / self.unit
        at = own @ self.rows.T
        missed = np.max(np.maximum(at - high, low - at), axis=1)
        assert np.all(missed[status == Status.OK] <= 1e-8)
        mine = 0.5 * np.einsum("ij,jk,ik->i", own, self.hessian, own)
        mine += np.einsum("ij,ij->i", linear, own)
        both = (status == Status.OK) & (flag == 1)
        # a bound passed by what is accepted costs that times its multiplier
        spent = 1e-9 * (1.0 + np.abs(cost)) + 1e-8 * weight
        assert np.all(np.abs(mine - cost)[both] <= spent[both])


def step(controller: CompiledController, linear: object, low: object, high: object
) -> tuple[Status, Array, int]:  # fmt: skip
    status, out = controller.call("step", {"linear": linear, "low": low, "high": high})
    return status, np.asarray(out["z"]), int(out["iterations"])  # type: ignore[call-overload]


def test_the_cap_is_the_last_iteration_that_counts() -> None:
    """min |z - a|^2 / 2 in a box: an iteration for every bound that holds, one that says so."""
    outside = {1: [-2.0, 0.0, 0.0], 2: [-2.0, -3.0, 0.0], 3: [-2.0, -3.0, -4.0]}
    wide = np.array([-1.0, -1.0, -1.0, -9.0])
    for name, cap in CAPPED.items():
        for bounds, linear in outside.items():
            controller = in_c(name)
            controller.call("reset")
            assert step(controller, [0.5, 0.0, 0.0], wide, -wide)[0] is Status.OK
            status, z, iterations = step(controller, linear, wide, -wide)
            reached = bounds + 1 <= cap
            assert status is (Status.OK if reached else Status.BACKUP)
            assert iterations == min(bounds + 1, cap)
            held = np.clip(-np.array(linear), -1.0, 1.0) if reached else [-0.5, 0.0, 0.0]
            np.testing.assert_allclose(z, held, atol=1e-15)
            # what the cap left behind is no worse a beginning than any other
            status, z, _ = step(controller, [0.25, 0.0, 0.0], wide, -wide)
            assert status is Status.OK
            np.testing.assert_allclose(z, [-0.25, 0.0, 0.0], atol=1e-15)


def test_a_point_on_its_bound_is_inside_and_one_beyond_what_is_accepted_is_not() -> None:
    controller = in_c("cap_3")
    controller.call("reset")
    for beyond, iterations in ((0.0, 0), (0.5e-9, 0), (2e-9, 2)):
        given = [-1.0 - beyond, 0.0, 0.0]
        status, z, spent = step(controller, given, np.full(4, -9.0), [1.0, 9.0, 9.0, 9.0])
        assert (status, spent) == (Status.OK, iterations)
        assert z[0] <= 1.0 + 1e-9
    # both bounds the same: an equality
    status, z, _ = step(controller, [0.0, 0.0, 0.0], [0.5, -9.0, -9.0, -9.0], [0.5, 9.0, 9.0, 9.0])
    assert status is Status.OK
    np.testing.assert_allclose(z, [0.5, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1.1e90, -1.1e90])
@pytest.mark.parametrize("port", ["linear", "low", "high"])
def test_an_input_that_is_none_leaves_the_last_answer(port: str, value: float) -> None:
    for precision, far in (("float64", 1.0), ("float32", 1e-81)):
        name = "two_inputs"
        reference, controller = QpSolver(designs(precision)[name]), in_c(name, precision)
        given = next(as_calls(random_inputs(name, precision, 2, 9))).inputs
        good = {key: np.array(array) for key, array in given.items()}
        bad = {key: array.copy() for key, array in good.items()}
        bad[port][-1] = value * far
        for solver in (reference, controller):
            assert solver.call("step", good)[0] is Status.NOT_READY
            solver.call("reset")
            assert np.all(solver.call("step", bad)[1]["z"] == 0.0)
            before = solver.call("step", good)
            status, out = solver.call("step", bad)
            infinite = not np.isfinite(value)
            assert status is (Status.NOT_FINITE if infinite else Status.OUT_OF_RANGE)
            np.testing.assert_array_equal(out["z"], before[1]["z"])
            assert out["iterations"] == 0
            after = solver.call("step", good)
            assert before[0] is after[0] is Status.OK
            np.testing.assert_allclose(after[1]["z"], before[1]["z"], rtol=1e-5, atol=1e-5)


def test_the_largest_inputs_are_taken() -> None:
    """The quick question says no, the exact one says yes."""
    controller = in_c("cap_3")
    controller.call("reset")
    far = np.full(4, 1e90)
    assert step(controller, [0.5, 0.0, 0.0], -far, far)[0] is Status.OK
    beyond = np.nextafter(far, np.inf)
    assert step(controller, [0.5, 0.0, 0.0], -far, beyond)[0] is Status.OUT_OF_RANGE


def test_bounds_that_have_changed_places_are_infeasible() -> None:
    for name in ("box_7", "random_20", "two_inputs"):
        given = random_inputs(name, "float64", 8, 11)[:4]
        for i in range(len(given)):
            row = i % given["low"].shape[1]
            middle = 0.5 * (given["low"][i, row] + given["high"][i, row])
            given["low"][i, row], given["high"][i, row] = middle + 1e-3, middle - 1e-3
        reference = QpSolver(designs("float64")[name])
        reference.call("reset")
        out, status = run_all(name, given)
        assert np.all(status == Status.INFEASIBLE), (name, status, out["iterations"])
        for one, expected in zip(as_calls(given), out["iterations"], strict=True):
            assert reference.call("step", one.inputs)[1]["iterations"] == expected
    # by less than what is accepted: any point between them will do
    controller = in_c("cap_3")
    controller.call("reset")
    low, high = np.full(4, -9.0), np.full(4, 9.0)
    low[0], high[0] = 1.0 + 0.4e-9, 1.0 - 0.4e-9
    status, z, _ = step(controller, [0.0, 0.0, 0.0], low, high)
    assert status is Status.OK
    assert abs(z[0] - 1.0) <= 1e-9


def test_a_hessian_that_is_barely_definite() -> None:
    """Eigenvalues 2 and 1e-9: the optimum in a box is on its boundary, and known."""
    controller = in_c("weak")
    controller.call("reset")
    for slope, corner in ((1e-6, -1.0), (-1e-6, 1.0)):
        status, z, _ = step(controller, [slope, -slope], [-1.0, -1.0], [1.0, 1.0])
        assert status is Status.OK
        # rows are accepted to 1e-9 of their length in the metric of H^-1, which is 2e4 here
        np.testing.assert_allclose(z, [corner, -corner], atol=3e-5)
    flat = np.array([[1.0, 1.0], [1.0, 1.0]])
    for refused in (flat, np.diag([1.0, 0.0]), np.diag([1.0, -1.0])):
        with pytest.raises(ValueError, match="hessian"):
            design_qp_solver("no", PRECISIONS["float64"], refused, np.eye(2), CAP, 1e-9)


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
