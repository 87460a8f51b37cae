"""The rows A of a condensed program as the emitted solver multiplies with them.

Rows of a condensed MPC are outputs of a plant that starts at rest: A z is the plant driven by z.
Running it costs a step's products at every step, those with zero left out, instead of m N, and
single rows are pieces of a few impulse responses. Rows of any other kind are columns whose leading
zeros, the causal triangle's, are left out. With either, a row that bounds a single variable costs
one product.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.errors import ProgramError
from servogen.qp.ordered import dot, matvec
from servogen.qp.stage_arguments import stage_arguments


class RowTables(Protocol):
    """What a method asks of m rows of N variables."""

    @property
    def count(self) -> int:
        """m."""
        ...

    @property
    def variables(self) -> int:
        """N."""
        ...

    @property
    def alone(self) -> int:
        """How many are declared as bounds of single variables."""
        ...

    def product(self, z: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """A z, (m,), of ``z`` (N,), with what a plant adds that does not start at rest."""
        ...

    def adjoint(self, y: FloatArray) -> FloatArray:
        """A'y, (N,), of ``y`` (m,)."""
        ...

    def row(self, i: int) -> FloatArray:
        """Row i up to its last entry that is not zero by structure, (length,)."""
        ...

    def begin(self, i: int) -> int:
        """Where row i begins: its entries before are zero by structure."""
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

    z holds the inputs of step 1, then those of step 2, ... At step k, x_k = stage (x_{k-1}, u_k),
    and the rows of the step are ``bounds`` times the first inputs of u_k, the first ``limited``
    entries of x_k, inner (x_{k-1}, u_k) and outer (x_k, u_k); those of the end are terminal x_N.

    Attributes:
        stage: (n, n + inputs), scaled so that its states are rows.
        inner, outer: (any, n + inputs).
        terminal: (t, n).
        bounds: (at most inputs,).
        impulse: (rows of a step but for the bounds, N), responses to the inputs so many steps
            before: those to the inputs of the same step, from the last one to the first, then
            those to the step before, ...
        terminal_rows: (t, N), the same of the terminal rows.
        steps: of the horizon. limited: how many states are rows. inputs: of one step.
    """

    stage: FloatArray
    inner: FloatArray
    outer: FloatArray
    terminal: FloatArray
    bounds: FloatArray
    impulse: FloatArray
    terminal_rows: FloatArray
    steps: int
    limited: int
    inputs: int

    @property
    def order(self) -> int:
        """n."""
        return int(self.stage.shape[0])

    @property
    def per_step(self) -> int:
        """Rows of one step."""
        return int(self.bounds.size + self.impulse.shape[0])

    @property
    def stages(self) -> int:
        """Rows of all steps: the terminal ones come after them."""
        return self.steps * self.per_step

    @property
    def count(self) -> int:
        """m."""
        return self.stages + int(self.terminal.shape[0])

    @property
    def variables(self) -> int:
        """N."""
        return self.steps * self.inputs

    @property
    def alone(self) -> int:
        """Bounds of all steps."""
        return self.steps * int(self.bounds.size)

    def product(self, z: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """A z + what the state ``start`` (n,) adds, (m,)."""
        real, n, b = self.stage.dtype, self.order, self.bounds.size
        x = np.zeros(n, dtype=real) if start is None else start
        ahead, after = np.vstack([self.stage, self.inner]).T, self.outer.T
        result = np.empty(self.count, dtype=real)
        for k in range(self.steps):
            u = z[k * self.inputs : (k + 1) * self.inputs]
            moved = matvec(ahead, np.append(x, u))
            x = moved[:n]
            rows = result[k * self.per_step : (k + 1) * self.per_step]
            rows[:b] = self.bounds * u[:b]
            rows[b : b + self.limited] = x[: self.limited]
            rows[b + self.limited : self.per_step - self.outer.shape[0]] = moved[n:]
            if self.outer.shape[0]:
                rows[self.per_step - self.outer.shape[0] :] = matvec(after, np.append(x, u))
        if self.terminal.shape[0]:
            result[self.stages :] = matvec(self.terminal.T, x)
        return result

    def adjoint(self, y: FloatArray) -> FloatArray:
        """A'y, (N,): the plant run backwards, driven by what weighs on its outputs."""
        real, n, b, last = self.stage.dtype, self.order, self.bounds.size, self.outer.shape[0]
        ahead, result = np.vstack([self.stage, self.inner]), np.empty(self.variables, dtype=real)
        x = np.zeros(n, dtype=real)
        if self.terminal.shape[0]:
            x = matvec(self.terminal, y[self.stages :])
        for k in range(self.steps - 1, -1, -1):
            own = y[k * self.per_step : (k + 1) * self.per_step]
            x[: self.limited] += own[b : b + self.limited]
            after = np.zeros(n + self.inputs, dtype=real)
            if last:
                after = matvec(self.outer, own[self.per_step - last :])
                x = x + after[:n]
            before = matvec(ahead, np.append(x, own[b + self.limited : self.per_step - last]))
            x, u = before[:n], before[n:] + after[n:]
            u[:b] += self.bounds * own[:b]
            result[k * self.inputs : (k + 1) * self.inputs] = u
        return result

    def row(self, i: int) -> FloatArray:
        """Row i up to its last entry, (length,)."""
        if i >= self.stages:
            return np.asarray(self.terminal_rows[i - self.stages, ::-1])
        step, output = divmod(i, self.per_step)
        if output < self.bounds.size:
            own = np.zeros(step * self.inputs + output + 1, dtype=self.bounds.dtype)
            own[-1] = self.bounds[output]
            return own
        last = (step + 1) * self.inputs - 1
        return np.asarray(self.impulse[output - self.bounds.size, last::-1])

    def begin(self, i: int) -> int:
        """Where row i begins."""
        step, output = divmod(i, self.per_step)
        alone = i < self.stages and output < self.bounds.size
        return step * self.inputs + output if alone else 0

    def dot(self, i: int, v: FloatArray) -> np.floating:
        """Row i times ``v``."""
        row, begin = self.row(i), self.begin(i)
        return dot(row[begin:], v[begin : row.size])

    def shifted(self, i: int) -> int:
        """The row one sample later: a step's moves one step on, a terminal one stays."""
        if i >= self.stages:
            return i
        return i - self.per_step if i >= self.per_step else -1


def stage_rows(
    stage: FloatArray,
    terminal: FloatArray,
    steps: int,
    limited: int,
    dtype: np.dtype[np.floating],
    inputs: int = 1,
    outer: FloatArray | None = None,
    bounds: FloatArray | None = None,
) -> StageRows:
    """Rows of a plant, its responses computed in float64 and everything rounded once.

    Args:
        stage: (n + any, n + inputs): ``stage`` and ``inner`` of ``StageRows``, one upon the other.
        terminal, limited, inputs, outer, bounds: as its attributes; None: no such rows.

    Raises:
        ProgramError: an argument cannot be used, or not with the others; responses are no numbers
            in ``dtype``; all rows are bounds or all are terminal: they need no plant.
    """
    stage, terminal, after, factors, real = stage_arguments(
        stage, terminal, steps, limited, dtype, inputs, outer, bounds
    )
    n = stage.shape[1] - inputs
    ahead, inner = stage[:n], stage[n:]
    states = limited + len(inner) + len(after)
    if not states and not (factors.size and len(terminal)):
        found = "terminal ones alone" if len(terminal) else "bounds of variables alone"
        expected = "some of the states of a step, or else a program by design_qp_solver(bounds=...)"
        raise ProgramError("rows", found, expected)
    state, moved = np.zeros((n, inputs)), ahead[:, n:]
    impulse, last = [], []
    with np.errstate(all="ignore"):  # what is no number is refused below
        for d in range(steps):
            direct = np.eye(inputs) if d == 0 else np.zeros((inputs, inputs))
            before, now = np.vstack([state, direct]), np.vstack([moved, direct])
            rows = np.vstack([moved[:limited], inner @ before, after @ now])
            impulse.append(rows[:, ::-1])
            last.append((terminal @ moved)[:, ::-1])
            state, moved = moved, ahead[:, :n] @ moved
        largest = max(
            float(np.max(np.abs(np.hstack(kind)), initial=0.0)) for kind in (impulse, last)
        )
    if not largest <= float(np.finfo(real).max):
        said = f"such that its responses over {steps} steps lead beyond {real.name}"
        raise ProgramError("stage", said, "outputs and inputs scaled nearer to one")

    def rounded(values: FloatArray) -> FloatArray:
        array = np.ascontiguousarray(values, dtype=real)
        array.flags.writeable = False
        return array

    return StageRows(
        rounded(ahead), rounded(inner), rounded(after), rounded(terminal), rounded(factors),
        rounded(np.hstack(impulse)), rounded(np.hstack(last)), steps, limited, inputs,
    )  # fmt: skip


@dataclass(frozen=True)
class ColumnRows:
    """Rows without a plant: first ``bounds`` times variable 0, 1, ..., then ``columns``.

    ``columns`` (N, m - bounds), transposed; column j is zero above row ``first[j]``, which never
    falls. One sample of a horizon that moves on has ``inputs`` variables and ``per_step`` rows that
    are no bounds; the last ``staying`` rows belong to none; 0 and 0: all rows are the same ones at
    every call.
    """

    bounds: FloatArray
    columns: FloatArray
    first: tuple[int, ...]
    per_step: int = 0
    staying: int = 0
    inputs: int = 0

    @property
    def count(self) -> int:
        """m."""
        return int(self.bounds.size + self.columns.shape[1])

    @property
    def variables(self) -> int:
        """N."""
        return int(self.columns.shape[0])

    @property
    def alone(self) -> int:
        """The first rows."""
        return int(self.bounds.size)

    def product(self, z: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """A z, (m,); there is no plant to start."""
        assert start is None
        b = self.bounds.size
        result = np.zeros(self.count, dtype=self.columns.dtype)
        result[:b] = self.bounds * z[:b]
        for column, first, value in zip(self.columns, self.first, z, strict=True):
            result[b + first :] += column[first:] * value
        return result

    def adjoint(self, y: FloatArray) -> FloatArray:
        """A'y, (N,)."""
        b = self.bounds.size
        result = np.array(
            [
                dot(column[first:], y[b + first :])
                for column, first in zip(self.columns, self.first, strict=True)
            ]
        )
        result[:b] += self.bounds * y[:b]
        return result

    def row(self, i: int) -> FloatArray:
        """Row i up to its last entry, (length,)."""
        if i < self.bounds.size:
            own = np.zeros(i + 1, dtype=self.bounds.dtype)
            own[i] = self.bounds[i]
            return own
        i -= self.bounds.size
        return np.asarray(self.columns[: sum(first <= i for first in self.first), i])

    def begin(self, i: int) -> int:
        """Where row i begins."""
        return i if i < self.bounds.size else 0

    def dot(self, i: int, v: FloatArray) -> np.floating:
        """Row i times ``v``."""
        row, begin = self.row(i), self.begin(i)
        return dot(row[begin:], v[begin : row.size])

    def shifted(self, i: int) -> int:
        """The row one sample later."""
        if i < self.bounds.size:
            return i - self.inputs if i >= self.inputs else -1
        if self.per_step == 0 or i >= self.count - self.staying:
            return i
        return i - self.per_step if i >= self.bounds.size + self.per_step else -1


def column_rows(
    rows: FloatArray, dtype: np.dtype[np.floating], per_step: int = 0, staying: int = 0,
    bounds: int = 0, inputs: int = 0,
) -> ColumnRows:  # fmt: skip
    """The rows A (m, N), rounded once; leading zeros of a column that no later column lacks.

    Args:
        bounds: so many of the first rows bound variable 0, 1, ... by itself.
        per_step, staying, inputs: see ``ColumnRows``.

    Raises:
        ProgramError: one of the first ``bounds`` rows holds another variable.
    """
    if bounds > min(rows.shape):
        raise ProgramError("bounds", bounds, f"at most {min(rows.shape)} rows of one variable")
    alone = np.diagonal(rows)[:bounds]
    others = rows[:bounds].copy()
    np.fill_diagonal(others, 0.0)
    if np.any(others):
        i = int(np.flatnonzero(np.any(others, axis=1))[0])
        raise ProgramError(f"rows[{i}]", "of others too", f"a bound of one variable, number {i}")
    columns = np.ascontiguousarray(rows[bounds:].T, dtype=dtype)
    columns.flags.writeable = False
    first = []
    for column in columns:
        places = np.flatnonzero(column)
        first.append(int(places[0]) if places.size else max(column.size - 1, 0))
    # a column may begin no later than the ones after it: rows are then prefixes
    least = np.minimum.accumulate(np.array(first)[::-1])[::-1]
    factors = np.array(alone, dtype=dtype)
    factors.flags.writeable = False
    return ColumnRows(
        factors, columns, tuple(int(i) for i in least), per_step, staying, inputs
    )  # fmt: skip
