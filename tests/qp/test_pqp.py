"""PQP against exact solvers, and what (20) promises of the dual."""

from __future__ import annotations

from typing import NamedTuple

import casadi
import daqp
import numpy as np
import pytest
from core_designs import Variant, design
from core_loop import run, zigzag
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Status
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.precision import FLOAT32, FLOAT64
from servogen.qp.pqp import (
    TOGETHER,
    _coordinate,
    _majorant,
    pqp_tables,
    shift_duals,
    solve,
)
from servogen.qp.row_tables import column_rows
from servogen.qp.tolerances import MINIMUM_MARGIN, QpTolerances, tolerances

Array = np.ndarray
DOUBLE = np.dtype("float64")
TOL = QpTolerances(margin=1e-6, accept=9e-7, gap=1e-5)
EXAMPLES = settings(derandomize=True, deadline=None, max_examples=30)


def random_program(seed: int):
    """H, f, A, low, high with a point well inside; about half of the optima lie on a bound."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 7)), int(rng.integers(1, 13))
    root = rng.normal(size=(n, n))
    hessian = root @ root.T + 0.3 * np.eye(n)
    rows = rng.normal(size=(m, n))
    inside = rng.normal(size=n)
    low = rows @ inside - rng.uniform(0.1, 1.0, m)
    high = rows @ inside + rng.uniform(0.1, 1.0, m)
    return hessian, 3.0 * rng.normal(size=n), rows, low, high


def exact(hessian, f, rows, low, high):
    z, value, flag, _ = daqp.solve(
        np.ascontiguousarray(hessian), f, np.ascontiguousarray(rows), high, low,
        primal_tol=1e-10, dual_tol=1e-12,
    )  # fmt: skip
    assert flag == 1
    return z, value


def objective(hessian, f, z):
    return 0.5 * z @ hessian @ z + f @ z


def tables_of(hessian, rows, phi, period, cap, tol, dtype=DOUBLE):
    """The first rows are taken for steps of one row each: those of four share a column."""
    steps = max(len(rows) - 2, 0)
    return pqp_tables(
        hessian, rows, column_rows(rows, dtype), phi, period, cap, tol, dtype, 1, steps
    )


def prepare(program, period, cap, tol=TOL):
    hessian, f, rows, low, high = program
    tables = tables_of(hessian, rows, 0.1, period, cap, tol)
    free = -np.linalg.solve(hessian, f)
    upper_slack = (high - tol.margin) - rows @ free
    lower_slack = rows @ free - (low + tol.margin)
    return tables, free, upper_slack, lower_slack


def dual_value(program, upper, lower):
    """1/2 y'Q_d y + F_d'y of the tightened program."""
    hessian, _, rows, _, _ = program
    _, _, up, down = prepare(program, 0, 1)
    d = upper - lower
    return 0.5 * d @ (rows @ np.linalg.solve(hessian, rows.T)) @ d + up @ upper + down @ lower


@EXAMPLES
@given(seed=st.integers(0, 10**6), period=st.sampled_from([0, 1, 2, 3, 6]))
def test_objective_lies_within_the_gap_and_bounds_are_kept(seed, period):
    program = random_program(seed)
    hessian, f, rows, low, high = program
    tables, free, up, down = prepare(program, period, 20000)
    result = solve(tables, TOL, up, down, tables.floor, tables.floor)
    assert result.feasible
    assert result.converged
    z = free - result.correction
    assert np.all(rows @ z <= high)
    assert np.all(rows @ z >= low)
    value = objective(hessian, f, z)
    _, best = exact(*program)
    _, tightened = exact(hessian, f, rows, low + TOL.margin, high - TOL.margin)
    assert best - 1e-9 <= value <= tightened + TOL.gap + 1e-9


@EXAMPLES
@given(seed=st.integers(0, 10**6), phi=st.sampled_from([1e-3, 0.1, 2.0]))
def test_plain_pqp_never_raises_the_dual(seed, phi):
    program = random_program(seed)
    hessian, _, rows, _, _ = program
    rng = np.random.default_rng(seed)
    _, _, up, down = prepare(program, 0, 1)
    m = up.size
    upper, lower = 10.0 ** rng.uniform(-14.0, 0.5, (2, m))
    never = QpTolerances(margin=1e-6, accept=-1e9, gap=-1.0)  # so that no iterate ends it
    tables = tables_of(hessian, rows, phi, 0, 2, never)
    value = dual_value(program, upper, lower)
    for _ in range(60):
        after = solve(tables, never, up, down, upper, lower)
        upper, lower = after.upper, after.lower
        following = dual_value(program, upper, lower)
        assert following <= value + 1e-10 * (1.0 + abs(value))
        value = following
    assert np.all(upper > 0)
    assert np.all(lower > 0)


@EXAMPLES
@given(seed=st.integers(0, 10**6), per_step=st.integers(0, 3))
def test_what_stands_for_the_absolute_product_is_never_less(seed, per_step):
    hessian, _, rows, _, _ = random_program(seed)
    rng, m = np.random.default_rng(seed), len(rows)
    steps = m // per_step if per_step else 0
    tables = pqp_tables(
        hessian, rows, column_rows(rows, DOUBLE), 0.1, 6, 2, TOL, DOUBLE, per_step, steps
    )
    assert len(tables.columns) == m - (TOGETHER - 1) * per_step * (steps // TOGETHER)
    duals = rng.uniform(0.0, 1.0, (2, m)) * (rng.random(m) < 0.5)
    absolute = np.abs(rows @ np.linalg.solve(hessian, rows.T))
    bound = _majorant(tables, *duals)
    raised = np.maximum(duals[0] + duals[1], 2 * tables.floor)
    assert np.all(bound >= absolute @ raised * (1 - 1e-12))
    if steps < TOGETHER:
        assert np.allclose(bound, absolute @ raised, rtol=1e-12, atol=0.0)
    # a row alone above its floor gets of itself what |D| gives
    at_floor = _majorant(tables, tables.floor, tables.floor)
    assert np.allclose(at_floor, tables.at_floor, rtol=1e-12, atol=0.0)
    for i in range(m):
        alone = tables.floor.copy()
        alone[i] += 1.0
        assert np.isclose(
            _majorant(tables, alone, tables.floor)[i] - at_floor[i], absolute[i, i], rtol=1e-9
        )


@EXAMPLES
@given(seed=st.integers(0, 10**6))
def test_a_coordinate_turn_is_the_exact_minimum_along_its_dual(seed):
    hessian, _, rows, _, _ = program = random_program(seed)
    rng = np.random.default_rng(seed)
    tables, _, up, down = prepare(program, 6, 2)
    m = up.size
    upper, lower = rng.uniform(0.0, 0.1, m), rng.uniform(0.0, 0.1, m)
    change = rows @ np.linalg.solve(hessian, rows.T @ (upper - lower))
    slacks = np.stack([up + change, down - change], axis=1).ravel()
    worst = int(np.argmin(slacks))
    assume(slacks[worst] < 0.0)  # where none is violated, there is no such turn
    new_upper, new_lower = _coordinate(tables, upper, lower, slacks, worst)
    value = dual_value(program, new_upper, new_lower)
    assert value < dual_value(program, upper, lower)
    for step in (-1e-4, 1e-4):
        near_upper, near_lower = new_upper.copy(), new_lower.copy()
        (near_upper if worst % 2 == 0 else near_lower)[worst // 2] += step
        assert dual_value(program, near_upper, near_lower) > value


class LoopProgram(NamedTuple):
    """A program of a closed loop with tightened bounds, and what PQP's step made of it: the plan
    and what it would be shifted, both from the present position on."""

    mpc: TrackingMpc
    f: Array
    low: Array
    high: Array
    plan: Array
    shifted: Array
    status: Status
    iterations: int


def closed_loop_programs(letter: str, periods: int) -> list[LoopProgram]:
    """Of every active step of a closed loop."""
    v = Variant(letter=letter)
    cascade = Cascade(design(v))
    found = []
    for mpc in cascade.mpc:
        plain = mpc.step

        def watched(state, reference, low, high, mpc=mpc, plain=plain):
            shifted = np.append(mpc.plan[1:], reference[-1]) - state[0]
            status, command, iterations = plain(state, reference, low, high)
            if iterations:
                qp, rest = mpc.design.qp, state[1:]
                relative = reference - state[0]
                below, above = mpc._bounds(state[0], relative, low, high)
                offset = qp.rows_state @ rest
                f = qp.gradient_state @ rest + qp.gradient_reference @ relative
                bounds, plan = (below - offset, above - offset), mpc.plan - state[0]
                found.append(LoopProgram(mpc, f, *bounds, plan, shifted, status, iterations))
            return status, command, iterations

        mpc.step = watched
    run(cascade, v, zigzag(), periods)
    return found


# No iteration has a bound that it always keeps: of these loops' programs, by index, those that meet
# the cap. Another one is to be looked at.
CAPPED = {"B": (), "H": (), "L": (7, 45)}


@pytest.mark.parametrize("letter", ["B", "H", "L"])
def test_closed_loop_programs_against_daqp(letter):
    """On the loop's own programs: feasible for the true bounds, and as good as the gap says; at the
    cap the last plan, shifted, which is feasible too."""
    programs = closed_loop_programs(letter, 60)
    assert len(programs) >= 5
    worst, capped = 0.0, set()
    for i, program in enumerate(programs):
        mpc, f, low, high, plan = program[:5]
        qp, tol = mpc.design.qp, mpc.design.tol
        rows = qp.rows_command @ plan
        assert np.all(rows <= high + tol.margin)
        assert np.all(rows >= low - tol.margin)
        if program.status is not Status.OK:
            assert program.status is Status.BACKUP
            assert program.iterations == mpc.design.solver.cap
            assert np.array_equal(plan, program.shifted)
            capped.add(i)
            continue
        assert program.status is Status.OK
        z, best = exact(qp.hessian, f, qp.rows_command, low, high)
        scale = np.max(np.diag(qp.hessian)) * mpc.design.limits.fast_range_m**2
        assert objective(qp.hessian, f, plan) <= best + tol.gap + 1e-9 * scale
        worst = max(worst, abs(plan[0] - z[0]))
    assert capped <= set(CAPPED[letter])
    assert worst <= 0.35e-3  # the gap stands for sqrt(1e-4) of 35 mm in one command


def test_closed_loop_programs_against_qpoases():
    programs = closed_loop_programs("L", 40)[::4]
    assert len(programs) >= 3
    qp = programs[0].mpc.design.qp
    shape = {"h": casadi.DM(qp.hessian).sparsity(), "a": casadi.DM(qp.rows_command).sparsity()}
    solver = casadi.conic("oracle", "qpoases", shape, {"printLevel": "none"})
    for mpc, f, low, high, plan, *_ in programs:
        answer = solver(h=qp.hessian, g=f, a=qp.rows_command, lba=low, uba=high)
        best = float(answer["cost"])
        z, value = exact(qp.hessian, f, qp.rows_command, low, high)
        assert np.isclose(best, value, rtol=1e-6, atol=1e-9)
        assert np.allclose(np.array(answer["x"]).ravel(), z, atol=1e-7)
        assert objective(qp.hessian, f, plan) <= best + mpc.design.tol.gap + 1e-6 * abs(best)


def test_shifted_duals_move_one_step_on():
    floor = np.full(11, 0.5)
    y = np.arange(11, dtype=float)  # three steps of three rows, two terminal rows
    ceiling = np.full(11, 20.0)
    assert list(shift_duals(y, 3, 2, floor, ceiling)) == [3, 4, 5, 6, 7, 8, 6, 7, 8, 9, 10]
    assert list(y) == list(range(11))
    assert list(shift_duals(np.zeros(11), 3, 2, floor, ceiling)) == [0.5] * 11
    assert list(shift_duals(np.arange(4.0), 3, 1, np.zeros(4), ceiling[:4])) == [0, 1, 2, 3]
    ceiling[0] = 2.5  # the row that a dual comes to may allow less than the one it comes from
    assert list(shift_duals(y, 3, 2, floor, ceiling)) == [2.5, 4, 5, 6, 7, 8, 6, 7, 8, 9, 10]


def test_an_infeasible_program_ends_at_the_cap_with_finite_duals():
    hessian, rows = np.eye(2), np.array([[1.0, 0.0], [1.0, 1e-3]])
    low, high = np.array([1.0, -1.0]), np.array([2.0, 0.5])  # z_1 >= 1 and z_1 <= 0.5 nearly
    program = (hessian, np.zeros(2), rows, low, high)
    for dtype in (DOUBLE, np.dtype("float32")):
        tables = tables_of(hessian, rows, 0.1, 6, 300, TOL, dtype)
        _, _, up, down = prepare(program, 6, 300)
        result = solve(
            tables, TOL, up.astype(dtype), down.astype(dtype), tables.floor, tables.floor
        )
        assert not result.feasible
        assert result.iterations == 300
        assert np.all(np.isfinite(result.upper))
        assert np.max(result.upper * tables.diagonal) <= TOL.ceiling * (1 + 1e-6)


@pytest.mark.parametrize("period", [0, 6])
def test_the_cap_counts_evaluated_iterates(period):
    program = random_program(5)
    for cap in (1, 2, 7):
        tables, _, up, down = prepare(program, period, cap)
        result = solve(tables, TOL, up - 5.0, down - 5.0, tables.floor, tables.floor)
        assert result.iterations == cap


def test_tolerances_are_ordered_and_raised_to_the_precision():
    hessian = np.diag([2.0, 8.0])
    for precision in (FLOAT32, FLOAT64):
        for margin in (0.0, 1e-7, 1e-3):
            tol = tolerances(precision, margin, 1e-4, hessian, 0.035)
            assert tol.margin == max(margin, MINIMUM_MARGIN[precision.name])
            assert 0.0 < tol.accept < tol.margin
            assert tol.gap == pytest.approx(1e-4 * 0.5 * 8.0 * 0.035**2)
            assert tol.vanish < tol.floor < tol.ceiling
    assert MINIMUM_MARGIN["float32"] >= 1e-5


def test_margin_swallows_the_rounding_of_float32():
    """Accepted in float32: the true rows, computed in float64 from the rounded inputs, hold."""
    v = Variant(precision="float32", letter="L")
    cascade = Cascade(design(v))
    double = TrackingMpc(design(Variant(letter="L")).mpc[0])
    excess, active = [], 0
    for mpc in cascade.mpc:
        plain = mpc.step

        def watched(state, reference, low, high, mpc=mpc, plain=plain):
            nonlocal active
            status, command, iterations = plain(state, reference, low, high)
            if int(status) in (0, 3):
                active += iterations > 0
                x, r = state.astype(float), reference.astype(float)
                bounds = double._bounds(x[0], r - x[0], low.astype(float), high.astype(float))
                qp = double.design.qp
                rows = qp.rows_command @ (mpc.plan.astype(float) - x[0]) + qp.rows_state @ x[1:]
                margin = double.design.tol.margin
                excess.append(np.max(rows - bounds[1] - margin))
                excess.append(np.max(bounds[0] - margin - rows))
            return status, command, iterations

        mpc.step = watched
    run(cascade, v, zigzag(), 60)
    assert active >= 10
    assert max(excess) <= 0.0
