"""MPC problems that packages of the index ship: qpmpc's (Apache 2.0) and TinyMPC's (MIT).

qpbenchmark's package has the code of its test sets alone, without the problems of its MPC set; and
no other package was found to ship any.
"""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from qp.counted import PeerFailed
from qp.libraries import TINYMPC_VERSION
from qp.literature import Plant, closed_loop
from qp.sdist import sdist
from qp.sequence import Array, Sequence, solve_reference, two_sided


def _qpmpc() -> ModuleType:
    try:
        import qpmpc
        import qpmpc.systems
    except ImportError as missing:
        raise PeerFailed(f"not installed: {missing}") from missing
    return qpmpc


def _scaled(rows: Array, high: Array) -> tuple[Array, Array, Array]:
    """G z <= h as two-sided rows of size one: rows, low, high."""
    size = np.where(rows.any(axis=1), np.abs(rows).max(axis=1), 1.0)
    rows, high = rows / size[:, None], high / size
    first, second = two_sided(rows)
    return rows[first], -high[second], high[first]


def _recorded(name: str, source: str, programs: list[Any], per_step: int) -> Sequence:
    hessian, rows = programs[0][0], programs[0][1]
    linear, low, high = (np.array([program[k] for program in programs]) for k in (2, 3, 4))
    return Sequence(name, source, hessian, rows, linear, low, high, per_step, 0)


def pendulum(steps: int, horizon: int = 12) -> Sequence:
    """qpmpc's wheeled inverted pendulum with its own weights, horizon and nonlinear model."""
    library = _qpmpc()
    system = library.systems.WheeledInvertedPendulum(
        nb_timesteps=horizon, sampling_period=1.2 / horizon
    )
    problem = system.build_mpc_problem(
        terminal_cost_weight=10.0, stage_state_cost_weight=1.0, stage_input_cost_weight=1e-3
    )
    x, programs = np.zeros(4), []
    rng = np.random.default_rng(7)
    for t in range(steps):
        if t % 25 == 0:
            goal = np.array([rng.uniform(-8.0, 8.0), 0.0, 0.0, 0.0])
        problem.update_initial_state(x)
        problem.update_goal_state(goal)
        problem.update_target_states(np.tile(goal, horizon))
        qp = library.mpc_qp.MPCQP(problem)
        rows, low, high = _scaled(qp.G, qp.h)
        programs.append((qp.P, rows, qp.q.copy(), low, high))
        z, _ = solve_reference(qp.P, rows, qp.q, low, high)
        x = system.integrate(x, float(z[0]), system.sampling_period)
    source = f"wheeled inverted pendulum of qpmpc, horizon {horizon}, |acceleration| <= 10"
    return _recorded(f"qpmpc_pendulum_{horizon}", source, programs, 1)


def triple_integrator(steps: int) -> Sequence:
    """The example of qpmpc's manual, in closed loop from goal to goal."""
    library = _qpmpc()
    horizon = 16
    period = 1.0 / horizon
    a = np.array([[1.0, period, period**2 / 2.0], [0.0, 1.0, period], [0.0, 0.0, 1.0]])
    b = np.array([[period**3 / 6.0], [period**2 / 2.0], [period]])
    along = np.array([[0.0, 0.0, 1.0]])
    x, programs = np.zeros(3), []
    rng = np.random.default_rng(8)
    for t in range(steps):
        if t % 40 == 0:
            goal = np.array([rng.uniform(-1.5, 1.5), 0.0, 0.0])
        problem = library.MPCProblem(
            transition_state_matrix=a, transition_input_matrix=b,
            ineq_state_matrix=np.vstack([along, -along]), ineq_input_matrix=None,
            ineq_vector=np.array([3.0, 3.0]), initial_state=x, goal_state=goal,
            nb_timesteps=horizon, terminal_cost_weight=1.0, stage_state_cost_weight=None,
            stage_input_cost_weight=1e-6,
        )  # fmt: skip
        qp = library.mpc_qp.MPCQP(problem)
        rows, low, high = _scaled(qp.G, qp.h)
        programs.append((qp.P, rows, qp.q.copy(), low, high))
        z, _ = solve_reference(qp.P, rows, qp.q, low, high)
        x = a @ x + b[:, 0] * z[0]
    source = "triple integrator of qpmpc's manual, |acceleration| <= 3"
    return _recorded(f"qpmpc_triple_{horizon}", source, programs, 1)


def _numbers(text: str, name: str) -> Array:
    found = re.search(rf"{name}\b[^=]*=\s*\{{?([^;}}]*)", text)
    if found is None:
        raise PeerFailed(f"TinyMPC's example has no {name}")
    return np.array([float(word) for word in found[1].replace("\n", " ").split(",")])


def quadrotor(steps: int, folder: Path) -> Sequence:
    """TinyMPC's hovering quadrotor at 20 Hz: weights, penalty, horizon, boxes and start are its
    example's. The last weight is what its method makes of them."""
    source = sdist("tinympc", folder, TINYMPC_VERSION)
    text = (
        source / "tinympc" / "TinyMPC" / "examples" / "problem_data" / "quadrotor_20hz_params.hpp"
    ).read_text()
    plant = Plant(
        "quadrotor", "hovering quadrotor of TinyMPC's examples, 20 Hz, |u| <= 0.5, |x| <= 5",
        _numbers(text, "Adyn_data").reshape(12, 12), _numbers(text, "Bdyn_data").reshape(12, 4),
        np.eye(12), np.full(4, 0.5), np.full(12, 5.0),
        np.diag(_numbers(text, "Q_data")), np.diag(_numbers(text, "R_data")),
    )  # fmt: skip
    wanted = np.zeros(12)
    wanted[2] = 2.0
    start = np.array([0.0, 1.0, 0.0, 0.2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0])
    rho = float(_numbers(text, "rho_value")[0])
    return closed_loop(
        plant, 9, steps, lambda t: (wanted, np.zeros(4)), np.zeros((steps, 1)), rho, start
    )
