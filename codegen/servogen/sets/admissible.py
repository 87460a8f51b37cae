"""Maximal output-admissible set of one axis under a constant command (Result 1 of paper 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import FloatArray, StateSpace, discretise, read_only
from servogen.sets.constraints import AxisLimits, axis_outputs, to_state_and_command
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import pair_is_redundant, remove_redundant_pairs

# Samples looked ahead before giving up. The index is where the stage has settled to the
# tightening: ln(1 / eps) / (w T_s) samples, so 300 serves a stage a hundred times too slow.
MAX_STEPS = 300
# Pairs of rows before giving up: a governor that tests 600 rows per candidate serves no machine,
# and the linear programs of a hopeless setting would go on for minutes.
MAX_PAIRS = 300


@dataclass(frozen=True)
class AdmissibleSet:
    """{(x, r) : h_x x + h_r r <= k}: states from which r held for ever violates nothing.

    Symmetric about the origin, exactly: the second half of the rows is the first half negated.

    Attributes:
        h_x: (rows, n) on the state p, v, a, ... (m, m/s, m/s^2, ...).
        h_r: (rows,) on the command, m. ``h_x[:, 0] + h_r`` is exactly zero on rows that a move
            of the whole axis leaves alone.
        k: (rows,) all one.
        finite_step: the determination index: rows of later samples are all redundant.
        lp_count: linear programs solved.
        tightening: eps, the share of the limits that steady states keep clear of.
        sources: (rows / 2,) where each pair comes from, "acceleration, sample 1".
    """

    h_x: FloatArray
    h_r: FloatArray
    k: FloatArray
    finite_step: int
    lp_count: int
    tightening: float
    sources: tuple[str, ...]

    def pairs(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """One of each +- pair: |h_x x + h_r r| <= k with h_x (pairs, n), h_r, k (pairs,)."""
        half = self.k.size // 2
        return self.h_x[:half], self.h_r[:half], self.k[:half]

    def excess(self, state: FloatArray, command: float) -> float:
        """Largest h_x x + h_r r - k: at most zero inside; in shares of the limits."""
        return float(np.max(self.h_x @ state + self.h_r * command - self.k))

    def contains(self, state: FloatArray, command: float, tolerance: float = 0.0) -> bool:
        """Whether ``state`` (n,) with ``command`` (m) lies inside."""
        return self.excess(state, command) <= tolerance


def maximal_admissible_set(
    slow: StateSpace,
    sample_time_s: float,
    limits: AxisLimits,
    steady_state_tightening: float,
    inter_sample_rows: int = 0,
    max_steps: int = MAX_STEPS,
) -> AdmissibleSet:
    """O-infinity of x+ = A x + B r, r+ = r under the limits of the axis (12).

    Rows of sample t + k are added for k = 0, 1, 2, ... where a linear program finds them not
    implied; the first k of which none is added ends it (finite determination). Steady states are
    held to (1 - eps) of the limits: of those only |r| <= (1 - eps) position limit says anything.

    Args:
        slow: continuous, states p, v, a, ..., unit dc gain.
        sample_time_s: T_s, s.
        limits: see ``AxisLimits``.
        steady_state_tightening: 0 < eps < 1.
        inter_sample_rows: instants inside T_s at which the limits hold too.
        max_steps: give up beyond this determination index.

    Raises:
        SetError: an unstable stage, eps outside (0, 1), or not determined in ``max_steps``
            and ``2 MAX_PAIRS`` rows.
    """
    if not 0.0 < steady_state_tightening < 1.0:
        expected = "a number between 0 and 1, both excluded"
        raise SetError("steady_state_tightening", steady_state_tightening, expected)
    if not slow.is_stable:
        raise SetError("slow stage", "unstable", "a stable slow stage")
    outputs, names = axis_outputs(slow, sample_time_s, limits, inter_sample_rows)
    n = slow.order
    steady = np.zeros((1, n + 1))
    steady[0, n] = 1.0 / ((1.0 - steady_state_tightening) * limits.position_m)
    step = np.eye(n + 1)  # in (e, v, a, ..., r): the command drops out, see shift_rows
    step[:n, :n] = discretise(slow, sample_time_s).a
    grown = _grow(steady, outputs, names, step, max_steps)
    if grown is None:
        expected = (
            f"one for which the admissible set is determined within {max_steps} samples "
            f"and {2 * MAX_PAIRS} rows (larger, or a longer slow_sample_time_s)"
        )
        raise SetError("steady_state_tightening", steady_state_tightening, expected)
    kept = remove_redundant_pairs(grown.rows)
    h_x, h_r = to_state_and_command(grown.rows[kept])
    return AdmissibleSet(
        h_x=read_only(np.vstack([h_x, -h_x])),
        h_r=read_only(np.concatenate([h_r, -h_r])),
        k=read_only(np.ones(2 * len(kept))),
        finite_step=grown.finite_step,
        lp_count=grown.lp_count + len(grown.rows),
        tightening=steady_state_tightening,
        sources=tuple(grown.sources[i] for i in kept),
    )


@dataclass(frozen=True)
class _Grown:
    """Pairs |rows z| <= 1, z = (e, v, a, ..., r), that imply those of every later sample."""

    rows: FloatArray
    sources: tuple[str, ...]
    finite_step: int
    lp_count: int


def _grow(
    steady: FloatArray,
    outputs: FloatArray,
    names: tuple[str, ...],
    step: FloatArray,
    max_steps: int,
) -> _Grown | None:
    """Add what each next sample asks beyond the samples before it; None if that does not end."""
    rows = np.vstack([steady, outputs])
    sources = ["steady state", *(f"{name}, sample 0" for name in names)]
    ahead, lp_count = outputs, 0
    for index in range(max_steps):
        ahead = ahead @ step
        fresh = [i for i in range(len(ahead)) if not pair_is_redundant(rows, ahead[i])]
        lp_count += len(ahead)
        if not fresh:
            return _Grown(rows, tuple(sources), index, lp_count)
        rows = np.vstack([rows, ahead[fresh]])
        sources += [f"{names[i]}, sample {index + 1}" for i in fresh]
        if len(rows) > MAX_PAIRS:
            return None
    return None
