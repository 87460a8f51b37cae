"""In which order, and which way round, the strokes of a drawing are cut."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from servogen.paths.curves import BoolArray, FloatArray


@dataclass(frozen=True)
class Run:
    """Stroke number ``index``, cut from its end to its start if ``reverse``."""

    index: int
    reverse: bool


def as_given(count: int) -> list[Run]:
    """The strokes in the order and direction of the file."""
    return [Run(index, False) for index in range(count)]


def order_strokes(starts: FloatArray, ends: FloatArray, join_tolerance_m: float) -> list[Run]:
    """Chain strokes that meet, then visit the chains by nearest neighbour.

    Args:
        starts, ends: (n, 2) end points of the strokes, in metres.
        join_tolerance_m: end points closer than this meet.

    Returns every stroke once. The first chain is the one with the first stroke of the drawing;
    whenever several would do, the one drawn first is taken, and its own direction before the
    other, so that the order depends on the drawing alone.
    """
    chains = _chain(starts, ends, join_tolerance_m)
    heads = np.array([_entry(chain[0], starts, ends) for chain in chains])
    tails = np.array([_exit(chain[-1], starts, ends) for chain in chains])
    ordered = list(chains[0])
    free = np.ones(len(chains), dtype=bool)
    free[0] = False
    at = tails[0]
    while free.any():
        index, reverse = _nearest(at, heads, tails, free)
        free[index] = False
        chain = chains[index]
        ordered.extend(
            [Run(run.index, not run.reverse) for run in reversed(chain)] if reverse else chain
        )
        at = heads[index] if reverse else tails[index]
    return ordered


def _chain(starts: FloatArray, ends: FloatArray, tolerance: float) -> list[list[Run]]:
    """Grow a chain from the first free stroke, forwards and then backwards, until none is left."""
    free = np.ones(len(starts), dtype=bool)
    chains: list[list[Run]] = []
    for first in range(len(starts)):
        if not free[first]:
            continue
        free[first] = False
        chain = deque([Run(first, False)])
        at = ends[first]
        while (run := _meeting(at, starts, ends, free, tolerance)) is not None:
            free[run.index] = False
            chain.append(run)
            at = _exit(run, starts, ends)
        at = starts[first]
        while (run := _meeting(at, ends, starts, free, tolerance)) is not None:
            free[run.index] = False
            chain.appendleft(run)
            at = _entry(run, starts, ends)
        chains.append(list(chain))
    return chains


def _meeting(
    at: FloatArray, near: FloatArray, far: FloatArray, free: BoolArray, tolerance: float
) -> Run | None:
    """The first free stroke with an end point at ``at``; reversed if it is the ``far`` one."""
    near_gap, far_gap = np.hypot(*(near - at).T), np.hypot(*(far - at).T)
    hits = np.flatnonzero((np.minimum(near_gap, far_gap) <= tolerance) & free)
    if hits.size == 0:
        return None
    index = int(hits[0])
    return Run(index, bool(near_gap[index] > tolerance))


def _nearest(
    at: FloatArray, heads: FloatArray, tails: FloatArray, free: BoolArray
) -> tuple[int, bool]:
    head_gap = np.where(free, np.hypot(*(heads - at).T), np.inf)
    tail_gap = np.where(free, np.hypot(*(tails - at).T), np.inf)
    # argmin takes the first of equals: drawing order. A picometre is no difference.
    index = int(np.argmin(np.round(np.minimum(head_gap, tail_gap), 12)))
    return index, bool(tail_gap[index] < head_gap[index] - 1e-12)


def _entry(run: Run, starts: FloatArray, ends: FloatArray) -> FloatArray:
    point: FloatArray = (ends if run.reverse else starts)[run.index]
    return point


def _exit(run: Run, starts: FloatArray, ends: FloatArray) -> FloatArray:
    point: FloatArray = (starts if run.reverse else ends)[run.index]
    return point
