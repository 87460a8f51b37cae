"""Programs of the tests: the servo drive of paper 5, double integrators, published examples."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from servogen.plants.statespace import FloatArray
from servogen.qp.parametric import ParametricQP, parameter_box, parametric_qp

LIMIT_MA = 1000.0


def servo_drive(moves: int, trajectory: int = 3, inside_box: bool = False) -> ParametricQP:
    """Paper 5's tracking program in absolute currents u_0.. (mA), input bounds alone.

    Parameters, relative to the present output: increments of motor and load speed (rad/s) and of
    motor and load angle (rad), the previous current (mA), the references r(1..H_t) - y (deg).
    H_p = 50, R = 1, Q = 1e6, first-order hold, moves = H_u.
    """
    a, b = two_mass()
    horizon = 50
    c = np.array([[0.0, 0.0, 180.0 / np.pi, 0.0]])  # the motor's angle
    big_a = np.block([[a, np.zeros((4, 1))], [c @ a, np.eye(1)]])
    big_b = np.vstack([b, c @ b])
    psi, theta = np.zeros((horizon, 5)), np.zeros((horizon, moves))
    power = np.eye(5)
    response = []
    for i in range(horizon):
        response.append(float((power @ big_b)[4, 0]))
        power = power @ big_a
        psi[i] = power[4]
        for j in range(min(i + 1, moves)):
            theta[i, j] = response[i - j]
    hold = np.zeros((horizon, trajectory))
    for i in range(1, horizon + 1):
        if i < trajectory:
            hold[i - 1, i - 1] = 1.0
        elif trajectory == 1:
            hold[i - 1, 0] = 1.0
        else:  # r(H_t - 1) + (i - H_t + 1) (r(H_t) - r(H_t - 1))
            hold[i - 1, trajectory - 2] = trajectory - i
            hold[i - 1, trajectory - 1] = i - trajectory + 1
    difference = np.eye(moves) - np.eye(moves, k=-1)  # increments of the currents
    first = np.zeros((moves, 1))
    first[0] = -1.0  # the first increment counts from the previous current
    free = np.hstack([psi[:, :4], np.zeros((horizon, 1)), -hold])  # y cancels: relative references
    on_u = theta @ difference
    free = free + theta @ np.hstack([np.zeros((moves, 4)), first, np.zeros((moves, trajectory))])
    hessian = 2.0 * difference.T @ difference + 2e6 * on_u.T @ on_u
    linear = 2e6 * on_u.T @ free
    linear[:, 4] += 2.0 * (difference.T @ first)[:, 0]
    domain: dict[str, FloatArray] = {}
    if inside_box:
        # speeds differences within 100 rad/s, angle differences within pi, output and references
        # within 180 deg (so 360 relative), previous current within its limit
        half = np.array([100.0, 100.0, np.pi, np.pi, LIMIT_MA] + [360.0] * trajectory)
        rows, bounds = parameter_box(-half, half)
        domain = {"domain_rows": rows, "domain_bounds": bounds}
    limit = np.full(moves, LIMIT_MA)
    return parametric_qp(hessian, linear, lower=-limit, upper=limit, **domain)


def two_mass(sample_time_s: float = 500e-6) -> tuple[FloatArray, FloatArray]:
    """Exact zero-order hold of the two-mass model that rounds to paper 5's printed matrices."""
    k, rho, c, b_m, b_l, g = 5.95e6, 0.285, 48.0, 1.0, 1.0, 0.2254
    a = np.array(
        [
            [-(c + b_m), c, -k, k],
            [rho * c, -(rho * c + b_l), rho * k, -rho * k],
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
        ]
    )
    whole = np.zeros((5, 5))
    whole[:4, :4], whole[0, 4] = a, g
    held = scipy.linalg.expm(whole * sample_time_s)
    return held[:4, :4], held[:4, 4:]


def condensed(
    a: FloatArray,
    b: FloatArray,
    q: FloatArray,
    r: FloatArray,
    p: FloatArray,
    horizon: int,
    u_limit: FloatArray,
    state_rows: FloatArray | None = None,
    state_bounds: FloatArray | None = None,
    terminal_rows: FloatArray | None = None,
    terminal_bounds: FloatArray | None = None,
    first_limited: int = 1,
    last_limited: int | None = None,
    domain: tuple[FloatArray, FloatArray] | None = None,
) -> ParametricQP:
    """Linear-quadratic regulation of x+ = a x + b u from x_0 = theta, |u| <= u_limit.

    State rows hold at samples ``first_limited``..``last_limited`` (the horizon's end), terminal
    rows at the end.
    """
    n, m = b.shape
    powers = [np.linalg.matrix_power(a, i) for i in range(horizon + 1)]
    on_u = np.zeros((horizon + 1, n, horizon * m))
    for i in range(1, horizon + 1):
        for j in range(i):
            on_u[i, :, j * m : (j + 1) * m] = powers[i - 1 - j] @ b
    hessian = np.kron(np.eye(horizon), r)
    linear = np.zeros((horizon * m, n))
    for i in range(1, horizon + 1):
        weight = p if i == horizon else q
        hessian = hessian + on_u[i].T @ weight @ on_u[i]
        linear = linear + on_u[i].T @ weight @ powers[i]
    rows, bounds, shift = [], [], []
    last = horizon if last_limited is None else last_limited
    if state_rows is not None and state_bounds is not None:
        for i in range(first_limited, last + 1):
            rows.append(state_rows @ on_u[i])
            bounds.append(state_bounds)
            shift.append(-state_rows @ powers[i])
    if terminal_rows is not None and terminal_bounds is not None:
        rows.append(terminal_rows @ on_u[horizon])
        bounds.append(terminal_bounds)
        shift.append(-terminal_rows @ powers[horizon])
    limit = np.tile(u_limit, horizon)
    given: dict[str, FloatArray] = {}
    if rows:
        given = {
            "rows": np.vstack(rows),
            "bounds": np.concatenate(bounds),
            "bounds_parameter": np.vstack(shift),
        }
    if domain is not None:
        given["domain_rows"], given["domain_bounds"] = domain
    return parametric_qp(hessian, linear, lower=-limit, upper=limit, first_move=m, **given)


def double_integrator(horizon: int, position: float = 5.0, velocity: float = 5.0) -> ParametricQP:
    """MPT's manual: x+ = [1 1; 0 1] x + [1; 0.5] u, Q = I, R = 1, |u| <= 1, |x_i| limited.

    The limits hold at x_0..x_{N-1}: those of x_0 are the parameters' domain.
    """
    a, b = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1.0], [0.5]])
    eye = np.eye(2)
    rows, bounds = np.vstack([eye, -eye]), np.array([position, velocity] * 2)
    return condensed(
        a, b, eye, np.eye(1), eye * 0.0, horizon, np.array([1.0]), rows, bounds,
        last_limited=horizon, domain=(rows, bounds),
    )  # fmt: skip


def random_program(
    seed: int, variables: int, parameters: int, rows: int, first_move: int = 1
) -> ParametricQP:
    """Feasible at theta = 0; theta within +-2, |z_i| <= 3, ``rows`` random limits on both."""
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(variables, variables))
    return parametric_qp(
        root @ root.T + 0.3 * np.eye(variables),
        generator.normal(size=(variables, parameters)),
        constant=0.3 * generator.normal(size=variables),
        rows=generator.normal(size=(rows, variables)),
        bounds=generator.uniform(0.3, 1.5, rows),
        bounds_parameter=0.5 * generator.normal(size=(rows, parameters)),
        lower=np.full(variables, -3.0),
        upper=np.full(variables, 3.0),
        domain_rows=np.vstack([np.eye(parameters), -np.eye(parameters)]),
        domain_bounds=np.full(2 * parameters, 2.0),
        first_move=first_move,
    )


def regulator_2002() -> ParametricQP:
    """Example 7.1 of Bemporad, Morari, Dua and Pistikopoulos, Automatica 38 (2002) 3-20.

    H and F as printed there, N_u = 2, |u| <= 2, theta the state.
    """
    hessian = np.array([[1.5064, 0.4838], [0.4838, 1.5258]])
    linear = np.array([[9.6652, 7.0732], [5.2115, -7.0879]])
    return parametric_qp(hessian, linear, lower=[-2.0, -2.0], upper=[2.0, 2.0])


def toolbox_double_integrator() -> ParametricQP:
    """The double integrator of the Model Predictive Control Toolbox's explicit MPC pages.

    1/s^2 at 0.1 s, horizons 10 and 3, weights 1 on the output and 0.1 on the input's rate (both
    squared), |u| <= 1; parameters: the states within 10, the previous input within 1.1 and the
    reference within 2.
    """
    time, horizon, moves, weight = 0.1, 10, 3, 0.1**2
    a, b = np.array([[1.0, 0.0], [time, 1.0]]), np.array([[time], [0.5 * time**2]])
    c = np.array([[0.0, 1.0]])
    psi, theta = np.zeros((horizon, 2)), np.zeros((horizon, moves))
    for i in range(1, horizon + 1):
        psi[i - 1] = c @ np.linalg.matrix_power(a, i)
        for j in range(i):
            theta[i - 1, min(j, moves - 1)] += (c @ np.linalg.matrix_power(a, i - 1 - j) @ b)[0, 0]
    steps = np.eye(moves) - np.eye(moves, k=-1)
    previous = -weight * steps.T @ np.eye(moves)[:, :1]
    linear = np.hstack([theta.T @ psi, previous, -theta.T @ np.ones((horizon, 1))])
    half = np.array([10.0, 10.0, 1.1, 2.0])
    rows, bounds = parameter_box(-half, half)
    return parametric_qp(
        theta.T @ theta + weight * steps.T @ steps, linear, lower=-np.ones(moves),
        upper=np.ones(moves), domain_rows=rows, domain_bounds=bounds,
    )  # fmt: skip


def transport() -> ParametricQP:
    """The transport problem of PPOPT's tutorial, from Pistikopoulos, Diangelakis and Oberdieck,
    Multi-parametric Optimization and Control (2020): two plants, two markets of unknown demand.
    """
    eye = np.eye(4)
    rows = np.array([[1, 1, 0, 0], [0, 0, 1, 1], [-1, 0, -1, 0], [0, -1, 0, -1]], dtype=float)
    shift = np.zeros((8, 2))
    shift[2, 0] = shift[3, 1] = -1.0
    domain_rows, domain_bounds = parameter_box([0.0, 0.0], [1000.0, 1000.0])
    return parametric_qp(
        2.0 * np.diag([153.0, 162.0, 162.0, 126.0]), np.zeros((4, 2)), constant=np.full(4, 25.0),
        rows=np.vstack([rows, -eye]), bounds=np.array([350.0, 600.0] + [0.0] * 6),
        bounds_parameter=shift, domain_rows=domain_rows, domain_bounds=domain_bounds,
    )  # fmt: skip
