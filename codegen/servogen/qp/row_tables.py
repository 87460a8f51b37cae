"""The rows A of a condensed program as the emitted solver multiplies with them.

Rows of a condensed MPC are outputs of a plant that starts at rest: A z is the plant driven by z.
Running it costs N (n + outputs)(n + 1) products instead of m N, and single rows are pieces of a few
impulse responses. Rows of any other kind are columns whose leading zeros, the causal triangle's,
are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.ordered import dot, matvec


class RowTables(Protocol):
    """What the active-set method asks of m rows of N variables."""

    @property
    def count(self) -> int:
        """m."""
        ...

    @property
    def variables(self) -> int:
        """N."""
        ...

    def product(self, z: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """A z, (m,), of ``z`` (N,), with what a plant adds that does not start at rest."""
        ...

    def row(self, i: int) -> FloatArray:
        """Row i up to its last entry that is not zero by structure, (length,)."""
        ...

    def dot(self, i: int, v: FloatArray) -> np.floating:
        """Row i times ``v`` (N,), from the first variable to the last."""
        ...

    def shifted(self, i: int) -> int:
        """The row that i is one sample later; -1 where it is past, i itself where it stays."""
        ...


@dataclass(frozen=True)
class StageRows:
    """Rows of a plant that is driven by z: the same outputs at every step, then terminal ones.

    At step k = 1..N, (x_k, e_k) = stage (x_{k-1}, z_{k-1}); the rows of the step are the first
    ``limited`` entries of x_k and all of e_k; those of the end are terminal x_N.

    Attributes:
        stage: (n + extra, n + 1), scaled so that its outputs are rows.
        terminal: (t, n).
        impulse: (limited + extra, N), response of a step's rows to the input d steps before.
        terminal_rows: (t, N), the same rows written out.
        horizon: N. limited: how many states are rows.
    """

    stage: FloatArray
    terminal: FloatArray
    impulse: FloatArray
    terminal_rows: FloatArray
    horizon: int
    limited: int

    @property
    def order(self) -> int:
        """n."""
        return int(self.stage.shape[1]) - 1

    @property
    def per_step(self) -> int:
        """Rows of one step."""
        return int(self.impulse.shape[0])

    @property
    def stages(self) -> int:
        """Rows of all steps: the terminal ones come after them."""
        return self.horizon * self.per_step

    @property
    def count(self) -> int:
        """m."""
        return self.stages + int(self.terminal.shape[0])

    @property
    def variables(self) -> int:
        """N."""
        return self.horizon

    def product(self, z: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """A z + what the state ``start`` (n,) adds, (m,)."""
        real, n = self.stage.dtype, self.order
        x = np.zeros(n, dtype=real) if start is None else start
        columns = self.stage.T
        result = np.empty(self.count, dtype=real)
        for k in range(self.horizon):
            ahead = matvec(columns, np.append(x, z[k]))
            x = ahead[:n]
            at = k * self.per_step
            result[at : at + self.limited] = x[: self.limited]
            result[at + self.limited : at + self.per_step] = ahead[n:]
        if self.terminal.shape[0]:
            result[self.stages :] = matvec(self.terminal.T, x)
        return result

    def row(self, i: int) -> FloatArray:
        """Row i up to its last entry, (length,)."""
        if i >= self.stages:
            return np.asarray(self.terminal_rows[i - self.stages])
        step, output = divmod(i, self.per_step)
        return np.asarray(self.impulse[output, step::-1])

    def dot(self, i: int, v: FloatArray) -> np.floating:
        """Row i times ``v``."""
        row = self.row(i)
        return dot(row, v[: row.size])

    def shifted(self, i: int) -> int:
        """The row one sample later: a step's moves one step on, a terminal one stays."""
        if i >= self.stages:
            return i
        return i - self.per_step if i >= self.per_step else -1


def stage_rows(
    stage: FloatArray,
    terminal: FloatArray,
    horizon: int,
    limited: int,
    dtype: np.dtype[np.floating],
) -> StageRows:
    """Rows of a plant, its responses computed in float64 and everything rounded once.

    Args: as the attributes of ``StageRows``.
    """
    n = stage.shape[1] - 1
    response = np.zeros((stage.shape[0], horizon))
    x, state = stage[:, n], np.zeros((n, horizon))
    for d in range(horizon):
        response[:, d], state[:, d] = x, x[:n]
        x = stage[:, :n] @ x[:n]
    rows = [*range(limited), *range(n, stage.shape[0])]

    def rounded(values: FloatArray) -> FloatArray:
        array = np.ascontiguousarray(values, dtype=dtype)
        array.flags.writeable = False
        return array

    written = terminal @ state[:, ::-1]
    return StageRows(
        rounded(stage), rounded(terminal), rounded(response[rows]), rounded(written), horizon,
        limited,
    )  # fmt: skip


@dataclass(frozen=True)
class ColumnRows:
    """Rows without a plant: ``columns`` (N, m) = A', column j zero above row ``first[j]``.

    ``first`` (N,) never falls. ``per_step`` rows belong to one sample of a horizon that moves on
    and the last ``staying`` to none; 0: the rows are the same ones at every call.
    """

    columns: FloatArray
    first: tuple[int, ...]
    per_step: int = 0
    staying: int = 0

    @property
    def count(self) -> int:
        """m."""
        return int(self.columns.shape[1])

    @property
    def variables(self) -> int:
        """N."""
        return int(self.columns.shape[0])

    def product(self, z: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """A z, (m,); there is no plant to start."""
        assert start is None
        result = np.zeros(self.count, dtype=self.columns.dtype)
        for column, first, value in zip(self.columns, self.first, z, strict=True):
            result[first:] += column[first:] * value
        return result

    def row(self, i: int) -> FloatArray:
        """Row i up to its last entry, (length,)."""
        return np.asarray(self.columns[: sum(first <= i for first in self.first), i])

    def dot(self, i: int, v: FloatArray) -> np.floating:
        """Row i times ``v``."""
        row = self.row(i)
        return dot(row, v[: row.size])

    def shifted(self, i: int) -> int:
        """The row one sample later."""
        if self.per_step == 0 or i >= self.count - self.staying:
            return i
        return i - self.per_step if i >= self.per_step else -1


def column_rows(
    rows: FloatArray, dtype: np.dtype[np.floating], per_step: int = 0, staying: int = 0
) -> ColumnRows:
    """The rows A (m, N), rounded once; leading zeros of a column that no later column lacks."""
    columns = np.ascontiguousarray(rows.T, dtype=dtype)
    columns.flags.writeable = False
    first = []
    for column in columns:
        places = np.flatnonzero(column)
        first.append(int(places[0]) if places.size else rows.shape[0] - 1)
    # a column may begin no later than the ones after it: rows are then prefixes
    least = np.minimum.accumulate(np.array(first)[::-1])[::-1]
    return ColumnRows(columns, tuple(int(i) for i in least), per_step, staying)
