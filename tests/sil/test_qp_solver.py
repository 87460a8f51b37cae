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
    design_qp_solver,
)
from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS
from servogen.sil.build import Module, compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, compare

KINDS = ("random", "duplicate rows", "integers", "box", "triangle", "badly scaled")
SIZES = ((2, 5), (4, 12), (8, 30), (20, 60))
CAP = 200


def program(kind: str, n: int, m: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
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
            rows[:n] = np.eye(n)[: min(n, m)]
        case "triangle":
            rows *= np.arange(n) <= (np.arange(m) * n // m)[:, None]
        case "badly scaled":
            unit = 10.0 ** rng.uniform(-8.0, 8.0, n)
            hessian = hessian * np.outer(unit, unit)
            rows = rows * unit * 10.0 ** rng.uniform(-8.0, 8.0, m)[:, None]
    return hessian, rows


@cache
def designs(precision: str) -> dict[str, QpSolverDesign]:
    made = {}
    for i, kind in enumerate(KINDS):
        for j, (n, m) in enumerate(SIZES):
            prefix = f"{kind.split()[0]}_{n}_{m}"
            accept = 1e-9 if precision == "float64" else 1e-4
            made[prefix] = design_qp_solver(
                prefix, PRECISIONS[precision], *program(kind, n, m, 10 * i + j), CAP, accept
            )
    return made


@cache
def compiled(precision: str) -> Module:
    folder = temporary_folder(f"qp_{precision}")
    own = tuple(declare_qp_solver(design) for design in designs(precision).values())
    return compile_package([emit_package("programs", own)], folder)


def in_c(prefix: str, precision: str) -> CompiledController:
    return CompiledController(compiled(precision), declare_qp_solver(designs(precision)[prefix]))


def calls(prefix: str, precision: str, count: int, seed: int) -> Iterator[Call]:
    """Programs that have little to do with each other, so that every working set is a wrong one;
    one in four narrow, one in eight with bounds that no point keeps."""
    made = designs(precision)[prefix]
    rng = np.random.default_rng(seed)
    scale = made.scale.astype(np.float64)
    inverse = made.tables.inverse.astype(np.float64)
    size = np.sqrt(np.diag(inverse))
    written = made.tables.rows
    for i in range(count):
        free = rng.normal(size=size.size) * size * 10.0 ** rng.uniform(-1.0, 1.0)
        inside = rng.normal(size=size.size) * size
        middle = written.product(inside.astype(made.precision.dtype)).astype(np.float64)
        width = 10.0 ** rng.uniform(-3.0 if i % 4 == 0 else -1.0, 1.0, (2, scale.size))
        if i % 8 == 7:
            middle = middle + rng.normal(size=scale.size)
        linear = np.linalg.solve(inverse / np.outer(size, size), free / size) / size
        yield Call(
            "step",
            {
                "linear": -linear,
                "low": (middle - width[0]) / scale,
                "high": (middle + width[1]) / scale,
            },
        )


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("kind", KINDS)
def test_c_is_the_reference_bit_for_bit(kind: str, precision: str) -> None:
    statuses: set[str] = set()
    for n, m in SIZES:
        prefix = f"{kind.split()[0]}_{n}_{m}"
        made = designs(precision)[prefix]
        given = [Call("reset", {}), *calls(prefix, precision, 60, 3)]
        agreement = compare(QpSolver(made), in_c(prefix, precision), given)
        assert agreement.passed, agreement.difference
        assert agreement.worst == 0.0
        statuses |= set(agreement.statuses)
    assert {"OK", "INFEASIBLE"} <= statuses


def test_a_hundred_thousand_programs_are_daqps() -> None:
    """Right answers or right statuses: 24 programs of six kinds, their right sides at random."""
    each, seen = 4200, {status: 0 for status in Status}
    for kind in KINDS:
        for i, (n, m) in enumerate(SIZES):
            prefix = f"{kind.split()[0]}_{n}_{m}"
            controller = in_c(prefix, "float64")
            controller.call("reset")
            oracle = Oracle(*program(kind, n, m, 10 * KINDS.index(kind) + i))
            for call in calls(prefix, "float64", each, 5):
                status, out = controller.call("step", call.inputs)
                seen[status] += 1
                oracle.judge(status, np.asarray(out["z"]), call)
    assert seen[Status.OK] + seen[Status.INFEASIBLE] + seen[Status.BACKUP] >= 100_000
    assert seen[Status.BACKUP] <= 10


class Oracle:
    """DAQP on the program scaled to its own units: unit diagonal, rows of unit length."""

    def __init__(self, hessian: np.ndarray, rows: np.ndarray) -> None:
        self.unit = 1.0 / np.sqrt(np.diag(hessian))
        self.hessian = hessian * np.outer(self.unit, self.unit)
        scaled = rows * self.unit
        self.norm = np.sqrt(
            np.einsum("ij,ij->i", scaled, np.linalg.solve(self.hessian, scaled.T).T)
        )
        self.rows = np.ascontiguousarray(scaled / self.norm[:, None])

    def judge(self, status: Status, z: np.ndarray, call: Call) -> None:
        linear = np.asarray(call.inputs["linear"]) * self.unit
        low = np.asarray(call.inputs["low"]) / self.norm
        high = np.asarray(call.inputs["high"]) / self.norm
        sense = np.zeros(low.size, dtype=np.int32)
        _, cost, flag, info = daqp.solve(
            self.hessian, linear, self.rows, high, low, sense, primal_tol=1e-10
        )
        if status is Status.OK:
            own = z / self.unit
            at = self.rows @ own
            assert np.max(np.maximum(at - high, low - at)) <= 1e-8
            if flag == 1:
                mine = 0.5 * own @ self.hessian @ own + linear @ own
                # a bound passed by what is accepted costs that times its multiplier
                spent = 1e-8 * float(np.sum(np.abs(info["lam"])))
                assert abs(mine - cost) <= 1e-9 * (1.0 + abs(cost)) + spent
        elif status is Status.INFEASIBLE:
            assert flag != 1, (status, flag)
