"""Random calls of a streamed minimal motion: drawings of all kinds, in blocks of all sizes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.motion_window_design import MotionWindowDesign
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# Points of a path in windows, the share of inputs that are no use, and of starts out of reach.
_LENGTH, _BAD, _FAR = 6, 0.03, 0.1


def motion_window_calls(
    design: MotionWindowDesign, rng: np.random.Generator, count: int
) -> Iterator[Call]:
    """``count`` calls: path after path, most streamed to their end and some beyond it."""
    made = 0
    while made < count:
        for call in _path_calls(design, rng):
            yield call
            made += 1
            if made == count:
                return


def _path_calls(design: MotionWindowDesign, rng: np.random.Generator) -> Iterator[Call]:
    path = random_pattern(design, rng, int(rng.integers(1, _LENGTH * design.window + 2)))
    far = 3.0 if rng.random() < _FAR else 0.99
    start = float(path[0]) + far * design.reach_m * rng.uniform(-1.0, 1.0)
    yield Call("reset", {"start": float(np.clip(start, -design.limit_m, design.limit_m))})
    at = 0
    whole = rng.random() < 0.6
    while at < path.size:
        size = design.block if whole else int(rng.integers(0, design.block + 1))
        block = path[at : at + size]
        if rng.random() < _BAD:
            yield _step(design, _spoilt(design, rng), block.size, False)
            continue
        at += block.size
        # the end comes with the last points or after them
        yield _step(design, block, block.size, at >= path.size and rng.random() < 0.5)
    for _ in range(design.window // design.block + int(rng.integers(1, 4))):
        yield _step(design, path[:0], 0, True)
    if rng.random() < 0.3:
        yield _step(design, path[: design.block], min(path.size, design.block), False)


def _step(design: MotionWindowDesign, points: FloatArray, n_points: int, ended: bool) -> Call:
    block = np.zeros(design.block)
    block[: points.size] = points
    return Call("step", {"points": block, "n_points": n_points, "ended": int(ended)})


def _spoilt(design: MotionWindowDesign, rng: np.random.Generator) -> FloatArray:
    """Values among which one is none, or far away."""
    points: FloatArray = np.zeros(design.block)
    value = rng.choice([np.nan, np.inf, -np.inf, 1.1 * design.limit_m, -1.1 * design.limit_m])
    points[int(rng.integers(design.block))] = value
    return points


def random_pattern(design: MotionWindowDesign, rng: np.random.Generator, size: int) -> FloatArray:
    """(size,) within the limit: figures, a walk, jumps, or few values, so that many points are in
    one line; some beyond the reach of a single place, some not."""
    t = np.arange(size)
    match int(rng.integers(4)):
        case 0:
            shape = np.sin(t * rng.uniform(0.01, 1.0)) + 0.5 * np.sin(t * rng.uniform(0.01, 0.1))
        case 1:
            shape = 0.2 * np.cumsum(rng.normal(size=size))
        case 2:
            shape = np.repeat(rng.normal(size=size), 1 + int(rng.integers(9)))[:size]
        case _:
            shape = 0.5 * np.cumsum(rng.integers(-1, 2, size))
    scale = design.reach_m * 10.0 ** rng.uniform(-0.3, 0.7)
    pattern: FloatArray = np.clip(scale * shape, -design.limit_m, design.limit_m)
    return pattern
