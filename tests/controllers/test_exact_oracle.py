"""The bundled example under PQP (the C) against the same loop with every program solved exactly."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import daqp
import numpy as np
import pytest
from core_designs import LIMITS, Variant, compiled, design, package
from core_loop import run

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Status
from servogen.project import load_project
from servogen.sil.compiled import CompiledController
from servogen.systems.judgement import check_project

EXAMPLE = Path(__file__).parents[2] / "examples" / "two_stage" / "servogen.toml"


@cache
def example_path() -> np.ndarray:
    return check_project(load_project(EXAMPLE)).timed.points


def with_exact_solver(cascade: Cascade) -> Cascade:
    """Every axis solves its tightened program by DAQP; an infeasible one is an error here."""
    for mpc in cascade.mpc:
        qp = mpc.design.qp
        hessian, matrix = np.ascontiguousarray(qp.hessian), np.ascontiguousarray(qp.rows_command)

        def exact(state, reference, low, high, mpc=mpc, qp=qp, hessian=hessian, matrix=matrix):
            origin, rest, relative = state[0], state[1:], reference - state[0]
            below, above = mpc._bounds(origin, relative, low, high)
            offset = qp.rows_state @ rest
            f = qp.gradient_state @ rest + qp.gradient_reference @ relative
            z, _, flag, _ = daqp.solve(
                hessian, f, matrix, above - offset, below - offset, primal_tol=1e-9
            )
            assert flag == 1
            mpc._accept(state, z + origin)
            return Status.OK, mpc.plan[0], 1

        mpc.step = exact
    return cascade


@cache
def exact_run(letter: str):
    v = Variant(letter=letter)
    return run(with_exact_solver(Cascade(design(v))), v, example_path())


# 116 is the cap that the example's target allows, 500 the paper's
@pytest.mark.parametrize("cap", [116, 500])
@pytest.mark.parametrize(
    ("letter", "at_most"),
    [
        pytest.param(letter, most, marks=pytest.mark.xdist_group(f"exact {letter}"))  # solved once
        for letter, most in (("B", 1.10), ("H", 1.045), ("L", 1.25))
    ],
)
def test_pqp_costs_no_time_against_the_exact_solution(letter, at_most, cap):
    v = Variant(prefix=f"oracle_{letter.lower()}_{cap}", letter=letter, cap=cap)
    path = example_path()
    exact = exact_run(letter)
    declaration = package(v).declarations[-1]
    loop = run(CompiledController(compiled(v, quick=True), declaration), v, path)
    assert exact.complete
    assert loop.complete
    assert loop.begun == exact.begun == len(path) - 1
    assert abs(len(loop.status) - len(exact.status)) <= 0.002 * len(exact.status)
    assert (len(loop.status) - 1) * 150 <= at_most * (len(path) - 1)
    statuses = [Status(o[f"status_{a}"]) for o in loop.outputs for a in "xy"]
    degraded = sum(s in (Status.BACKUP, Status.INFEASIBLE) for s in statuses)
    assert degraded <= 0.01 * len(statuses)
    for column, limit in (
        (0, LIMITS.position_m),
        (1, LIMITS.velocity_m_per_s),
        (2, LIMITS.acceleration_m_per_s2),
    ):
        assert np.max(np.abs(loop.state[:, :, column])) <= limit + 1e-9
