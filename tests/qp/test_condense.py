"""The condensed program against automatic derivatives of (16) as the paper writes it."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
import scipy.linalg
from core_designs import CALIBRATIONS, LIMITS, admissible, slow_stage

from servogen.plants.statespace import discretise
from servogen.qp.condense import (
    TrackingWeights,
    condense,
    lyapunov_excess,
    stage_cost,
    terminal_cost,
    terminal_pairs,
)
from servogen.sets.polyhedron import maximise

PERIOD = 0.03
CASES = [(3, 20, "B", 0, 1.0), (3, 3, "H", 2, 1.0), (4, 5, "L", 1, 3.0), (3, 1, "B", 0, 1.0)]


def build(order: int, horizon: int, letter: str, inter: int, factor: float):
    base = CALIBRATIONS[letter]
    weights = TrackingWeights(base.position, base.velocity, base.acceleration, base.command, factor)
    own = admissible(order, 45.0, LIMITS, inter)
    slow = slow_stage(order)
    return slow, weights, own, condense(slow, PERIOD, horizon, weights, LIMITS, own, inter)


def held(slow, time_s):
    """exp of the augmented matrix: the stage under a held command, by another road."""
    n = slow.order
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = slow.a * time_s, slow.b * time_s
    whole = scipy.linalg.expm(block)
    return whole[:n, :n], whole[:n, n]


@pytest.mark.parametrize("case", CASES)
def test_cost_is_the_unrolled_cost(case):
    slow, weights, _, qp = build(*case)
    horizon, n = case[1], slow.order
    q, r = stage_cost(n, weights, LIMITS)
    a, b = held(slow, PERIOD)
    p = q
    for _ in range(2000):
        p = q + a.T @ p @ a  # the sum that the Lyapunov equation stands for
    p = case[4] * p
    u = casadi.SX.sym("u", horizon)
    x0, reference = casadi.SX.sym("x0", n), casadi.SX.sym("r", horizon + 1)
    x, cost = x0, casadi.SX(0)
    for k in range(horizon):
        rest = casadi.vertcat(reference[k], casadi.SX.zeros(n - 1))
        cost += casadi.bilin(q, x - rest, x - rest) + r * (u[k] - reference[k]) ** 2
        x = a @ x + b * u[k]
    rest = casadi.vertcat(reference[horizon], casadi.SX.zeros(n - 1))
    cost += casadi.bilin(p, x - rest, x - rest)
    hessian, gradient = casadi.hessian(cost, u)
    function = casadi.Function("oracle", [u, x0, reference], [hessian, gradient])
    rng = np.random.default_rng(0)
    scale = np.max(np.abs(qp.hessian))
    for _ in range(5):
        start = rng.normal(size=n) * np.array([0.3, 0.5, 5.0, 100.0][:n])
        ahead = start[0] + 0.03 * rng.normal(size=horizon + 1)
        second, first = function(np.full(horizon, start[0]), start, ahead)  # at z = 0
        assert np.allclose(np.array(second), qp.hessian, rtol=0, atol=1e-10 * scale)
        expected = qp.gradient_state @ start[1:] + qp.gradient_reference @ (ahead - start[0])
        size = np.max(np.abs(expected)) + scale * 1e-3
        assert np.max(np.abs(np.array(first).ravel() - expected)) <= 1e-10 * size


@pytest.mark.parametrize("case", CASES)
def test_rows_are_the_outputs_along_the_horizon(case):
    slow, _, own, qp = build(*case)
    horizon, inter, n = case[1], case[3], slow.order
    rng = np.random.default_rng(1)
    start = rng.normal(size=n) * np.array([0.3, 0.5, 5.0, 100.0][:n])
    plan = start[0] + 0.05 * rng.normal(size=horizon)
    rows = []
    x = start
    maps = [held(slow, PERIOD * j / (inter + 1)) for j in range(1, inter + 2)]
    for k in range(horizon):
        inside = [a @ x + b * plan[k] for a, b in maps]
        x = inside[-1]
        rows += [
            (x[0] - start[0]) / LIMITS.fast_range_m,
            x[1] / LIMITS.velocity_m_per_s,
            x[2] / LIMITS.acceleration_m_per_s2,
        ]
        for between in inside[:-1]:
            rows += [
                between[1] / LIMITS.velocity_m_per_s,
                between[2] / LIMITS.acceleration_m_per_s2,
            ]
    got = qp.rows_command @ (plan - start[0]) + qp.rows_state @ start[1:]
    assert qp.rows_per_step == 3 + 2 * inter
    assert np.allclose(got[: len(rows)], rows, rtol=0, atol=1e-10)
    # terminal rows: h_x x_N + h_r r_N, whatever the terminal reference
    last = start[0] + 0.02
    h_x, h_r, bound = terminal_pairs(own, LIMITS)
    terminal = got[len(rows) :] + qp.terminal_reference * (last - start[0])
    terminal = terminal + qp.terminal_position * start[0]
    assert np.allclose(terminal, h_x @ x + h_r * last, rtol=0, atol=1e-10)
    assert qp.terminal_rows == h_r.size == bound.size


@pytest.mark.parametrize(("order", "inter"), [(3, 0), (3, 2), (4, 0)])
def test_dropped_terminal_rows_are_implied_and_kept_ones_are_not(order, inter):
    own = admissible(order, 45.0, LIMITS, inter)
    h_x, h_r, bound = terminal_pairs(own, LIMITS)
    n = order
    stage = np.zeros((5, n + 1))
    stage[0, 0] = 1.0 / LIMITS.position_m
    stage[1, 1] = 1.0 / LIMITS.velocity_m_per_s
    stage[2, 2] = 1.0 / LIMITS.acceleration_m_per_s2
    stage[3, [0, n]] = 1.0 / LIMITS.fast_range_m, -1.0 / LIMITS.fast_range_m
    stage[4, n] = 1.0 / ((1.0 - own.tightening) * LIMITS.position_m)  # what the governor kept
    kept = np.hstack([h_x, h_r[:, None]]) / bound[:, None]
    rows = np.vstack([stage, kept])
    whole = np.hstack([own.h_x, own.h_r[:, None]]) / own.k[:, None]
    both = np.vstack([rows, -rows])
    for row in whole:
        assert maximise(both, np.ones(len(both)), row).value <= 1.0 + 1e-8
    for i in range(len(kept)):
        others = np.vstack([stage, np.delete(kept, i, axis=0)])
        both_others = np.vstack([others, -others])
        assert maximise(both_others, np.ones(len(both_others)), kept[i]).value > 1.0 + 1e-8
    assert 0 < len(kept) < len(whole) // 2


@pytest.mark.parametrize("factor", [1.0, 2.5])
@pytest.mark.parametrize("letter", ["B", "H", "L"])
@pytest.mark.parametrize("order", [3, 4, 5])
def test_terminal_cost_falls_by_the_stage_cost(order, letter, factor):
    """(17) with u = r: F(A x + B r, r) - F(x, r) + stage <= 0, equal for the Lyapunov solution."""
    plant = discretise(slow_stage(order), PERIOD)
    q, _ = stage_cost(order, CALIBRATIONS[letter], LIMITS)
    p = terminal_cost(plant, q, factor)
    assert np.array_equal(p, p.T)
    assert lyapunov_excess(plant, q, p) <= 1e-12
    rng = np.random.default_rng(2)
    for _ in range(50):
        r = rng.uniform(-0.4, 0.4)
        x = rng.normal(size=order) * 10.0 ** np.arange(order)
        rest = r * np.eye(order)[0]
        following = plant.a @ x + plant.b * r
        stage = (x - rest) @ q @ (x - rest)
        before = (x - rest) @ p @ (x - rest)
        after = (following - rest) @ p @ (following - rest)
        assert after - before + stage <= 1e-9 * before
        if factor == 1.0:
            assert abs(after - before + stage) <= 1e-9 * before


def test_too_small_a_terminal_cost_is_seen():
    plant = discretise(slow_stage(), PERIOD)
    q, _ = stage_cost(3, CALIBRATIONS["B"], LIMITS)
    p = terminal_cost(plant, q, 1.0)
    assert lyapunov_excess(plant, q, 0.9 * p) > 1e-6
