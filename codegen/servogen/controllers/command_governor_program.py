"""Quadratic program (17) of one axis of the extended command governor, as rows of its plant.

With a shift register the decisions are the commands v(0), ..., v(n-1) of the next n periods and
rho, the one held from then on; the register's entries are v(k) - rho. So written, every row of
P-tilde is an output of the stage driven by the decisions: position and velocity at each of the N
instants of a period, and a few more after the last one. The stroke rows S_k are the position rows
at the ends of the periods once more, with bounds that change from call to call; so are, if asked
for, those between. No row is added for them.

The cost N sum (x_k - (r_k - r_n))^2 + R (rho - r_n)^2 is least at v = r: the unconstrained optimum
is the reference itself.

What S_k and the set do not say: a plan that ends near the last point it machines, but leaves it
afterwards, could not be continued. So the point is held for ever: by position rows after the last
period, as many as it takes to come within ``SETTLED`` of rho, and by rho itself, which stays
``settle_m`` away from the end of the stroke because the stage is never farther from it then.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
import numpy.typing as npt

from servogen.controllers.errors import DesignError
from servogen.plants.statespace import FloatArray, StateSpace, discretise, read_only
from servogen.qp.row_tables import StageRows, stage_rows
from servogen.sets.extended import KINDS, ExtendedSet, instants
from servogen.sets.polyhedron import maximise

IntArray = npt.NDArray[np.int64]

# Share of the stroke that may be left between stage and rho where position rows end. It is lost to
# the reach of every plan, at 25 mm 25 um of the millimetre by which a path that needs the whole
# stroke creeps on from plan to plan; each row more halves it.
SETTLED = 0.001
# Instants after the last ones that the set needs, among which that is looked for, and over how many
# it is seen to last.
SETTLING, LASTS = 300, 20


@dataclass(frozen=True)
class GovernorWeights:
    """Of (17): ``auxiliary`` on each of the N n entries, the same ones N at a time, ``reference``
    on rho. Q-bar = I and R-bar = 0.01 in the paper."""

    auxiliary: float = 1.0
    reference: float = 0.01


@dataclass(frozen=True)
class GovernorProgram:
    """One axis. V = n + 1 commands, in metres less the present position p; m two-sided rows.

    Positions are rows in shares of the stroke, velocities and accelerations in shares of their
    limits. Interval i lasts from sample i to i + 1, i = 0..n; interval n + 1 is all that follows.

    Attributes:
        hessian: (V, V). rows: A, ``written`` (m, V) the same written out, not rounded.
        state_scale: (n_x + 1,) what the state is divided by to become the rows' start; the last
            one holds the command of the period before.
        limit: (m,) of |row|, of positions about the middle of their range.
        position: (m,) 1 for a row that moves with p, else 0.
        first, second: (m,) intervals whose stroke bounds the row; -1: none.
        settle: (m,) by how much the stroke is shorter for it, in shares.
        centre_m: middle of the position range; stroke_m: the stroke less the margin asked for.
        settle_m: see above.
    """

    hessian: FloatArray
    rows: StageRows
    written: FloatArray
    state_scale: FloatArray
    limit: FloatArray
    position: FloatArray
    first: IntArray
    second: IntArray
    settle: FloatArray
    centre_m: float
    stroke_m: float
    scale_m: float
    settle_m: float

    @property
    def variables(self) -> int:
        """V."""
        return int(self.hessian.shape[0])


@dataclass(frozen=True)
class _Row:
    """Kind, limit and the intervals whose stroke bounds it."""

    kind: str
    limit: float
    first: int = -1
    second: int = -1
    settle: float = 0.0


def governor_program(
    slow: StateSpace,
    admissible: ExtendedSet,
    weights: GovernorWeights,
    sub_step_stroke: bool,
    margin_m: float,
    dtype: np.dtype[np.floating],
) -> GovernorProgram:
    """Rows and cost of (17).

    Args:
        admissible: of a shift register.
        sub_step_stroke: the stroke holds at the N instants of every period, not at its ends alone.
        margin_m: the stroke is shorter by so much.
        dtype: of ``rows``.

    Raises:
        DesignError: a set of other auxiliary dynamics, weights that are not positive, a margin or
            a settling that leaves no stroke, or a stage too slow for the horizon.
    """
    horizon, stroke = _checked(admissible, weights, margin_m)
    after, settle = _settling(slow, admissible, 1 if sub_step_stroke else admissible.sub_samples)
    scale = _scale(slow.order, admissible)
    stage, of_step = _step_rows(slow, admissible, scale, sub_step_stroke)
    last, of_end = _end_rows(slow, admissible, scale, after)
    layout = _layout(admissible, of_step, of_end, sub_step_stroke, settle)
    limited = sum(sub == admissible.sub_samples for _, sub in of_step)
    rows = stage_rows(stage, last, horizon + 1, limited, dtype)
    exact = stage_rows(stage, last, horizon + 1, limited, np.dtype(np.float64))
    written = np.zeros((rows.count, horizon + 1))
    for i in range(rows.count):
        own = exact.row(i)
        written[i, : own.size] = own
    return GovernorProgram(
        hessian=read_only(_hessian(horizon, admissible.sub_samples, weights)),
        rows=rows,
        written=read_only(written),
        state_scale=read_only(scale),
        limit=read_only([row.limit for row in layout]),
        position=read_only([float(row.kind == "position") for row in layout]),
        first=np.array([row.first for row in layout], dtype=np.int64),
        second=np.array([row.second for row in layout], dtype=np.int64),
        settle=read_only([row.settle for row in layout]),
        centre_m=admissible.centre_m,
        stroke_m=stroke,
        scale_m=admissible.limits.fast_range_m,
        settle_m=settle,
    )


def _checked(
    admissible: ExtendedSet, weights: GovernorWeights, margin_m: float
) -> tuple[int, float]:
    """Periods of the register and stroke, m."""
    horizon = admissible.auxiliary.order
    if horizon < 1 or admissible.auxiliary.settled != horizon:
        raise DesignError("auxiliary", admissible.auxiliary.name, "a shift register")
    for name in ("auxiliary", "reference"):
        value = getattr(weights, name)
        if not (np.isfinite(value) and value > 0.0):
            raise DesignError(f"weights.{name}", value, "a positive finite weight")
    stroke = admissible.limits.fast_range_m - margin_m
    if not (margin_m >= 0.0 and stroke > 0.0):
        expected = f"from zero to below {admissible.limits.fast_range_m:g} m"
        raise DesignError("stroke_margin_m", margin_m, expected)
    return horizon, stroke


def _settling(
    slow: StateSpace, admissible: ExtendedSet, every: int
) -> tuple[tuple[int, ...], float]:
    """Instants at which position rows are added to the set's, one in ``every``, and the greatest
    |p - rho|, m, over the set at all instants after them.

    Raises:
        DesignError: the stage does not come near its command.
    """
    allowed = SETTLED * admissible.limits.fast_range_m
    end = (admissible.auxiliary.order + 1) * admissible.sub_samples
    start = max(admissible.last_instant, end) + 1
    rows = admissible.rows
    both, ones = np.vstack([rows, -rows]), np.ones(2 * len(rows))
    following = instants(
        slow, admissible.sample_time_s, admissible.auxiliary, admissible.sub_samples,
        admissible.limits,
    )  # fmt: skip
    first, settle = start, 0.0
    for t, block in enumerate(islice(following, start + SETTLING)):
        if t < start:
            continue
        error = block[0] * admissible.limits.position_m
        error[-1] = -error[0]  # e = p' - rho'
        left = maximise(both, ones, error).value
        if left > allowed:
            first, settle = t + 1, 0.0
        else:
            settle = max(settle, left)
        if t + 1 == first + LASTS:
            break
    else:
        expected = f"a stage that is within {allowed:.3g} m of its command soon after its periods"
        raise DesignError("horizon", None, expected)
    known = {t for kind, t in admissible.sources if kind == "position"}
    added = [t for t in range(end + every, first, every) if t not in known]
    return tuple(added), settle


def _scale(order: int, admissible: ExtendedSet) -> FloatArray:
    limits = admissible.limits
    scale = np.full(order + 1, limits.acceleration_m_per_s2)
    scale[:2] = limits.fast_range_m, limits.velocity_m_per_s
    scale[-1] = limits.fast_range_m
    return scale


def _step_rows(
    slow: StateSpace, admissible: ExtendedSet, scale: FloatArray, sub_step_stroke: bool
) -> tuple[FloatArray, list[tuple[str, int]]]:
    """The plant of one period with the rows inside it, and kind and instant of every row: those at
    the end first. A kind has rows at an instant where the set has one in some period, or where the
    stroke holds."""
    n, subs = slow.order, admissible.sub_samples
    asked = {
        (kind, (t - 1) % subs + 1)
        for kind, t in admissible.sources
        if 1 <= t <= (admissible.auxiliary.order + 1) * subs
    }
    asked |= {("position", sub) for sub in range(1 if sub_step_stroke else subs, subs + 1)}
    # the states that are rows are the first ones: an acceleration brings a velocity with it
    count = 1 + max(i for i, kind in enumerate(KINDS) if (kind, subs) in asked)
    of_step = [(kind, subs) for kind in KINDS[:count]]
    of_step += [(k, s) for s in range(1, subs) for k in KINDS if (k, s) in asked]
    unscale = np.append(scale, 1.0)
    held = discretise(slow, admissible.sample_time_s)
    stage = np.zeros((n + 1, n + 2))
    stage[:n, :n], stage[:n, -1], stage[n, -1] = held.a, held.b, 1.0
    parts = [stage * unscale / scale[:, None]]
    for kind, sub in of_step[count:]:
        i, part = KINDS.index(kind), discretise(slow, admissible.sample_time_s * sub / subs)
        row = np.concatenate([part.a[i], [0.0, part.b[i]]])
        parts.append((row * unscale / scale[i])[None, :])
    return np.vstack(parts), of_step


def _end_rows(
    slow: StateSpace, admissible: ExtendedSet, scale: FloatArray, after: tuple[int, ...]
) -> tuple[FloatArray, list[tuple[str, int]]]:
    """Rows after the last period, on its end and the command held there, with kind and instant of
    each; V', as the last one, has none."""
    subs = admissible.sub_samples
    end = (admissible.auxiliary.order + 1) * subs
    rows, of_end = [], []
    for kind, t in [*admissible.sources, *(("position", t) for t in after)]:
        if t > end:
            part = discretise(slow, admissible.sample_time_s * (t - end) / subs)
            i = KINDS.index(kind)
            rows.append(np.append(part.a[i], part.b[i]) * scale / scale[i])
            of_end.append((kind, t))
    rows.append(np.eye(slow.order + 1)[-1])
    return np.array(rows), of_end


def _layout(
    admissible: ExtendedSet,
    of_step: list[tuple[str, int]],
    of_end: list[tuple[str, int]],
    sub_step_stroke: bool,
    settle: float,
) -> list[_Row]:
    """What bounds each row, in their order."""
    horizon, subs = admissible.auxiliary.order, admissible.sub_samples
    reach = admissible.limits.position_m / admissible.limits.fast_range_m
    hold, layout = horizon + 1, []
    for i in range(horizon + 1):
        for kind, sub in of_step:
            if kind != "position":
                layout.append(_Row(kind, 1.0))
            elif sub == subs:
                layout.append(_Row(kind, reach, i, i + 1))
            else:
                own = i if sub_step_stroke else -1
                layout.append(_Row(kind, reach, own, own))
    for kind, t in of_end:
        position = kind == "position"
        at = hold if position and (sub_step_stroke or t % subs == 0) else -1
        layout.append(_Row(kind, reach if position else 1.0, at, at))
    steady = (1.0 - admissible.tightening) * reach
    share = settle / admissible.limits.fast_range_m
    layout.append(_Row("position", steady, hold, hold, share))
    return layout


def _hessian(horizon: int, sub_samples: int, weights: GovernorWeights) -> FloatArray:
    """2 T' diag(N q, ..., N q, R) T with x_k = v_k - rho: N equal entries of the register of
    instants are one decision."""
    to_register = np.eye(horizon + 1)
    to_register[:-1, -1] = -1.0
    cost = np.full(horizon + 1, sub_samples * weights.auxiliary)
    cost[-1] = weights.reference
    hessian: FloatArray = 2.0 * (to_register.T * cost) @ to_register
    return hessian
