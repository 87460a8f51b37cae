"""What the emitted C of a lookup holds, against what is proved of its solution and its program.

The tables are those read back from the C's text (``emit.read_back``), not the design's: a number
that was changed on the way, or in the file, is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servogen.explicit.choose import Form
from servogen.explicit.clips import RecursiveClips
from servogen.explicit.rim import Rim, prove_rim
from servogen.explicit.tolerances import EDGE, PROVED, SEEN
from servogen.precision import FloatArray, IntArray, Precision
from servogen.qp.parametric import ParametricQP
from servogen.systems.claims import Claim

# Numbers computed anew from those that are proved, before they are rounded: a few dozen roundings
# of the largest of their table.
SAME_NUMBER = 1e-12
# Bounds of the feasible set's rows, relative to one and the bound: a tenth of the least by which
# they are widened.
SAME_BOUND = 1e-10


@dataclass(frozen=True)
class Emitted:
    """One precision's ``tables`` and ``dimensions``, by the names of the declaration."""

    precision: Precision
    tables: Mapping[str, FloatArray | IntArray]
    dimensions: Mapping[str, int]

    def real(self, name: str, shape: tuple[int, ...]) -> FloatArray:
        """A table in float64, which holds it exactly; NaN where it is missing or of other size."""
        table = self.tables.get(name)
        if table is None or table.size != int(np.prod(shape)) or table.dtype.kind != "f":
            return np.full(shape, np.nan)
        return table.astype(np.float64).reshape(shape)

    def integers(self, name: str) -> IntArray:
        """A table of integers, empty where it is not there."""
        table = self.tables.get(name)
        if table is None or table.dtype.kind != "i":
            return np.zeros(0, dtype=np.int64)
        return table.astype(np.int64)


def table_claims(form: Form, problem: ParametricQP, emitted: Emitted) -> list[Claim]:
    """The emitted tables of a form: its own, and the bounds of the moves."""
    if form.tree is None:
        claims = [_clip_tables(form, emitted)]
    else:
        claims = [_tree_tables(form, emitted), _depth(form, emitted)]
    return [*claims, _bounds(form, problem, emitted)]


def _tree_tables(form: Form, emitted: Emitted) -> Claim:
    """The proved tree and laws in the lookup's own coordinates, its image or the parameters."""
    tree, solution = form.tree, form.solution
    assert tree is not None
    assert solution is not None
    own, laws, nu = solution.image, solution.laws, solution.problem.first_move
    seen = "matrix" in emitted.tables
    image = np.eye(own.size) if seen else own.matrix
    shift = np.zeros(own.size) if seen else own.offset
    size, p = image.shape[1], own.matrix.shape[1]
    wanted = [
        ("gains", (laws.gains @ image).reshape(-1, size)),
        ("constants", (laws.offsets + laws.gains @ shift).ravel()),
    ]
    if tree.inner:
        wanted.append(("normals", tree.normals @ image))
        wanted.append(("offsets", tree.offsets - tree.normals @ shift))
    if seen:
        wanted.append(("matrix", own.matrix.T))
        if np.any(own.offset) or "shift" in emitted.tables:
            wanted.append(("shift", own.offset))
    worst, cases = _compared(wanted, emitted)
    below, above = emitted.integers("below"), emitted.integers("above")
    same = np.array_equal(below, tree.children[:, 0]) and np.array_equal(above, tree.children[:, 1])
    dimensions = {
        "PARAMETERS": p, "MOVES": nu, "COORDINATES": size, "LAWS": laws.count, "NODES": tree.inner,
    }  # fmt: skip
    same = same and (tree.inner > 0 or tree.root == -1)
    same = same and emitted.dimensions.get("MIRROR", -1) == tree.mirror
    same = same and all(emitted.dimensions.get(key) == value for key, value in dimensions.items())
    return _same(form, emitted, worst if same else np.inf, cases + below.size + above.size)


def _clip_tables(form: Form, emitted: Emitted) -> Claim:
    clips = form.lookup
    assert isinstance(clips, RecursiveClips)
    wanted = [
        ("matrix", clips.matrix.T), ("coefficients", clips.coefficients), ("half", clips.half),
        ("middle", clips.middle),
    ]  # fmt: skip
    if np.any(clips.offset) or "shift" in emitted.tables:
        wanted.append(("shift", clips.offset))
    worst, cases = _compared(wanted, emitted)
    same = np.array_equal(emitted.integers("index"), clips.index)
    same = same and np.array_equal(emitted.integers("last"), clips.moves)
    return _same(form, emitted, worst if same else np.inf, cases + clips.index.size)


def _same(form: Form, emitted: Emitted, worst: float, cases: int) -> Claim:
    what = "proved clips" if form.tree is None else "proved tree"
    title = f"{form.name}, {emitted.precision.name}: the emitted tables are those of the {what}"
    return Claim(title, worst <= SAME_NUMBER, worst, SAME_NUMBER, cases)


def _compared(wanted: Sequence[tuple[str, FloatArray]], emitted: Emitted) -> tuple[float, int]:
    worst = 0.0
    for name, values in wanted:
        found = emitted.real(name, values.shape)
        worst = max(worst, _apart(found, values, emitted.precision))
    return worst, sum(values.size for _, values in wanted)


def _apart(found: FloatArray, wanted: FloatArray, precision: Precision) -> float:
    """By how much ``found`` is no rounding of ``wanted``, relative to the largest of them."""
    if not wanted.size:
        return 0.0
    if not np.all(np.isfinite(found)):
        return float("inf")
    scale = float(np.max(np.abs(wanted))) or 1.0
    # half a unit in the last place, of numbers near zero the least there is
    unit = 0.5 * np.spacing(np.abs(wanted).astype(precision.dtype)).astype(np.float64)
    return float(np.max(np.maximum(np.abs(found - wanted) - unit, 0.0))) / scale


def _bounds(form: Form, problem: ParametricQP, emitted: Emitted) -> Claim:
    """The moves' bounds, which are clipped to, and the moves where nothing is looked up."""
    nu, most = problem.first_move, 0.5 * emitted.precision.max
    low, high = problem.lower[:nu], problem.upper[:nu]
    wanted = [("safe", np.clip(0.0, low, high))]
    # clips need no bounds of their own unless their last sum may round beyond them
    if "low" in emitted.tables or (form.tree is not None and np.any(np.isfinite([low, high]))):
        wanted += [("low", np.maximum(low, -most)), ("high", np.minimum(high, most))]
    worst, cases = _compared(wanted, emitted)
    title = f"{form.name}, {emitted.precision.name}: clipped to the program's bounds"
    return Claim(title, worst <= SAME_NUMBER, worst, SAME_NUMBER, cases)


def _depth(form: Form, emitted: Emitted) -> Claim:
    """Every way from the root of the emitted children ends at a leaf within the loop's bound."""
    bound, nodes = emitted.dimensions.get("TREE_DEPTH", 0), emitted.dimensions.get("NODES", -1)
    laws = emitted.dimensions.get("LAWS", 0)
    children = np.column_stack([emitted.integers("below"), emitted.integers("above")])
    over, leaves, astray = 0, 0, len(children) != nodes
    waiting = [(0 if nodes else -1, 0)]
    while waiting and not astray:
        at, depth = waiting.pop()
        over = max(over, depth - bound)
        if at < 0:
            leaves += 1
            astray = -1 - at >= laws
        elif depth <= bound:
            astray = at >= nodes
            waiting += [] if astray else [(int(child), depth + 1) for child in children[at]]
    title = (
        f"{form.name}, {emitted.precision.name}: no way through the emitted tree is longer than "
        f"{bound} nodes"
    )
    # in a tree every node but the root is one child, so that there is a leaf more than nodes
    holds = over == 0 and not astray and leaves == nodes + 1
    return Claim(title, holds, float("inf") if astray else float(over), 0.0, leaves)


def edge_claims(problem: ParametricQP, emitted: Sequence[Emitted]) -> list[Claim]:
    """The emitted rows that tell a feasible parameter: proved of the numbers in float64, and those
    of other precisions against them."""
    exact = next(own for own in emitted if not own.precision.is_float32)
    size = problem.parameters
    rows = exact.real("edge_rows", (exact.dimensions.get("EDGES", 0), size))
    if not np.all(np.isfinite(rows)):
        return [Claim("rows of the feasible set: as declared", False, np.inf, 0.0, 0)]
    rim = prove_rim(problem, rows.astype(np.float64))
    told, some = f"{len(rows)} rows of the feasible set", len(rows) > 0
    holds = rim.missing <= PROVED and rim.generators > 0
    where = f"{told}: the program has a solution wherever they hold"
    if not some:
        where = "no rows of a feasible set: the program has a solution for every parameter"
        holds = holds and all(own.dimensions.get("EDGES") == 0 for own in emitted)
    claims = [
        Claim(
            f"{where.split(':')[0]}: their coordinates show what matters",
            rim.unseen <= SEEN, rim.unseen, SEEN, max(len(rows), 1),
        ),
        Claim(where, holds, rim.missing, PROVED, max(rim.generators, 1)),
    ]  # fmt: skip
    return claims + [_edges(told, own, rows, rim) for own in emitted if some]


def _edges(told: str, own: Emitted, rows: FloatArray, rim: Rim) -> Claim:
    """A precision's rows and bounds: where the feasible set ends, and ``EDGE`` for rounding."""
    name, tops = own.precision.name, rim.tops
    title = f"{told}, {name}: each ends where the set does, {EDGE[name]:g} beyond for rounding"
    found, bounds = own.real("edge_rows", rows.shape), own.real("edge_bounds", tops.shape)
    count = own.dimensions.get("EDGES", 0)
    if count != len(rows) or not np.all(np.isfinite(tops)):
        return Claim(title, False, np.inf, SAME_BOUND, len(rows))
    wanted = tops + EDGE[name] * (1.0 + np.abs(tops))
    unit = 0.5 * np.spacing(np.abs(wanted).astype(own.precision.dtype)).astype(np.float64)
    beyond = np.maximum(np.abs(bounds - wanted) - unit - rim.room, 0.0) / (1.0 + np.abs(tops))
    beyond = np.nan_to_num(beyond, nan=np.inf)
    worst = max(_apart(found, rows, own.precision), float(np.max(beyond)))
    return Claim(title, worst <= SAME_BOUND, worst, SAME_BOUND, len(rows))
