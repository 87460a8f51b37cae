"""Quadratic programs of many kinds for the active-set method, compiled once, and their oracle."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import daqp
import numpy as np
from shared_builds import compiled_once

from servogen.controllers.design import Status
from servogen.controllers.qp_solver_design import (
    QpSolverDesign,
    declare_qp_solver,
    design_plant_qp_solver,
    design_qp_solver,
)
from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS
from servogen.qp.row_tables import RowTables, stage_rows
from servogen.sil.build import Module
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call
from servogen.sil.player import struct_layout

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
# Rows that are no bounds: as many as variables, fewer, where less is stored, and none.
FEW = {
    "box_10": ("box", 10, 20, 70),
    "box_13": ("box", 13, 20, 71),
    "few_9": ("random", 9, 8, 72),
    "alone_10": ("box", 10, 10, 73),
    "alone_1": ("box", 1, 1, 74),
}
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
    own = tuple(declare_qp_solver(design) for design in designs(precision).values())
    return compiled_once([emit_package("programs", own)], ("-O1",))


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


def step(controller: CompiledController, linear: object, low: object, high: object
) -> tuple[Status, Array, int]:  # fmt: skip
    status, out = controller.call("step", {"linear": linear, "low": low, "high": high})
    return status, np.asarray(out["z"]), int(out["iterations"])  # type: ignore[call-overload]


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
