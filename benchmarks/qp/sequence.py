"""A sequence of quadratic programs that differ in f and the bounds, and its optima."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import daqp
import numpy as np
from scipy.linalg import solve_discrete_are

from servogen.qp.row_tables import StageRows, stage_rows

Array = np.ndarray
# A reference optimum misses its conditions by no more than this share of the sizes met.
REFERENCE = 1e-10
FAR = 1e17  # a bound that is none


@dataclass(frozen=True)
class StagePlant:
    """The plant behind the rows; see ``servogen.qp.row_tables.stage_rows``."""

    stage: Array
    terminal: Array
    limited: int
    inputs: int = 1
    outer: Array | None = None
    bounds: Array | None = None

    def rows(self, variables: int) -> StageRows:
        return stage_rows(
            self.stage, self.terminal, variables // self.inputs, self.limited, np.dtype(float),
            self.inputs, self.outer, self.bounds,
        )  # fmt: skip


@dataclass(frozen=True)
class Stated:
    """The plant and boxes that a program was condensed from, where boxes are all it has.

    Cost: sum of x_k'Qx_k + u_k'Ru_k with x_N weighted by P - rho I, P the solution of the Riccati
    equation with Q + rho I, R + rho I: what TinyMPC's method presumes. x, u: less where the
    plant is to rest.

    Attributes:
        a: (n, n); b: (n, p); q: (n,); r: (p,) diagonals.
        start: (T, n) x_0; state_low, state_high: (T, n) at x_1..x_N; input_low, input_high: (T, p).
    """

    a: Array
    b: Array
    q: Array
    r: Array
    rho: float
    start: Array
    state_low: Array
    state_high: Array
    input_low: Array
    input_high: Array

    def write(self, path: Path, part: slice, horizon: int) -> None:
        """For tinympc_peer.cpp."""
        n, p = self.b.shape
        both = solve_discrete_are(
            self.a, self.b, np.diag(self.q + self.rho), np.diag(self.r + self.rho)
        )
        pressed = np.linalg.inv(np.diag(self.r + self.rho) + self.b.T @ both @ self.b)
        gain = pressed @ self.b.T @ both @ self.a
        steps = self.start[part]
        none = np.full_like(steps, FAR)
        columns = [
            steps,
            -none, np.tile(self.state_low[part], (1, horizon)),
            none, np.tile(self.state_high[part], (1, horizon)),
            np.tile(self.input_low[part], (1, horizon)),
            np.tile(self.input_high[part], (1, horizon)),
        ]  # fmt: skip
        with path.open("wb") as out:
            np.array([n, p, horizon + 1, len(steps)], dtype=np.int32).tofile(out)
            for value in (self.a, self.b, self.q, self.r, np.array([self.rho]), gain, both, pressed,
                          (self.a - self.b @ gain).T, np.hstack(columns)):  # fmt: skip
                np.ascontiguousarray(value, dtype=float).tofile(out)


@dataclass(frozen=True)
class Sequence:
    """min 1/2 z'Hz + f_t'z subject to low_t <= A z <= high_t, t = 0..T-1.

    Attributes:
        source: where it is from, one sentence.
        hessian: (n, n); rows: (m, n); linear: (T, n); low, high: (T, m), all finite.
        per_step, staying: rows of one sample of the horizon, and of none.
        plant: where the rows are outputs of a single-input plant.
        stated: where TinyMPC can state it.
    """

    name: str
    source: str
    hessian: Array
    rows: Array
    linear: Array
    low: Array
    high: Array
    per_step: int
    staying: int
    plant: StagePlant | None = None
    stated: Stated | None = None
    optimum: Array = field(default_factory=lambda: np.zeros((0, 0)))
    active: Array = field(default_factory=lambda: np.zeros(0, dtype=int))

    @property
    def variables(self) -> int:
        return int(self.hessian.shape[0])

    @property
    def count(self) -> int:
        """Two-sided rows."""
        return int(self.rows.shape[0])

    @property
    def horizon(self) -> int:
        """Of ``stated``."""
        return 0 if self.stated is None else self.variables // int(self.stated.b.shape[1])

    @property
    def length(self) -> int:
        return int(self.linear.shape[0])

    def window(self, steps: int) -> slice:
        """So many consecutive programs around the one with the largest working set."""
        start = int(np.argmax(self.active)) - steps // 2
        start = max(0, min(start, self.length - steps))
        return slice(start, min(start + steps, self.length))

    def write(self, path: Path, part: slice) -> None:
        """For the C programs: int32 n, m, T; H; A; then f, low, high of every program."""
        steps = np.hstack([self.linear[part], self.low[part], self.high[part]])
        with path.open("wb") as out:
            np.array([self.variables, self.count, len(steps)], dtype=np.int32).tofile(out)
            np.ascontiguousarray(self.hessian).tofile(out)
            np.ascontiguousarray(self.rows).tofile(out)
            np.ascontiguousarray(steps).tofile(out)


def two_sided(rows: Array) -> tuple[Array, Array]:
    """Of one-sided rows the numbers of those that point up, and of their opposites.

    Raises:
        ValueError: a row without an opposite. Rows of zeros are left out.
    """
    first, second = [], []
    for i, row in enumerate(rows):
        own = np.flatnonzero(row)
        if own.size and row[own[0]] > 0.0:
            opposite = np.flatnonzero(np.all(rows == -row, axis=1))
            opposite = opposite[~np.isin(opposite, second)]
            if not opposite.size:
                raise ValueError(f"row {i} has no opposite")
            first.append(i)
            second.append(int(opposite[0]))
    return np.array(first), np.array(second)


def solve_reference(
    hessian: Array, rows: Array, linear: Array, low: Array, high: Array
) -> tuple[Array, Array]:
    """z (n,) and the working set: DAQP's set, its equations solved afresh and the result judged."""
    linear, low, high = map(
        np.ascontiguousarray, (linear, low, high)
    )  # DAQP reads on without strides
    sense = np.zeros(len(rows), dtype=np.int32)
    z, _, flag, info = daqp.solve(
        hessian, linear, np.ascontiguousarray(rows), high, low, sense, primal_tol=1e-11
    )
    if flag != 1:
        raise ArithmeticError(f"no reference optimum: DAQP ends with {flag}")
    dual = np.asarray(info["lam"])
    held = np.flatnonzero(dual)
    bound = np.where(dual > 0.0, high, low)[held]
    n, q = len(z), held.size
    matrix = np.block([[hessian, rows[held].T], [rows[held], np.zeros((q, q))]])
    right = np.concatenate([-linear, bound])
    unit = 1.0 / np.sqrt(np.abs(matrix).max(axis=1))
    scaled = matrix * np.outer(unit, unit)
    both = unit * np.linalg.lstsq(scaled, unit * right, rcond=None)[0]
    both += unit * np.linalg.lstsq(scaled, unit * (right - matrix @ both), rcond=None)[0]
    polished, multiplier = both[:n], both[n:] * np.sign(dual[held])
    size = 1.0 + np.max(np.abs(np.concatenate([linear, bound])), initial=0.0)
    at = rows @ polished
    missed = max(
        float(np.max(np.maximum(at - high, low - at), initial=0.0)),
        float(np.max(-multiplier, initial=0.0)) / (1.0 + np.max(np.abs(dual))),
        float(np.max(np.abs(right - matrix @ both))) / size,
    )
    if missed > REFERENCE * size:
        raise ArithmeticError(f"the reference optimum misses its conditions by {missed:.1e}")
    return polished, held


def with_optima(sequence: Sequence) -> Sequence:
    """The sequence with its optima and the sizes of their working sets."""
    solved = [
        solve_reference(sequence.hessian, sequence.rows, f, low, high)
        for f, low, high in zip(sequence.linear, sequence.low, sequence.high, strict=True)
    ]
    kept = {name: getattr(sequence, name) for name in sequence.__dataclass_fields__}
    kept |= {"optimum": np.array([z for z, _ in solved])}
    kept |= {"active": np.array([held.size for _, held in solved])}
    return Sequence(**kept)
