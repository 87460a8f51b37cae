"""Admissible set of state, auxiliary state and final command of one axis: P-tilde of paper 4 (5).

The limits hold at N instants of every slow period (12), the command is held over the period, and
steady states keep a share of the position range clear of its ends: V' inside the interior of V, so
that finitely many instants imply all later ones.

Coordinates: e = p - rho, v, a, ..., the auxiliary state, and rho less the middle of the range. With
unit dc gain the command drops out of e, and the set is symmetric about the origin, exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from servogen.plants.statespace import FloatArray, StateSpace, discretise, read_only
from servogen.sets.auxiliary import AuxiliaryDynamics
from servogen.sets.constraints import AxisLimits, shift_rows
from servogen.sets.errors import SetError
from servogen.sets.polyhedron import pair_is_redundant, remove_redundant_pairs

KINDS = ("position", "velocity", "acceleration")
# Instants beyond those of the auxiliary states before giving up. Where the stage has settled to the
# tightening all is implied: ln(1 / 0.005) = 5.3 time constants, so this serves a stage that takes
# sixty periods of five instants for one.
MAX_STEPS = 300


@dataclass(frozen=True)
class ExtendedSet:
    """{(x, x_aux, rho) : |h_x x' + h_aux x_aux + h_rho rho'| <= 1}, two inequalities a row.

    x' and rho' are x and rho with the position counted from ``centre_m``.

    Attributes:
        h_x: (rows, n). h_aux: (rows, aux). h_rho: (rows,).
        centre_m: middle of the position range.
        limits: about the middle; the fast range is not used.
        auxiliary, sub_samples, sample_time_s: what it was made for; N and T_s.
        tightening: eps, the share of the range about its middle that steady states keep clear of.
        sources: (rows,) kind and instant, in T_s / N; ("steady state", -1) is V'.
        last_instant: the last one of which a row was not implied by the ones before.
        inequalities: up to that instant, before any was removed.
        lp_count: linear programs solved.
    """

    h_x: FloatArray
    h_aux: FloatArray
    h_rho: FloatArray
    centre_m: float
    limits: AxisLimits
    auxiliary: AuxiliaryDynamics
    sub_samples: int
    sample_time_s: float
    tightening: float
    sources: tuple[tuple[str, int], ...]
    last_instant: int
    inequalities: int
    lp_count: int

    @property
    def rows(self) -> FloatArray:
        """(rows, n + aux + 1) side by side."""
        return np.column_stack([self.h_x, self.h_aux, self.h_rho])

    @property
    def finite_step(self) -> int:
        """t*: instants needed beyond those that the auxiliary states have of their own."""
        return self.last_instant + 1 - self.auxiliary.order * self.sub_samples

    def excess(self, state: FloatArray, auxiliary: FloatArray, rho: float) -> float:
        """Largest |row| - 1 of ``state`` (n,), ``auxiliary`` (aux,), ``rho`` (m): at most 0 inside.

        In shares of the limits."""
        moved = state.copy()
        moved[0] -= self.centre_m
        rows = self.h_x @ moved + self.h_aux @ auxiliary + self.h_rho * (rho - self.centre_m)
        return float(np.max(np.abs(rows)) - 1.0)

    def contains(
        self, state: FloatArray, auxiliary: FloatArray, rho: float, tolerance: float = 0.0
    ) -> bool:
        """Whether a point lies inside."""
        return self.excess(state, auxiliary, rho) <= tolerance

    def interval(self, state: FloatArray, auxiliary: FloatArray) -> tuple[float, float]:
        """Least and greatest rho (m) with this state and auxiliary state; the first is above the
        second where there is none. All that a command or reference governor asks of the set."""
        moved = state.copy()
        moved[0] -= self.centre_m
        used = self.h_rho != 0.0
        at = (self.h_x @ moved + self.h_aux @ auxiliary)[used] / self.h_rho[used]
        reach = 1.0 / np.abs(self.h_rho[used])
        least, most = float(np.max(-at - reach)), float(np.min(reach - at))
        return least + self.centre_m, most + self.centre_m


def centred_limits(low_m: float, high_m: float, limits: AxisLimits) -> tuple[AxisLimits, float]:
    """Limits with the position counted from the middle of its range, and the middle, m.

    Raises:
        SetError: a range that is empty or not finite.
    """
    if not (np.isfinite(low_m) and np.isfinite(high_m) and low_m < high_m):
        raise SetError("position range", f"{low_m} to {high_m}", "a least below a greatest one")
    half = AxisLimits(
        0.5 * (high_m - low_m),
        limits.velocity_m_per_s,
        limits.acceleration_m_per_s2,
        limits.fast_range_m,
    )
    return half, 0.5 * (low_m + high_m)


def extended_set(
    slow: StateSpace,
    sample_time_s: float,
    auxiliary: AuxiliaryDynamics,
    sub_samples: int,
    limits: AxisLimits,
    centre_m: float = 0.0,
    tightening: float = 0.005,
    max_steps: int = MAX_STEPS,
) -> ExtendedSet:
    """P-tilde of (5) and (14), without redundant rows.

    Rows of instant t are added until those of a whole period add nothing: moved on by one period
    the rest is then implied too. Instants at which a shift register still has commands to come are
    not asked; their rows are tried when redundant ones are removed.

    Args:
        slow: continuous, states p, v, a, ..., unit dc gain.
        sample_time_s: T_s, s. sub_samples: N, instants per period.
        limits: about ``centre_m``; see ``centred_limits``.
        tightening: 0 < eps < 1: V' = (1 - eps) V.
        max_steps: give up when so many instants beyond the auxiliary states' do not settle it.

    Raises:
        SetError: an unstable stage, no instant, eps outside (0, 1), or not finitely determined.
    """
    if not 0.0 < tightening < 1.0:
        raise SetError("tightening", tightening, "a number between 0 and 1, both excluded")
    if sub_samples < 1:
        raise SetError("sub_samples", sub_samples, "at least one instant per period")
    if not slow.is_stable:
        raise SetError("slow stage", "unstable", "a stable slow stage")
    blocks: list[FloatArray] = []
    sure, quiet, lp_count = auxiliary.order * sub_samples, 0, 0
    size = slow.order + auxiliary.order + 1
    steady = np.zeros((1, size))
    steady[0, -1] = 1.0 / ((1.0 - tightening) * limits.position_m)
    last = 0
    for t, rows in enumerate(instants(slow, sample_time_s, auxiliary, sub_samples, limits)):
        blocks.append(rows)
        if t <= sure:
            last = t
            continue
        known = np.vstack([steady, *blocks[: last + 1]])
        lp_count += len(rows)
        if all(pair_is_redundant(known, row) for row in rows):
            quiet += 1
        else:
            last, quiet = t, 0
        if quiet == sub_samples:
            break
        if t > sure + max_steps:
            expected = f"one with which {max_steps} instants determine the set (larger, or fewer N)"
            raise SetError("tightening", tightening, expected)
    every = np.vstack([steady, *blocks[: last + 1]])
    names = [("steady state", -1), *((kind, t) for t in range(last + 1) for kind in KINDS)]
    kept = remove_redundant_pairs(every)
    rows = every[kept]
    n = slow.order
    return ExtendedSet(
        h_x=read_only(rows[:, :n]),
        h_aux=read_only(rows[:, n:-1]),
        h_rho=read_only(rows[:, -1] - rows[:, 0]),
        centre_m=centre_m,
        limits=limits,
        auxiliary=auxiliary,
        sub_samples=sub_samples,
        sample_time_s=sample_time_s,
        tightening=tightening,
        sources=tuple(names[i] for i in kept),
        last_instant=last,
        inequalities=2 * len(every),
        lp_count=lp_count + len(every),
    )


def instants(
    slow: StateSpace,
    sample_time_s: float,
    auxiliary: AuxiliaryDynamics,
    sub_samples: int,
    limits: AxisLimits,
) -> Iterator[FloatArray]:
    """(3, n + aux + 1) position, velocity and acceleration at instants 0, 1, 2, ... without end, in
    (e, v, a, ..., x_aux, rho'), each divided by its limit."""
    n, size = slow.order, slow.order + auxiliary.order + 1
    shift_rows(discretise(slow, sample_time_s), limits)
    step = discretise(slow, sample_time_s / sub_samples)
    outputs = shift_rows(step, limits)[:3]
    state, on_rho = np.eye(n, size), outputs[:, -1]
    drive = auxiliary.c.copy()
    while True:
        for _ in range(sub_samples):
            rows = outputs[:, :n] @ state
            rows[:, -1] += on_rho
            yield rows
            state = step.a @ state
            state[:, n:-1] += np.outer(step.b, drive)
        drive = drive @ auxiliary.a
