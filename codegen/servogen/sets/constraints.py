"""The constraints of one axis as outputs of the sampled slow stage, at and between its samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import Discrete, FloatArray, StateSpace, discretise, read_only
from servogen.sets.errors import SetError

# Beyond this deviation of the dc gain from one, measured on the sampled model, a constant command
# is not where the stage comes to rest and the coordinates below do not describe it.
SHIFT_TOLERANCE = 1e-9


@dataclass(frozen=True)
class AxisLimits:
    """Limits of one axis, SI: each bounds the absolute value; the last one bounds p - r."""

    position_m: float
    velocity_m_per_s: float
    acceleration_m_per_s2: float
    fast_range_m: float

    def __post_init__(self) -> None:
        for key in ("position_m", "velocity_m_per_s", "acceleration_m_per_s2", "fast_range_m"):
            value = getattr(self, key)
            if not (np.isfinite(value) and value > 0.0):
                raise SetError(key, value, "a positive finite limit, else nothing is admissible")


@dataclass(frozen=True)
class ConstraintRows:
    """|x_rows x + r_rows r| <= 1 at one slow sample and inside the interval that follows it.

    Every row is divided by its limit. In order: position, velocity, acceleration, position less
    command at the sample, then the same four at each inter-sample instant.

    ``x_rows`` (rows, n), ``r_rows`` (rows,); ``x_rows[:, 0] + r_rows`` is exactly zero but for
    position rows, where it is 1 / position limit: a move of the whole axis changes nothing else.
    """

    x_rows: FloatArray
    r_rows: FloatArray
    names: tuple[str, ...]


def shift_rows(slow: Discrete, limits: AxisLimits) -> FloatArray:
    """(4, n + 1) position, velocity, acceleration, error rows in (e, v, a, ..., r), e = p - r.

    Each divided by its limit. In these coordinates a slow stage of unit dc gain obeys
    x+ = A x, r+ = r, without the command: the symmetry of the axis is exact, not rounded.

    Raises:
        SetError: fewer than three states, or a sampled dc gain that is not one.
    """
    n = slow.order
    if n < 3:
        raise SetError("slow stage order", n, "at least 3 (position, velocity, acceleration)")
    rest = np.eye(n)[0]
    # in shares of what matters: a command of the whole position limit may move a state that should
    # stand still by no more than the tolerance times that state's limit
    scale = np.maximum(np.max(np.abs(slow.a), axis=1), np.abs(slow.b))
    scale[:3] = np.maximum(
        scale[:3],
        np.array([1.0, limits.velocity_m_per_s, limits.acceleration_m_per_s2]) / limits.position_m,
    )
    off = np.abs(slow.a @ rest + slow.b - rest) / scale
    if np.any(off > SHIFT_TOLERANCE):
        raise SetError(
            "slow stage",
            f"off by {float(np.max(off)):.3g} from rest under a constant command",
            "a sampled dc gain of one, with the position as first state",
        )
    rows = np.zeros((4, n + 1))
    rows[0, [0, n]] = 1.0 / limits.position_m
    rows[1, 1] = 1.0 / limits.velocity_m_per_s
    rows[2, 2] = 1.0 / limits.acceleration_m_per_s2
    rows[3, 0] = 1.0 / limits.fast_range_m
    return rows


def inter_sample_maps(
    slow: StateSpace, sample_time_s: float, inter_sample_rows: int
) -> tuple[Discrete, ...]:
    """The slow stage held for j T_s / (m + 1), j = 1..m: exact, not interpolated.

    Raises:
        SetError: m negative.
    """
    if inter_sample_rows < 0:
        raise SetError("inter_sample_rows", inter_sample_rows, "zero or a positive whole number")
    step = sample_time_s / (inter_sample_rows + 1)
    return tuple(discretise(slow, j * step) for j in range(1, inter_sample_rows + 1))


def axis_outputs(
    slow: StateSpace, sample_time_s: float, limits: AxisLimits, inter_sample_rows: int
) -> tuple[FloatArray, tuple[str, ...]]:
    """All rows of one sample in (e, v, a, ..., r), (4 + 4 m, n + 1), and their names."""
    base = shift_rows(discretise(slow, sample_time_s), limits)
    kinds = ("position", "velocity", "acceleration", "error")
    blocks, names = [base], list(kinds)
    for j, held in enumerate(inter_sample_maps(slow, sample_time_s, inter_sample_rows), start=1):
        shift_rows(held, limits)
        blocks.append(np.column_stack([base[:, :-1] @ held.a, base[:, -1]]))
        names += [f"{kind} at {j}/{inter_sample_rows + 1}" for kind in kinds]
    return np.vstack(blocks), tuple(names)


def to_state_and_command(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rows in (e, v, a, ..., r) as rows on x = (p, v, a, ...), (rows, n), and on r, (rows,).

    e = p - r, so the command's share is what r had less what e has.
    """
    return rows[:, :-1].copy(), rows[:, -1] - rows[:, 0]


def constraint_rows(
    slow: StateSpace, sample_time_s: float, limits: AxisLimits, inter_sample_rows: int = 0
) -> ConstraintRows:
    """The constraints (12) of one sample, on state and constant command; see ``ConstraintRows``."""
    rows, names = axis_outputs(slow, sample_time_s, limits, inter_sample_rows)
    x_rows, r_rows = to_state_and_command(rows)
    return ConstraintRows(read_only(x_rows), read_only(r_rows), names)
