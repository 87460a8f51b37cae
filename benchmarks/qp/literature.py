"""MPC problems of the literature, made here: plant, limits and weights are the sources' as far as
they say them, set points and disturbances are drawn with a fixed seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from qp.sequence import FAR, Array, Sequence, StagePlant, Stated, solve_reference

# State and input of rest at a sample.
Target = Callable[[int], tuple[Array, Array]]


@dataclass(frozen=True)
class Plant:
    """x+ = A x + B u, |u| <= input_limit, |C x| <= output_limit; weights Q, R."""

    name: str
    source: str
    a: Array
    b: Array
    c: Array
    input_limit: Array
    output_limit: Array
    q: Array
    r: Array


def sampled(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    n, p = b.shape
    both = expm(period * np.block([[a, b], [np.zeros((p, n + p))]]))
    return both[:n, :n], both[:n, n:]


def double_integrator() -> Plant:
    a, b = sampled(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), 0.1)
    return Plant(
        "double_integrator", "double integrator at 0.1 s, |u| <= 1, |v| <= 0.5",
        a, b, np.array([[0.0, 1.0]]), np.array([1.0]), np.array([0.5]),
        np.diag([1.0, 0.1]), np.array([[0.01]]),
    )  # fmt: skip


def aircraft() -> Plant:
    a = np.array(
        [
            [-0.0151, -60.5651, 0.0, -32.174],
            [-0.0001, -1.3411, 0.9929, 0.0],
            [0.00018, 43.2541, -0.86939, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ]
    )
    b = np.array([[-2.516, -13.136], [-0.1689, -0.2514], [-17.251, -1.5766], [0.0, 0.0]])
    a, b = sampled(a, b, 0.05)
    c = np.array([[0.0, 1.0, 0.0, 0.0]])
    return Plant(
        "afti16", "AFTI F-16, Kapasouris, Athans, Stein 1988; surfaces within 25 degrees",
        a, b, c, np.array([25.0, 25.0]), np.array([0.5]),
        np.diag([1e-8, 10.0, 1e-2, 10.0]), 0.01 * np.eye(2),
    )  # fmt: skip


def tanks() -> Plant:
    """Around the minimum-phase operating point; deviations of levels in cm, of voltages in V."""
    area, outlet = np.array([28.0, 32.0, 28.0, 32.0]), np.array([0.071, 0.057] * 2)
    level = np.array([12.4, 12.7, 1.8, 1.4])
    time = area / outlet * np.sqrt(2.0 * level / 981.0)
    k, gamma = np.array([3.33, 3.35]), np.array([0.70, 0.60])
    a = np.diag(-1.0 / time)
    a[0, 2], a[1, 3] = area[2] / (area[0] * time[2]), area[3] / (area[1] * time[3])
    b = np.zeros((4, 2))
    b[0, 0], b[1, 1] = gamma * k / area[:2]
    b[2, 1], b[3, 0] = (1 - gamma[1]) * k[1] / area[2], (1 - gamma[0]) * k[0] / area[3]
    a, b = sampled(a, b, 5.0)
    return Plant(
        "quadruple_tank", "quadruple tank, Johansson 2000, minimum phase, 5 s",
        a, b, np.eye(4), np.array([1.0, 1.0]), np.array([3.0, 3.0, 1.0, 1.0]),
        np.diag([1.0, 1.0, 0.01, 0.01]), 0.01 * np.eye(2),
    )  # fmt: skip


def masses(count: int = 6) -> Plant:
    """A chain between two walls, unit masses and springs, one actuator between every other pair."""
    stiff = 2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    a = np.block([[np.zeros((count, count)), np.eye(count)], [-stiff, np.zeros((count, count))]])
    b = np.zeros((2 * count, count // 2))
    for j in range(count // 2):
        b[count + 2 * j, j], b[count + 2 * j + 1, j] = 1.0, -1.0
    a, b = sampled(a, b, 0.5)
    return Plant(
        "masses", f"{count} oscillating masses, after Wang and Boyd 2010, |u| <= 0.5, |x| <= 4",
        a, b, np.eye(2 * count), np.full(count // 2, 0.5), np.full(2 * count, 4.0),
        np.eye(2 * count), np.eye(count // 2),
    )  # fmt: skip


def closed_loop(
    plant: Plant,
    horizon: int,
    steps: int,
    target: Target,
    disturbance: Array,
    rho: float | None = None,
    start: Array | None = None,
) -> Sequence:
    """Condensed programs of x_0..x_{steps-1}; ``target`` gives the steady state and its input.

    Args:
        rho: with the last weight that TinyMPC presumes, so that it can state the programs, which
            then are named after it; limits must be those of single states.
        start: x_0, zeros if not given.
    """
    a, b, n, p = plant.a, plant.b, *plant.b.shape
    added = rho or 0.0
    end = solve_discrete_are(a, b, plant.q + added * np.eye(n), plant.r + added * np.eye(p))
    end = end - added * np.eye(n)
    ahead, on_state = np.zeros((horizon, n, horizon * p)), np.zeros((horizon, n, n))
    row, power = np.zeros((n, horizon * p)), np.eye(n)
    for k in range(horizon):
        row = a @ row
        row[:, k * p : (k + 1) * p] += b
        power = a @ power
        ahead[k], on_state[k] = row, power
    weight = [plant.q] * (horizon - 1) + [end]
    weighted = np.stack([w @ m for w, m in zip(weight, ahead, strict=True)])
    hessian = np.einsum("kij,kil->jl", ahead, weighted) + np.kron(np.eye(horizon), plant.r)
    hessian = 0.5 * (hessian + hessian.T)
    unit = np.eye(horizon * p)
    c = plant.c / plant.output_limit[:, None]
    rows, free = [], []
    for k in range(horizon):
        rows += [unit[k * p : (k + 1) * p] / plant.input_limit[:, None], c @ ahead[k]]
        free += [np.zeros((p, n)), c @ on_state[k]]
    written, offset = np.vstack(rows), np.vstack(free)
    x, programs = np.zeros(n) if start is None else start, []
    rests: list[tuple[Array, Array, Array]] = []
    for t in range(steps):
        level, rest = target(t)
        rests.append((x, level, rest))
        off = np.einsum("kij,j->ki", on_state, x) - level
        linear = np.einsum("kij,ki->j", weighted, off) - np.tile(plant.r @ rest, horizon)
        away = offset @ x
        programs.append((linear, -1.0 - away, 1.0 - away))
        z, _ = solve_reference(hessian, written, *programs[-1])
        x = a @ x + b @ z[:p] + disturbance[t]
    linear, low, high = (np.array(part) for part in zip(*programs, strict=True))
    name, stated = f"{plant.name}_{horizon}", None
    if rho is not None:
        name, stated = f"boxes_{name}", _stated(plant, rho, rests)
    return Sequence(
        name, plant.source, hessian, written, linear, low, high,
        per_step=p + len(c), staying=0, plant=behind(plant), stated=stated,
    )  # fmt: skip


def _stated(plant: Plant, rho: float, rests: list[tuple[Array, Array, Array]]) -> Stated:
    n = len(plant.a)
    assert np.all(np.count_nonzero(plant.c, axis=1) == 1)
    assert np.all(plant.c.sum(axis=1) == 1.0)
    limit = np.full(n, FAR)
    limit[np.argmax(plant.c, axis=1)] = plant.output_limit
    x, level, rest = (np.array(part) for part in zip(*rests, strict=True))
    return Stated(
        plant.a, plant.b, np.diag(plant.q), np.diag(plant.r), rho, x - level, -limit - level,
        limit - level, -plant.input_limit - rest, plant.input_limit - rest,
    )  # fmt: skip


def behind(plant: Plant) -> StagePlant:
    """The plant behind the rows; every limited output is a state, which comes first and is measured
    by its limit, and states that no output feels are left out."""
    seen = np.any(plant.c != 0.0, axis=0)
    for _ in seen:
        seen = seen | np.any(plant.a[seen] != 0.0, axis=0)
    first = np.argmax(np.abs(plant.c), axis=1)
    assert np.all(np.count_nonzero(plant.c, axis=1) == 1)
    order = [*first, *(i for i in np.flatnonzero(seen) if i not in first)]
    unit = np.ones(len(order))
    unit[: len(first)] = plant.output_limit / plant.c[np.arange(len(first)), first]
    moved = plant.a[np.ix_(order, order)] * unit / unit[:, None]
    stage = np.hstack([moved, plant.b[order] / unit[:, None]])
    return StagePlant(
        stage, np.zeros((0, len(order))), len(first), plant.b.shape[1],
        bounds=1.0 / plant.input_limit,
    )  # fmt: skip


def steady(plant: Plant, outputs: Array, wanted: Array) -> tuple[Array, Array]:
    """State and input at rest at which ``outputs`` x comes as close to ``wanted`` as it can."""
    n, p = plant.b.shape
    rest = np.block([[plant.a - np.eye(n), plant.b], [outputs, np.zeros((len(outputs), p))]])
    both = np.linalg.lstsq(rest, np.concatenate([np.zeros(n), wanted]), rcond=None)[0]
    return both[:n], both[n:]


# Penalties of TinyMPC, of the powers of ten from 0.01 to 100 those with which it needs the fewest
# iterations at most.
RHO = {"double_integrator": 0.1, "masses": 10.0}


def names(boxes: bool) -> tuple[str, ...]:
    """Of the sequences of ``all_loops``."""
    plain = ("double_integrator_30", "afti16_10", "quadruple_tank_15", "masses_10")
    if not boxes:
        return plain
    return tuple(f"boxes_{name}" for name in plain if name.rpartition("_")[0] in RHO)


def all_loops(steps: int, boxes: bool = False) -> list[Sequence]:
    """``boxes``: those that TinyMPC can state with another last weight, and with it."""
    made: list[Sequence] = []
    rng = np.random.default_rng(5)
    still = np.zeros((steps, 1))

    def add(plant: Plant, horizon: int, target: Target, disturbance: Array) -> None:
        rho = RHO.get(plant.name) if boxes else None
        if rho is not None or not boxes:
            made.append(closed_loop(plant, horizon, steps, target, disturbance, rho))

    points = rng.uniform(-2.0, 2.0, steps // 50 + 1)
    add(double_integrator(), 30, lambda t: (np.array([points[t // 50], 0.0]), np.zeros(1)), still)
    pitch = rng.uniform(-10.0, 10.0, steps // 50 + 1)
    add(
        aircraft(), 10,
        lambda t: (np.array([0.0, 0.0, 0.0, pitch[t // 50]]), np.zeros(2)), still,
    )  # fmt: skip
    tank = tanks()
    levels = rng.uniform(-2.0, 2.0, (steps // 50 + 1, 2))
    add(tank, 15, lambda t: steady(tank, np.eye(4)[:2], levels[t // 50]), still)
    push = np.zeros((steps, 12))
    push[:, 6:] = rng.uniform(-0.5, 0.5, (steps, 6))
    add(masses(), 10, lambda t: (np.zeros(12), np.zeros(3)), push)
    return made
