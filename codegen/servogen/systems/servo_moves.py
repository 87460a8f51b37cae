"""The lookup, in its own precision, against an independent solver: points, not a proof.

Some are drawn over six decades of size; the others lie in every region of a solution, near and far,
so that every law is asked, and on both sides of every row that tells a feasible parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.controllers.design import Status
from servogen.controllers.lookup import Lookup
from servogen.controllers.lookup_design import LookupDesign
from servogen.explicit.choose import Choice
from servogen.explicit.lookup import TreeLookup
from servogen.explicit.restated import Restated
from servogen.explicit.rim import in_own_coordinates
from servogen.explicit.small_lp import inner_balls
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tolerances import EDGE
from servogen.precision import FloatArray
from servogen.progress import Progress
from servogen.qp.parametric import ParametricQP
from servogen.qp.parametric_solver import ParametricSolver
from servogen.systems.claims import Claim

MOVES = 1000
SEED = 20
# Agreement of a first move with the program's solver, as a share of the input's range: what the
# solver leaves in float64, and sums of a dozen terms some hundred times the range in float32.
SAME_MOVE = {"float64": 1e-9, "float32": 1e-3}
# Terms of a move, in shares of its range, up to which that is said; more round in proportion.
LARGE = 100.0
# Points of each region: its middle, and this many ways from there, each half way to its end or,
# where it has none, so far.
WAYS = 4
FAR = (1.0, 30.0, 1000.0)
# Regions whose points are drawn; of more, as many of them evenly apart, and one of each law.
MOST_REGIONS = 500
# How far inside and outside a row of the feasible set it is asked, in its own widths (``EDGE``).
BESIDE = (-100.0, -10.0, 10.0, 100.0)
# Terms of a move without bounds, in shares of its range, beyond which no parameter is asked: the
# independent solver, whose sums they enter, would be wrong first.
TELLABLE = 1e7
# A law has to be asked if its largest ball is so wide, in roundings of the coordinates in it.
VISIBLE = 1e3
# A coefficient is known to this share of the steepest law's: one that should be zero is not quite,
# and far from a bound of the position it is multiplied by a million.
COEFFICIENT = 1e-14
# Room for the sums that compare a parameter with a row: terms, each rounded.
TERMS = 32.0


@dataclass(frozen=True)
class _Found:
    worst: float
    cases: int
    refused: int
    disagreed: int
    laws: frozenset[int]


def move_claims(
    problem: ParametricQP, choice: Choice, design: LookupDesign, progress: Progress
) -> list[Claim]:
    """Of one precision: the first move, what is refused, and that every law was asked."""
    own = in_own_coordinates(problem)
    solution = _solution(choice)
    thetas, visible = _random(own), frozenset[int]()
    if solution is not None:
        points, visible = _inside(own, solution, design)
        thetas = np.vstack([thetas, points])
    thetas = np.vstack([thetas, _beside(own, design)])
    thetas = thetas[np.all(np.abs(thetas) < 0.1 * design.reach, axis=1)]
    thetas = thetas[_tellable(problem, thetas)]
    found = _asked(problem, design, thetas, progress)
    name = design.precision.name
    tolerance = SAME_MOVE[name]
    claims = [
        Claim(
            f"the first move is the program's, {name}, in shares of its range",
            found.worst <= tolerance and found.cases > 0, found.worst, tolerance, found.cases,
            "sample",
        ),
        Claim(
            f"a move is given where the program has a solution, {name}, and nowhere else",
            found.disagreed == 0, float(found.disagreed), 0.0, found.cases + found.refused,
            "sample",
        ),
    ]  # fmt: skip
    if isinstance(design.form, TreeLookup) and solution is not None:
        missed = len((visible & _leaves(design.form)) - found.laws)
        title = f"every law was asked, {name}: {len(found.laws)} of {_laws(design.form)}"
        claims.append(Claim(title, missed == 0, float(missed), 0.0, len(found.laws), "sample"))
    return claims


def _tellable(problem: ParametricQP, thetas: FloatArray) -> npt.NDArray[np.bool_]:
    """(N,) whether the terms of the moves without bounds leave a solver some digits of a range."""
    slope, first = problem.unconstrained()[0], problem.first_move
    span = np.abs(problem.upper[:first] - problem.lower[:first])
    terms = np.abs(thetas) @ np.abs(slope[:first]).T
    kept: npt.NDArray[np.bool_] = np.all(~(terms > TELLABLE * span), axis=1)
    return kept


def _solution(choice: Choice) -> ExplicitSolution | None:
    """The chosen form's, or any other form's where that has none."""
    forms = [choice.chosen, *choice.forms]
    return next((form.solution for form in forms if form.solution is not None), None)


def _laws(form: TreeLookup) -> int:
    return len(_leaves(form))


def _leaves(form: TreeLookup) -> frozenset[int]:
    """Laws at the leaves: with a mirror, those of one half."""
    leaves = form.tree.children[form.tree.children < 0] if form.tree.inner else [form.tree.root]
    return frozenset(-1 - int(leaf) for leaf in leaves)


def _random(own: Restated) -> FloatArray:
    """(MOVES, p): such that each parameter alone moves the coordinates by one bound, on average,
    over six decades of that size. A parameter that moves nothing is drawn of size one."""
    rng = np.random.default_rng(SEED)
    sizes = 10.0 ** rng.uniform(-3.0, 3.0, (MOVES, 1))
    result: FloatArray = rng.normal(size=(MOVES, own.columns.size)) / own.columns * sizes
    return result


def _inside(
    own: Restated, solution: ExplicitSolution, design: LookupDesign
) -> tuple[FloatArray, frozenset[int]]:
    """Parameters in every region that the feasible set reaches into, and the laws that a parameter
    of the precision can be told to be in."""
    laws, count = solution.law_of, len(solution.regions)
    first = np.unique(laws, return_index=True)[1]
    step = max(1, count // MOST_REGIONS)
    chosen = np.unique(np.concatenate([np.arange(0, count, step), first]))
    limits = [(own.domain_rows, own.domain_bounds), _edges(own, design)]
    halves = _halves(own, design)
    sets = [[_over(own, solution, int(i)), *limits, half] for half in halves for i in chosen]
    rows = [np.vstack([h for h, _ in parts]) for parts in sets]
    bounds = [np.concatenate([k for _, k in parts]) for parts in sets]
    most = max(1, max(k.size for k in bounds))
    h = np.zeros((len(sets), most, own.coordinates))
    k = np.ones((len(sets), most))  # rows 0 eta <= 1 fill up
    for i, bound in enumerate(bounds):
        h[i, : bound.size], k[i, : bound.size] = rows[i], bound
    rng = np.random.default_rng(SEED + 1)
    unit = float(np.finfo(design.precision.dtype).eps)
    points, visible = [], set()
    for i, ball in enumerate(inner_balls(h, k)):
        if ball.radius <= 0.0:
            continue
        points += [ball.centre, *_ways(ball.centre, rows[i], bounds[i], rng)]
        terms = np.max(np.abs(own.matrix) @ np.abs(own.inverse @ (ball.centre - own.shift)))
        # a tree of one half answers in the other one by the law of the opposite region
        if i < chosen.size and ball.radius > VISIBLE * unit * (1.0 + float(terms)):
            visible.add(int(laws[chosen[i]]))
    return own.theta(np.array(points)), frozenset(visible)


def _halves(own: Restated, design: LookupDesign) -> list[tuple[FloatArray, FloatArray]]:
    """Rows of the half that a tree with a mirror is grown for, then of the other one."""
    form = design.form
    if not isinstance(form, TreeLookup) or form.tree.mirror < 0:
        return [(np.zeros((0, own.coordinates)), np.zeros(0))]
    at = form.tree.mirror
    row, shift = form.matrix[at : at + 1], form.offset[at : at + 1]
    return [_rows(own, -row, shift), _rows(own, row, -shift)]


def _over(own: Restated, solution: ExplicitSolution, index: int) -> tuple[FloatArray, FloatArray]:
    """The rows of a region in the program's own coordinates, which show what a program without some
    of its bounds sees."""
    region, image = solution.regions[index], solution.image
    return _rows(own, region.h @ image.matrix, region.k - region.h @ image.offset)


def _edges(own: Restated, design: LookupDesign) -> tuple[FloatArray, FloatArray]:
    """The feasible set's rows, as far inside as they are emitted outside."""
    if design.feasible is None:
        return np.zeros((0, own.coordinates)), np.zeros(0)
    bounds = design.feasible.bounds
    inside = bounds - 2.0 * EDGE[design.precision.name] * (1.0 + np.abs(bounds))
    return _rows(own, design.feasible.rows, inside)


def _rows(own: Restated, rows: FloatArray, bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """rows theta <= bounds in the program's own coordinates, of unit length."""
    scaled = (rows / own.columns).astype(np.float64)
    over = own.seen(scaled, -bounds.astype(np.float64))[0]
    lengths = np.linalg.norm(over.slope, axis=1)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    return over.slope / lengths[:, None], -over.offset / lengths


def _ways(
    centre: FloatArray, rows: FloatArray, bounds: FloatArray, rng: np.random.Generator
) -> list[FloatArray]:
    """Points half way to where a region ends, or far out where it does not."""
    ways = rng.normal(size=(WAYS, centre.size))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    speeds, slack = ways @ rows.T, bounds - rows @ centre
    found = []
    for way, speed in zip(ways, speeds, strict=True):
        meets = speed > 0.0
        length = float(np.min(slack[meets] / speed[meets])) if np.any(meets) else np.inf
        for far in FAR if length > 2.0 * FAR[-1] else (0.5 * length,):
            found.append(centre + far * way)
    return found


def _beside(own: Restated, design: LookupDesign) -> FloatArray:
    """Just inside and just outside the middle of every facet of the feasible set."""
    if design.feasible is None:
        return np.zeros((0, design.parameters))
    rows, bounds = design.feasible.rows, design.feasible.bounds
    scaled = rows / own.columns
    lengths = np.linalg.norm(scaled, axis=1)
    h, k = scaled / lengths[:, None], bounds / lengths
    points = []
    for i in range(k.size):
        others = np.arange(k.size) != i
        # the facet's middle: of the others' rows along its plane
        foot, basis = h[i] * k[i], np.linalg.svd(h[i : i + 1])[2][1:].T
        along, room = h[others] @ basis, k[others] - h[others] @ foot
        if basis.shape[1] and room.size:
            ball = inner_balls(along[None], room[None])[0]
            foot = foot + basis @ ball.centre
        width = EDGE[design.precision.name] * (1.0 + abs(bounds[i])) / lengths[i]
        points += [(foot + beside * width * h[i]) / own.columns for beside in BESIDE]
    return np.array(points)


def _asked(
    problem: ParametricQP, design: LookupDesign, thetas: FloatArray, progress: Progress
) -> _Found:
    lookup, solver = Lookup(design), ParametricSolver(problem)
    span = np.abs(problem.upper[: design.moves] - problem.lower[: design.moves])
    worst, cases, refused, disagreed, laws = 0.0, 0, 0, 0, set()
    dtype = design.precision.dtype
    with progress.task(f"Asking the lookup, {design.precision.name}", len(thetas)) as task:
        for theta in thetas:
            task.advance()
            given = theta.astype(dtype)
            optimum = solver.solve(given.astype(np.float64))
            status, out = lookup.call("find", {"theta": given})
            ok = status is Status.OK
            if ok != optimum.feasible and not _on_edge(design, given.astype(np.float64)):
                disagreed += 1
            if not (ok and optimum.feasible):
                refused += 1
                continue
            first = optimum.z[: design.moves]
            size = np.where(np.isfinite(span), span, 1.0 + np.abs(first))
            law = int(np.asarray(out.get("law", 0)))
            off = np.abs(np.asarray(out["move"], dtype=np.float64) - first)
            off = np.maximum(off - COEFFICIENT * _steepest(design, theta), 0.0) / size
            terms = float(np.max(_terms(design, law, theta) / size))
            worst = max(worst, float(np.max(off)) / max(1.0, terms / LARGE))
            cases += 1
            laws.add(law)
    return _Found(worst, cases, refused, disagreed, frozenset(laws))


def _terms(design: LookupDesign, law: int, theta: FloatArray) -> FloatArray:
    """(nu,) what each first move is the sum of, all taken positive, in its units."""
    form = design.form
    eta = np.abs(form.matrix) @ np.abs(theta) if form.matrix.size else np.abs(theta)
    if isinstance(form, TreeLookup):
        moves: FloatArray = np.abs(form.gains[law]) @ eta
        return moves
    halves: FloatArray = form.half * np.max(eta)
    return halves


def _steepest(design: LookupDesign, theta: FloatArray) -> FloatArray:
    """(nu,) the same of the largest coefficients of any law."""
    form = design.form
    if not isinstance(form, TreeLookup):
        return np.zeros(design.moves)
    eta = np.abs(form.matrix) @ np.abs(theta) if form.matrix.size else np.abs(theta)
    moves: FloatArray = np.max(np.abs(form.gains), axis=0) @ eta
    return moves


def _on_edge(design: LookupDesign, theta: FloatArray) -> bool:
    """Whether a parameter is so near a row's bound that rounding may decide."""
    if design.feasible is None:
        return False
    name = design.precision.name
    rows, bounds = design.feasible.rows, design.feasible.bounds
    unit = float(np.finfo(design.precision.dtype).eps)
    room = 2.0 * EDGE[name] * (1.0 + np.abs(bounds)) + TERMS * unit * (np.abs(rows) @ np.abs(theta))
    return bool(np.any(np.abs(rows @ theta - bounds) <= room))
