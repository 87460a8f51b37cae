"""The machine of paper 4 with a short horizon, patterns for it, and a stand-in for the taut string.

The sets of long horizons take seconds; each is computed once in a process.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import scipy.sparse
from scipy.optimize import linprog

from servogen.controllers.command_governor_design import (
    CommandGovernorDesign,
    GovernorSettings,
    design_axis_governor,
    design_command_governor,
)
from servogen.plants.statespace import StateSpace
from servogen.plants.transfer import transfer_function
from servogen.precision import FLOAT64, Precision
from servogen.sets.auxiliary import shift_register
from servogen.sets.constraints import AxisLimits
from servogen.sets.extended import ExtendedSet, centred_limits, extended_set

T_S, STROKE, EPSILON = 0.0356, 0.025, 0.001
LIMITS, CENTRE = centred_limits(0.0, 0.25, AxisLimits(1.0, 0.1, 10.0, STROKE))


def stage(pole: float = 20.0) -> StateSpace:
    return transfer_function([pole**3], np.poly([-pole] * 3))


def admissible(horizon: int, sub_samples: int = 3, pole: float = 20.0) -> ExtendedSet:
    return _admissible(horizon, sub_samples, pole)


@cache
def _admissible(horizon: int, sub_samples: int, pole: float) -> ExtendedSet:
    register = shift_register(horizon)
    return extended_set(stage(pole), T_S, register, sub_samples, LIMITS, CENTRE)


@cache
def machine(
    horizon: int,
    settings: GovernorSettings | None = None,
    points: int = 50,
    sub_samples: int = 3,
    precision: Precision = FLOAT64,
    pole: float = 20.0,
) -> CommandGovernorDesign:
    """Both axes alike; ``points`` M per period."""
    chosen = settings or GovernorSettings()
    target = admissible(horizon, sub_samples, pole)
    x = design_axis_governor("governor_x", precision, stage(pole), target, chosen)
    y = replace(x, prefix="governor_y")
    return design_command_governor("governor", (x, y), points, chosen)


def figures(seed: int, cells: int, points: int) -> np.ndarray:
    """(J, 2) closed figures of up to 20 mm in a row of cells of 50 mm, joined by straight moves."""
    generator = np.random.default_rng(seed)
    parts: list[np.ndarray] = []
    for cell in range(cells):
        t = np.linspace(0.0, 2.0 * np.pi, points)
        size, turns = generator.uniform(0.008, 0.02, 2), generator.integers(1, 4, 2)
        phase = generator.uniform(0.0, 2.0 * np.pi, 2)
        middle = np.array([0.03 + 0.05 * (cell % 4), 0.03 + 0.05 * (cell // 4)])
        figure = middle + size * np.sin(turns * t[:, None] + phase)
        if parts:
            gap = figure[0] - parts[-1][-1]
            moves = points // 10
            share = np.arange(1.0, moves)[:, None] / moves
            parts.append(parts[-1][-1] + share * gap)
        parts.append(figure)
    return np.vstack(parts)


def least_motion(points: np.ndarray, block: int = 1) -> np.ndarray:
    """(J, 2) of least total variation in the tube, the same for ``block`` points at a time, by a
    linear program: a stand-in for (19)."""
    return np.stack([_least(column, block) for column in points.T], axis=1)


def _least(points: np.ndarray, block: int) -> np.ndarray:
    starts, reach = np.arange(0, points.size, block), STROKE - EPSILON
    low = np.maximum.reduceat(points, starts) - reach
    high = np.minimum.reduceat(points, starts) + reach
    n = starts.size
    difference = scipy.sparse.diags_array(
        [-np.ones(n - 1), np.ones(n - 1)], offsets=[0, 1], shape=(n - 1, n)
    )
    one = scipy.sparse.eye_array(n - 1)
    rows = scipy.sparse.block_array([[difference, -one], [-difference, -one]], format="csr")
    cost = np.concatenate([np.zeros(n), np.ones(n - 1)])
    low[[0, -1]] = high[[0, -1]] = points[[0, -1]]
    bounds = [*zip(low, high, strict=True), *([(0.0, None)] * (n - 1))]
    found = linprog(cost, A_ub=rows, b_ub=np.zeros(2 * n - 2), bounds=bounds, method="highs-ipm")
    assert found.status == 0
    return np.repeat(np.clip(found.x[:n], low, high), block)[: points.size]
