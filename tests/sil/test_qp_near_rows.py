"""What OK and INFEASIBLE mean where rows nearly depend and z_unc is far away."""

from __future__ import annotations

from collections.abc import Iterator

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
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, compare

Array = np.ndarray
CAP = 200
# Powers of ten: H's eigenvalues, and by how much a row stands off from another one.
WORST = {"float64": 11.0, "float32": 3.5}
APART = {"float64": (-5.0, -1.0), "float32": (-3.0, -0.5)}
ACCEPT = {"float64": 1e-10, "float32": 1e-6}
TURNS = 10
# In float32 some of these are refined more than once: 25, 187 and 242.
OFTEN = (25, *range(180, 250))


def program(seed: int, precision: str) -> tuple[Array, Array, Iterator[tuple[Array, ...]]]:
    """H, A, and f, low, high in the precision: a point of size one keeps all rows to a rounding."""
    rng = np.random.default_rng(seed)
    real = PRECISIONS[precision].dtype
    n = int(rng.integers(2, 12))
    m = int(rng.integers(n, 3 * n + 1))
    worst = rng.uniform(0.0, WORST[precision])
    base = np.linalg.qr(rng.normal(size=(n, n)))[0]
    values = 10.0 ** rng.uniform(-worst, 0.0, n)
    values[0], values[-1] = 1.0, 10.0**-worst
    hessian = (base * values) @ base.T
    hessian = 0.5 * (hessian + hessian.T)
    rows = rng.normal(size=(m, n))
    for i in range(1, m):
        if rng.random() < 0.5:
            other = rows[int(rng.integers(0, i))] * rng.choice([-1, 1])
            rows[i] = other + 10.0 ** rng.uniform(*APART[precision]) * rng.normal(size=n)
    size = np.sqrt(np.einsum("ij,ij->i", rows, np.linalg.solve(hessian, rows.T).T))

    def sides() -> Iterator[tuple[Array, ...]]:
        for _ in range(TURNS):
            point = rng.normal(size=n)
            linear = -hessian @ (rng.normal(size=n) * 10.0 ** rng.uniform(-1.0, 3.0))
            width = 10.0 ** rng.uniform(-3.0, 1.0, m) * size * (rng.random(m) > 0.1)
            part, middle = rng.random(m), rows @ point
            low, high = middle - width * part, middle + width * (1.0 - part)
            yield tuple(x.astype(real) for x in (linear, low, high))

    return hessian, rows, sides()


def made(seed: int, precision: str, accept: float) -> QpSolverDesign:
    hessian, rows, _ = program(seed, precision)
    return design_qp_solver(f"near_{seed}", PRECISIONS[precision], hessian, rows, CAP, accept)


def call(linear: Array, low: Array, high: Array) -> Call:
    return Call("step", {"linear": linear, "low": low, "high": high})


def beside(solver: QpSolver, low: Array, high: Array) -> float:
    """What the rows of the set are beside their bounds, on either side, as the method sees it."""
    design, work = solver.design, solver.work
    rows = design.tables.rows.product(solver.z)
    low, high = low * design.scale, high * design.scale
    own = zip(work.row[: work.size], work.side[: work.size], strict=True)
    return max((abs(rows[i] - (high[i] if side > 0 else low[i])) for i, side in own), default=0.0)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_every_row_of_the_set_is_at_its_bound(precision: str) -> None:
    """And the error is what that leaves: with e = z - z*, d what z is off from z_unc - V lambda and
    a what rows pass their bounds by or rows of the set stay beside them,
    |e|_H^2 <= a (sum lambda + sum lambda*) + |e|_H |d|_H."""
    found = 0
    for seed in OFTEN:
        hessian, rows, sides = program(seed, precision)
        root = np.linalg.cholesky(hessian).T
        solver = QpSolver(made(seed, precision, ACCEPT[precision]))
        solver.call("reset")
        scale = solver.design.scale.astype(float)
        unit = rows * scale[:, None]
        for linear, low, high in sides:
            last = call(linear, low, high)
            if solver.call(last.operation, last.inputs)[0] is not Status.OK or not solver.work.size:
                continue
            assert beside(solver, low, high) <= ACCEPT[precision], seed
            work, z = solver.work, solver.z.astype(float)
            dual = np.zeros(len(rows))
            dual[work.row[: work.size]] = work.dual[: work.size] * work.side[: work.size]
            best = daqp.solve(
                hessian, linear.astype(float), rows, high.astype(float), low.astype(float),
                np.zeros(len(rows), dtype=np.int32), primal_tol=1e-11, dual_tol=1e-12,
            )  # fmt: skip
            if best[2] != 1:
                continue
            found += 1
            off = root @ (z - np.linalg.solve(hessian, -linear.astype(float) - unit.T @ dual))
            error = root @ (z - best[0])
            size = np.linalg.norm(root @ z) + np.sum(np.abs(dual))
            rounding = 10.0 * float(np.finfo(PRECISIONS[precision].dtype).eps) * size
            both = np.sum(np.abs(dual)) + np.sum(np.abs(best[3]["lam"]) / scale)
            spent = (ACCEPT[precision] + rounding) * both
            assert error @ error <= spent + np.linalg.norm(error) * np.linalg.norm(off), seed
    assert found > 500


@pytest.mark.parametrize("seeds", [range(20, 60), range(120, 150)])
def test_far_moves_are_no_proof_that_there_is_no_point(seeds: range) -> None:
    """Multipliers of 1e6 and more in float32: what they leave of z is rounding."""
    for seed in seeds:
        solver = QpSolver(made(seed, "float32", 1e-4))
        solver.call("reset")
        for side in program(seed, "float32")[2]:
            last = call(*side)
            assert solver.call(last.operation, last.inputs)[0] is not Status.INFEASIBLE, seed


def test_c_is_the_reference_bit_for_bit() -> None:
    """With programs that are refined often, and such that leave doubt."""
    chosen = [made(seed, "float32", 1e-6) for seed in (25, 187, 242)]
    chosen += [made(seed, "float32", 1e-4) for seed in (22, 45, 128)]
    package = emit_package("near", tuple(declare_qp_solver(design) for design in chosen))
    module = compile_package([package], temporary_folder("near"), ("-O1",))
    for design in chosen:
        sides = program(int(design.prefix.removeprefix("near_")), "float32")[2]
        given = [Call("reset", {}), *(call(*side) for side in sides)]
        own = CompiledController(module, declare_qp_solver(design))
        agreement = compare(QpSolver(design), own, given)
        assert agreement.passed, (design.prefix, agreement.difference)
        assert agreement.worst == 0.0
