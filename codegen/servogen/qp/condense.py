"""Condensing of the tracking MPC (16) to the quadratic program (19), one axis.

Everything is written relative to the present position p: the slow stage has unit dc gain, so
moving position, references and commands by the same amount changes nothing but the position
limits. That drops the position from the parameters and keeps float32 accurate (a metre's worth of
offset would cost three digits of a millimetre).

Decision: z_k = u_k - p, k = 0..N-1. Parameters: the state without position x' = (v, a, ...), the
references relative to p, and the bounds of the rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import Discrete, StateSpace, discretise
from servogen.precision import FloatArray
from servogen.sets.admissible import AdmissibleSet
from servogen.sets.constraints import AxisLimits
from servogen.sets.polyhedron import pair_is_redundant

# 2^40 terms: a stable stage has long settled, and the power of A is zero to the last bit.
LYAPUNOV_DOUBLINGS = 40

# A Lyapunov solution leaves a residual of rounding size relative to P; this is far above it.
LYAPUNOV_TOLERANCE = 1e-9


@dataclass(frozen=True)
class TrackingWeights:
    """Weights of the stage cost (18); each divides a square by the square of its limit.

    Attributes:
        position, velocity, acceleration, command: on (p - r), v, a and (u - r).
        terminal_factor: >= 1, multiplies the Lyapunov solution; (17) holds for any such factor.
    """

    position: float
    velocity: float
    acceleration: float
    command: float
    terminal_factor: float = 1.0


@dataclass(frozen=True)
class CondensedQp:
    """min 1/2 z'Hz + f'z subject to low <= A z + E x' <= high, for one axis and horizon N.

    Attributes:
        hessian: (N, N).
        gradient_state: (N, n-1), f = gradient_state x' + gradient_reference (r - p).
        gradient_reference: (N, N+1), on r_0..r_N.
        rows_command: (m, N) = A; rows_state: (m, n-1) = E. Scaled: 1 is a limit.
        rows_per_step: rows of each step: position first, then velocity and acceleration at the
            slow sample, then both at every inter-sample instant. Step k of 1..N owns rows
            (k-1)*rows_per_step onwards; the terminal rows come last.
        terminal_rows: how many.
        terminal_reference, terminal_position, terminal_bound: (terminal_rows,); the terminal row
            reads |row + terminal_reference (r_N - p) + terminal_position p| <= terminal_bound.
        terminal_cost: (n, n) P of F(x, r) = (x - x_e)'P(x - x_e).
        state_scale: (n,) what x is divided by, below.
        stage: (n + 2 inter-sample instants, n + 1) on (x, u) of one step: the next x, whose first
            three entries are rows, then the inter-sample rows, velocity and acceleration each.
        stage_terminal: (terminal_rows, n) on the last x.
    """

    hessian: FloatArray
    gradient_state: FloatArray
    gradient_reference: FloatArray
    rows_command: FloatArray
    rows_state: FloatArray
    rows_per_step: int
    terminal_rows: int
    terminal_reference: FloatArray
    terminal_position: FloatArray
    terminal_bound: FloatArray
    terminal_cost: FloatArray
    state_scale: FloatArray
    stage: FloatArray
    stage_terminal: FloatArray


def stage_cost(n: int, weights: TrackingWeights, limits: AxisLimits) -> tuple[FloatArray, float]:
    """Q (n, n) on (p - r, v, a, ...) and R on (u - r) of (18), scaled by the limits."""
    q = np.zeros((n, n))
    q[0, 0] = weights.position / limits.fast_range_m**2
    q[1, 1] = weights.velocity / limits.velocity_m_per_s**2
    q[2, 2] = weights.acceleration / limits.acceleration_m_per_s2**2
    return q, weights.command / limits.fast_range_m**2


def terminal_cost(plant: Discrete, q: FloatArray, factor: float) -> FloatArray:
    """P of the terminal cost: A'PA - P + Q = 0 with u = r (17), times ``factor``."""
    total, power = q.copy(), plant.a.copy()
    # P = sum of A'^k Q A^k, doubled: terms only add up, so states of any scale keep their digits,
    # which a linear solve (states 1 m .. 1e6 m/s^4) does not
    for _ in range(LYAPUNOV_DOUBLINGS):
        total = total + power.T @ total @ power
        power = power @ power
    p: FloatArray = factor * 0.5 * (total + total.T)
    return p


def lyapunov_excess(plant: Discrete, q: FloatArray, p: FloatArray) -> float:
    """Largest eigenvalue of A'PA - P + Q relative to P; (17) holds where it is not positive."""
    residual = plant.a.T @ p @ plant.a - p + q
    if not np.any(p):  # nothing but the command is weighted: F = 0 and (17) holds with equality
        return 0.0
    return float(np.max(np.linalg.eigvalsh(0.5 * (residual + residual.T))) / np.linalg.norm(p))


def prediction(plant: Discrete, horizon: int) -> tuple[FloatArray, FloatArray]:
    """States x_0..x_N: (N+1, n, N) on the commands and (N+1, n, n) on x_0."""
    n = plant.order
    on_command = np.zeros((horizon + 1, n, horizon))
    on_state = np.zeros((horizon + 1, n, n))
    on_state[0] = np.eye(n)
    for k in range(horizon):
        on_command[k + 1] = plant.a @ on_command[k]
        on_command[k + 1, :, k] += plant.b
        on_state[k + 1] = plant.a @ on_state[k]
    return on_command, on_state


def condense(
    slow: StateSpace,
    sample_time_s: float,
    horizon: int,
    weights: TrackingWeights,
    limits: AxisLimits,
    admissible: AdmissibleSet,
    inter_sample_rows: int = 0,
) -> CondensedQp:
    """Eliminate the states of (16) and build the rows of (19).

    The range rows (16e, f), the range part of (16d) and the position limit all bound y_k, so they
    are one two-sided row whose bounds the caller intersects. Terminal rows that the rows of step
    N imply are left out.

    Args:
        slow: continuous, states p, v, a, ...; sample_time_s: T_s, s; horizon: N.
    """
    plant = discretise(slow, sample_time_s)
    on_command, on_state = prediction(plant, horizon)
    q, r = stage_cost(plant.order, weights, limits)
    p = terminal_cost(plant, q, weights.terminal_factor)
    excess = lyapunov_excess(plant, q, p)
    if excess > LYAPUNOV_TOLERANCE:
        raise ArithmeticError(
            f"(17) fails: A'PA - P + Q has an eigenvalue {excess:.3g} |P| above 0"
        )
    hessian, gradient_state, gradient_reference = _cost(on_command, on_state, q, r, p)
    stage_z, stage_x, per_step = _stage_rows(
        slow, sample_time_s, horizon, limits, inter_sample_rows, on_command, on_state
    )
    h_x, h_r, bound = terminal_pairs(admissible, limits)
    scale = _state_scale(plant.order, limits)
    return CondensedQp(
        hessian=hessian,
        gradient_state=gradient_state,
        gradient_reference=gradient_reference,
        rows_command=np.vstack([stage_z, h_x @ on_command[horizon]]),
        rows_state=np.vstack([stage_x, (h_x @ on_state[horizon])[:, 1:]]),
        rows_per_step=per_step,
        terminal_rows=h_r.size,
        terminal_reference=h_r,
        terminal_position=h_x[:, 0] + h_r,
        terminal_bound=bound,
        terminal_cost=p,
        state_scale=scale,
        stage=_stage(slow, plant, sample_time_s, scale, inter_sample_rows),
        stage_terminal=h_x * scale,
    )


def _state_scale(order: int, limits: AxisLimits) -> FloatArray:
    """(n,): a state in these units is a row of its step. Those beyond the acceleration have no
    limit; each is measured by the acceleration's."""
    scale = np.full(order, limits.acceleration_m_per_s2)
    scale[:2] = limits.fast_range_m, limits.velocity_m_per_s
    return scale


def _stage(
    slow: StateSpace, plant: Discrete, sample_time_s: float, scale: FloatArray, inter: int
) -> FloatArray:
    """One step of the plant in scaled states, and the rows inside it."""
    parts = [np.column_stack([plant.a, plant.b]) / scale[:, None]]
    for j in range(1, inter + 1):
        part = discretise(slow, sample_time_s * j / (inter + 1))
        parts.append(np.column_stack([part.a, part.b])[1:3] / scale[1:3, None])
    result: FloatArray = np.vstack(parts) * np.append(scale, 1.0)
    return result


def _cost(
    on_command: FloatArray, on_state: FloatArray, q: FloatArray, r: float, p: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    horizon, n = on_command.shape[2], on_command.shape[1]
    hessian = np.zeros((horizon, horizon))
    on_x = np.zeros((horizon, n))
    on_r = np.zeros((horizon, horizon + 1))
    for k in range(horizon + 1):
        weight = p if k == horizon else q
        g = on_command[k].T @ weight
        hessian += 2.0 * g @ on_command[k]
        on_x += 2.0 * g @ on_state[k]
        on_r[:, k] -= 2.0 * g[:, 0]
        if k < horizon:
            hessian[k, k] += 2.0 * r
            on_r[k, k] -= 2.0 * r
    return 0.5 * (hessian + hessian.T), on_x[:, 1:], on_r


def _stage_rows(
    slow: StateSpace,
    sample_time_s: float,
    horizon: int,
    limits: AxisLimits,
    inter: int,
    on_command: FloatArray,
    on_state: FloatArray,
) -> tuple[FloatArray, FloatArray, int]:
    rows_z: list[FloatArray] = []
    rows_x: list[FloatArray] = []
    scales = (limits.fast_range_m, limits.velocity_m_per_s, limits.acceleration_m_per_s2)
    between = [discretise(slow, sample_time_s * j / (inter + 1)) for j in range(1, inter + 1)]
    for k in range(1, horizon + 1):
        for i, scale in enumerate(scales):
            rows_z.append(on_command[k, i] / scale)
            rows_x.append(on_state[k, i] / scale)
        for part in between:
            z = part.a @ on_command[k - 1]
            z[:, k - 1] += part.b
            x = part.a @ on_state[k - 1]
            for i in (1, 2):
                rows_z.append(z[i] / scales[i])
                rows_x.append(x[i] / scales[i])
    return np.array(rows_z), np.array(rows_x)[:, 1:], 3 + 2 * inter


def terminal_pairs(
    admissible: AdmissibleSet, limits: AxisLimits
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pairs of (16g) that the rows of step N do not imply: h_x (t, n), h_r (t,), bound (t,).

    Rows on the command alone are left out too: the governor chose r_N, the program cannot move it.
    """
    h_x, h_r, k = admissible.pairs()
    n = h_x.shape[1]
    stage = np.zeros((4, n + 1))
    stage[0, 0] = 1.0 / limits.position_m
    stage[1, 1] = 1.0 / limits.velocity_m_per_s
    stage[2, 2] = 1.0 / limits.acceleration_m_per_s2
    stage[3, 0], stage[3, n] = 1.0 / limits.fast_range_m, -1.0 / limits.fast_range_m
    rows = np.hstack([h_x, h_r[:, None]]) / k[:, None]
    keep: list[int] = [i for i in range(k.size) if np.any(h_x[i] != 0.0)]
    fixed = [rows[i] for i in range(k.size) if i not in keep]
    for i in list(keep):
        others = np.array([*stage, *fixed, *(rows[j] for j in keep if j != i)])
        if pair_is_redundant(others, rows[i]):
            keep.remove(i)
    return h_x[keep], h_r[keep], k[keep]
