"""What OK and INFEASIBLE mean where rows nearly depend and z_unc is far away."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import daqp
import numpy as np
import pytest
from core_designs import temporary_folder
from near_programs import CAP, TURNS, Array, near_design, near_program
from scipy.optimize import linprog

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

ACCEPT = {"float64": 1e-10, "float32": 1e-6}
# In float32 some of these are refined more than once, 25, 187 and 242 among them.
OFTEN = (25, *range(180, 250))


def program(seed: int, precision: str) -> tuple[Array, Array, Iterator[tuple[Array, ...]]]:
    """H, A, and f, low, high in the precision: a point of size one keeps all rows to a rounding."""
    hessian, rows, turns = near_program(seed, precision)
    return hessian, rows, (turn[1:] for turn in turns)


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
        solver = QpSolver(near_design(seed, precision, ACCEPT[precision]))
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
        solver = QpSolver(near_design(seed, "float32", 1e-4))
        solver.call("reset")
        for side in program(seed, "float32")[2]:
            last = call(*side)
            assert solver.call(last.operation, last.inputs)[0] is not Status.INFEASIBLE, seed


# Of the first 160 those in which a multiplier meets what it is kept within before a row is lost.
FAR = (5, 56, 89, 99, 106, 153)


def far(seed: int) -> tuple[Array, Iterator[tuple[Array, ...]]]:
    """A and f, low, high in float32, H = I: z_unc is up to 1e9 away, and a point keeps all rows."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    m = int(rng.integers(n, 2 * n + 2))
    rows = rng.normal(size=(m, n))
    for i in range(1, m):
        if rng.random() < 0.6:
            other = rows[rng.integers(0, i)] * rng.choice([-1, 1])
            rows[i] = other + 10 ** rng.uniform(-6, -0.5) * rng.normal(size=n)

    def sides() -> Iterator[tuple[Array, ...]]:
        for _ in range(TURNS):
            size = 10.0 ** rng.uniform(0, 9)
            point = rng.normal(size=n) * 10.0 ** rng.uniform(-1, 8)
            if np.abs(point).max() > size:
                point = rng.normal(size=n)
            linear, width = rng.normal(size=n) * size, 10.0 ** rng.uniform(-3, 6, m)
            part, middle = rng.random(m), rows @ point
            low, high = middle - width * part, middle + width * (1.0 - part)
            yield tuple(np.clip(x, -9e8, 9e8).astype(np.float32) for x in (linear, low, high))

    return rows, sides()


def made_far(seed: int) -> QpSolverDesign:
    rows = far(seed)[0]
    return design_qp_solver(
        f"far_{seed}", PRECISIONS["float32"], np.eye(rows.shape[1]), rows, CAP, 1e-4
    )


def test_a_multiplier_that_met_its_limit_leaves_doubt() -> None:
    """Each of these has a program that would be called infeasible by what the moves seem to be."""
    for seed in FAR:
        solver, real = QpSolver(made_far(seed)), np.float32
        solver.call("reset")
        for linear, low, high in far(seed)[1]:
            best = linprog(
                np.zeros(solver.z.size),
                np.vstack([far(seed)[0], -far(seed)[0]]).astype(real).astype(float),
                np.concatenate([high, -low]).astype(float),
                bounds=(None, None),
            )
            status = solver.call("step", call(linear, low, high).inputs)[0]
            assert status is not Status.INFEASIBLE or best.status == 2, seed


def test_what_rounding_does_not_let_hold_is_no_beginning_for_another_program() -> None:
    """The set of this program's answer stalls when it is asked again; the next time it is anew."""
    solver = QpSolver(near_design(285, "float32", 1e-6))
    solver.call("reset")
    given = [call(*side) for side in program(285, "float32")[2]][:9]
    for each in given:
        solver.call(each.operation, each.inputs)
    found = [solver.call("step", given[-1].inputs)[0] for _ in range(6)]
    assert Status.BACKUP in found, "nothing stalls any more: another program"
    for now, following in pairwise(found):
        assert Status.OK in (now, following)


def test_c_is_the_reference_bit_for_bit() -> None:
    """With programs that are refined often, that stall, and such that leave doubt."""
    sides = {
        f"near_{seed}": program(seed, "float32")[2] for seed in (25, 187, 242, 22, 45, 128, 285)
    }
    sides |= {f"far_{seed}": far(seed)[1] for seed in FAR}
    chosen = [near_design(seed, "float32", 1e-6) for seed in (25, 187, 242, 285)]
    chosen += [near_design(seed, "float32", 1e-4) for seed in (22, 45, 128)]
    chosen += [made_far(seed) for seed in FAR]
    package = emit_package("near", tuple(declare_qp_solver(design) for design in chosen))
    module = compile_package([package], temporary_folder("near"), ("-O0",))
    for design in chosen:
        given = [Call("reset", {}), *(call(*side) for side in sides[design.prefix])]
        given += [given[-2]] * 4
        own = CompiledController(module, declare_qp_solver(design))
        agreement = compare(QpSolver(design), own, given)
        assert agreement.passed, (design.prefix, agreement.difference)
        assert agreement.worst == 0.0
