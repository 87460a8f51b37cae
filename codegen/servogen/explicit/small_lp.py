"""Linear programs of a few variables, many at once, by a dual simplex method that is checked.

Regions and trees ask for thousands of programs of three to ten variables. Calling HiGHS costs two
milliseconds each, nearly all of it set-up; here a whole batch goes through each step of the method
together. Every vertex returned passed a test of optimality (feasible, multipliers not negative,
stationary) on its basis solved afresh; what fails goes to ``servogen.sets.polyhedron``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.explicit.tolerances import LP_RESIDUAL
from servogen.plants.statespace import FloatArray
from servogen.sets.errors import EmptySetError, SetError
from servogen.sets.polyhedron import maximise

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]

# Walls |x_i| <= wall that give the method its first vertex; they are not part of the program. A
# vertex held by a wall is no answer: the next wall is tried, then HiGHS.
_WALLS = (1e2, 1e5, 1e8)
# A ball's program is left once its radius is shown to be below this: how far from having a point a
# set is may be millions (positions at opposite bounds in successive samples), and asks for
# multipliers that no double holds. Nothing but the sign of so small a radius is used.
_EMPTY = -1.0
_MAX_PIVOTS = 200
# Programs that go through the method together, so that their rows stay within some megabytes.
_BATCH = 256
# Of those, how many may be left for HiGHS. None are where planes can be told apart.
_HOPELESS = 48


@dataclass(frozen=True)
class Ball:
    """``centre`` (n,) and ``radius`` of a ball inside; negative if none, not above the cap."""

    centre: FloatArray
    radius: float


def greatest(h: FloatArray, k: FloatArray, objective: FloatArray) -> float:
    """Greatest ``objective`` . x over {h x <= k}: -inf if the set is empty, inf if unbounded or if
    no answer was found, so that nobody takes a row for redundant that may not be.

    Args:
        h: (rows, n), rows of about unit size; k: (rows,); objective: (n,).
    """
    return float(greatest_many(h, k[None], objective[None])[0])


def greatest_many(
    h: FloatArray,
    k: FloatArray,
    objectives: FloatArray,
    shared: FloatArray | None = None,
    floors: FloatArray | None = None,
) -> FloatArray:
    """The same for a batch: k (batch, rows), objectives (batch, n), h as k or one for all.

    ``shared`` (more, n) are further rows that all programs have; their bounds are last in k. A
    program shown to stay below its floor, (batch,), may be given any value between.
    """
    values = np.empty(k.shape[0])
    least = np.full(k.shape[0], -np.inf) if floors is None else floors
    for start in range(0, k.shape[0], _BATCH):
        chunk = slice(start, start + _BATCH)
        own = h if h.ndim == 2 else h[chunk]
        values[chunk] = _greatest_chunk(own, k[chunk], objectives[chunk], shared, least[chunk])
    return values


def _greatest_chunk(
    h: FloatArray,
    k: FloatArray,
    objectives: FloatArray,
    shared: FloatArray | None,
    floors: FloatArray,
) -> FloatArray:
    values = np.full(k.shape[0], np.nan)
    todo = np.arange(k.shape[0])
    for wall in _WALLS:
        own = h if h.ndim == 2 else h[todo]
        found = _simplex(own, shared, k[todo], objectives[todo], wall, floors[todo])
        good = found.settled & ~found.walled
        values[todo[good]] = np.sum(found.points * objectives[todo], axis=1)[good]
        todo = todo[~good]
        if not todo.size:
            return values
    _require_few(todo, k.shape[0])
    for i in todo:
        try:
            rows = h if h.ndim == 2 else h[i]
            rows = rows if shared is None else np.vstack([rows, shared])
            values[i] = maximise(rows, k[i], objectives[i]).value
        except EmptySetError:
            values[i] = -np.inf
        except SetError:
            values[i] = np.inf
    return values


def inner_ball(h: FloatArray, k: FloatArray, cap: float = 1.0) -> Ball:
    """The largest ball of radius at most ``cap`` in {h x <= k}, rows of any length.

    Where the set leaves a choice, the centre lies near the origin rather than far from it. A
    negative radius is by how far unit rows must be loosened for the set to have a point, or, below
    ``_EMPTY``, less than that.
    """
    return inner_balls(h[None], k[None], cap)[0]


def inner_balls(
    h: FloatArray,
    k: FloatArray,
    cap: float = 1.0,
    shared: FloatArray | None = None,
    near: FloatArray | None = None,
) -> list[Ball]:
    """The same for a batch of sets: h (batch, rows, n), k (batch, rows), ``shared`` as above.

    ``near`` (batch, n): points that take the origin's place, for sets that may lie far from it.
    """
    if near is not None:
        k = k - _heights(h, shared, near)
    balls: list[Ball] = []
    for start in range(0, k.shape[0], _BATCH):
        chunk = slice(start, start + _BATCH)
        balls += _ball_chunk(h[chunk], k[chunk], cap, shared)
    if near is None:
        return balls
    return [Ball(ball.centre + at, ball.radius) for ball, at in zip(balls, near, strict=True)]


def _ball_chunk(h: FloatArray, k: FloatArray, cap: float, shared: FloatArray | None) -> list[Ball]:
    batch, count, n = h.shape
    rows = np.zeros((batch, count + 1, n + 1))
    rows[:, 1:, :n], rows[:, 0, n] = h, 1.0  # the cap first: the shared rows' bounds are last
    rows[:, 1:, n] = np.sqrt(np.sum(h * h, axis=2))
    bounds = np.column_stack([np.full(batch, cap), k])
    wide = None
    if shared is not None:
        wide = np.column_stack([shared, np.sqrt(np.sum(shared * shared, axis=1))])
    objective = np.append(np.zeros(n), 1.0)
    floors = np.full(batch, _EMPTY * cap)
    result: list[Ball | None] = [None] * batch
    todo = np.arange(batch)
    for wall in _WALLS:
        wanted = np.tile(objective, (todo.size, 1))
        found = _simplex(rows[todo], wide, bounds[todo], wanted, wall, floors[todo])
        # a ball of good size is inside the set; a small one may be the walls' doing
        good = found.settled & (~found.walled | (found.points[:, n] > 1e-3 * cap))
        for i in np.flatnonzero(good):
            result[todo[i]] = Ball(found.points[i, :n], float(found.points[i, n]))
        todo = todo[~good]
        if not todo.size:
            break
    _require_few(todo, batch)
    for i in todo:
        all_rows = rows[i] if wide is None else np.vstack([rows[i], wide])
        result[i] = _ball_by_highs(all_rows, bounds[i], objective)
    return [ball for ball in result if ball is not None]


def _require_few(left: IntArray, asked: int) -> None:
    """Ends where HiGHS would be asked about a good part of many programs: what then comes of
    minutes of work is not to be relied on.

    Raises:
        SetError: more than ``_HOPELESS`` of a full batch are left.
    """
    if asked >= _HOPELESS and left.size > _HOPELESS:
        said = f"{left.size} of {asked} linear programs that do not settle"
        raise SetError("constraints", said, "planes that are farther apart")


def _ball_by_highs(rows: FloatArray, bounds: FloatArray, objective: FloatArray) -> Ball:
    """The ball that HiGHS finds, if it is one: a program with rows of far apart heights may come
    back as unbounded, which no ball with a cap is, or with a point that keeps no row.

    Raises:
        SetError: it is none.
    """
    best = maximise(rows, bounds, objective)
    if best.point is not None:
        excess = rows @ best.point - bounds
        size = 1.0 + 1e-3 * float(np.max(np.abs(best.point)))
        if np.max(excess) <= 100.0 * LP_RESIDUAL * size:
            return Ball(best.point[:-1], best.value)
    raise SetError("constraints", None, "a linear program that solves")


@dataclass(frozen=True)
class _Vertices:
    """``points`` (batch, n); ``settled``: optimal; ``walled``: held by a wall among others."""

    points: FloatArray
    settled: BoolArray
    walled: BoolArray


def _simplex(
    h: FloatArray,
    shared: FloatArray | None,
    k: FloatArray,
    objectives: FloatArray,
    wall: float,
    floors: FloatArray,
) -> _Vertices:
    """Dual simplex from the walls' corners. h: (rows, n) for all, or (batch, rows, n).

    The value of every basis on the way is above the greatest one; a program whose basis shows it to
    be below its floor, (batch,), ends there.
    """
    if h.ndim == 2:
        h, shared = np.zeros((k.shape[0], 0, h.shape[1])), h
    batch, n = objectives.shape
    signs = np.where(objectives >= 0.0, 1.0, -1.0)
    basis = np.tile(np.arange(-n, 0), (batch, 1))  # negative: a wall
    inverse = signs[:, :, None] * np.eye(n)  # of the basic rows
    duals, held = np.abs(objectives), np.full((batch, n), wall)
    optimal, below = np.zeros(batch, dtype=bool), np.zeros(batch, dtype=bool)
    live = np.arange(batch)  # programs still moving; the arrays above shrink with it
    final = basis.copy()
    for _ in range(_MAX_PIVOTS):
        points = (inverse @ held[:, :, None])[:, :, 0]
        excess = _heights(h[live], shared, points) - k[live]
        worst = np.argmax(excess, axis=1) if k.shape[1] else np.zeros(live.size, dtype=np.int64)
        at = np.arange(live.size)
        ends = excess[at, worst] <= 0.1 * LP_RESIDUAL if k.shape[1] else at >= 0
        share = np.zeros((live.size, n))
        if k.shape[1]:
            share = (_rows(h, shared, live, worst)[:, None, :] @ inverse)[:, 0]
        # the entering row's multiplier rises, those of the basic rows must stay >= 0
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.where(share > 1e-11, duals / share, np.inf)
        least = ratios.min(axis=1)
        low = np.sum(objectives[live] * points, axis=1) < floors[live]
        below[live[low]], ends = True, ends | low
        stuck = ~ends & np.isinf(least)  # no point within the walls: HiGHS is to say it
        optimal[live[ends]] = True
        final[live] = basis
        moving = ~(ends | stuck)
        if not moving.any():
            break
        if not moving.all():
            live, basis, inverse = live[moving], basis[moving], inverse[moving]
            duals, held, share = duals[moving], held[moving], share[moving]
            ratios, least, worst = ratios[moving], least[moving], worst[moving]
            at = np.arange(live.size)
        # of equal ratios the largest pivot: the basis stays as well conditioned as it can
        ties = ratios <= least[:, None] + 1e-14
        out = np.argmax(np.where(ties, share, -np.inf), axis=1)
        duals = np.maximum(duals - least[:, None] * share, 0.0)
        duals[at, out] = least
        pivot = inverse[at, :, out] / share[at, out][:, None]
        inverse = inverse - pivot[:, :, None] * share[:, None, :]
        inverse[at, :, out] = pivot
        basis[at, out], held[at, out] = worst, k[live, worst]
    return _verified(h, shared, k, objectives, signs, final, optimal, wall, below, floors)


def _heights(h: FloatArray, shared: FloatArray | None, points: FloatArray) -> FloatArray:
    """(batch, rows) of each program's own rows, then of the shared ones."""
    own: FloatArray = (h @ points[:, :, None])[:, :, 0]
    return own if shared is None else np.concatenate([own, points @ shared.T], axis=1)


def _rows(
    h: FloatArray, shared: FloatArray | None, programs: IntArray, places: IntArray
) -> FloatArray:
    """Row ``places[i]`` of program ``programs[i]``: (..., n)."""
    count = h.shape[1]
    if shared is None:
        return np.asarray(h[programs, places])
    if not count:
        return np.asarray(shared[places])
    own = h[programs, np.minimum(places, count - 1)]
    common = shared[np.maximum(places - count, 0)]
    picked: FloatArray = np.where((places < count)[..., None], own, common)
    return picked


def _transposed(rows: FloatArray, objectives: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(batch, n) x of rows' x = objective, and which there are: one whose determinant is a trace
    above zero may still meet a pivot of zero when it is factored the other way round."""
    flipped, whole = rows.transpose(0, 2, 1), np.ones(len(rows), dtype=bool)
    try:
        solved = np.linalg.solve(flipped, objectives[:, :, None])
    except np.linalg.LinAlgError:
        solved = np.zeros((*objectives.shape, 1))
        for i, (matrix, objective) in enumerate(zip(flipped, objectives, strict=True)):
            try:
                solved[i, :, 0] = np.linalg.solve(matrix, objective)
            except np.linalg.LinAlgError:
                whole[i] = False
    duals: FloatArray = solved[:, :, 0].astype(np.float64)
    return duals, whole


def _verified(
    h: FloatArray, shared: FloatArray | None, k: FloatArray, objectives: FloatArray,
    signs: FloatArray, basis: IntArray, optimal: BoolArray, wall: float, below: BoolArray,
    floors: FloatArray,
) -> _Vertices:  # fmt: skip
    """Vertices solved afresh from their bases; settled where they pass the test of optimality, or
    where their multipliers alone show that the greatest value is ``below`` their floor."""
    batch, n = objectives.shape
    at = np.arange(batch)[:, None]
    at_wall = basis < 0
    safe = np.where(at_wall, 0, basis)
    if k.shape[1]:
        rows = _rows(h, shared, np.broadcast_to(at, safe.shape), safe).copy()
        held = np.where(at_wall, wall, k[at, safe])
    else:
        rows, held = np.zeros((batch, n, n)), np.full((batch, n), wall)
    walls = signs[:, :, None] * np.eye(n)
    rows[at_wall] = walls[at, np.where(at_wall, basis + n, 0)][at_wall]
    settled = optimal & (np.abs(np.linalg.det(rows)) > 0.0)
    rows[~settled] = np.eye(n)
    points: FloatArray = np.linalg.solve(rows, held[:, :, None])[:, :, 0].astype(np.float64)
    duals, whole = _transposed(rows, objectives)
    settled &= whole
    size = 1.0 + np.max(np.abs(duals), axis=1)
    settled &= np.min(duals, axis=1) >= -LP_RESIDUAL * size
    # far out, the rows lose the digits that the point's size takes
    slack = LP_RESIDUAL * (1.0 + 1e-3 * np.max(np.abs(points), axis=1))
    if k.shape[1]:
        excess = _heights(h, shared, points) - k
        under = below & (np.sum(duals * held, axis=1) < floors)
        settled &= under | (np.max(excess, axis=1) <= slack)
    walled = np.any(at_wall & (duals > 1e-12 * size[:, None]), axis=1)
    return _Vertices(points, settled, walled)
