"""The lookup of a first move: an explicit solution's tree or clips, and their declaration.

``find`` takes the parameter theta of a program and gives the first inputs of its solution. Every
finite theta up to ``reach`` is answered, and ``reach`` is so far out that only the range of the
scalar type limits it: up to it no sum of the lookup can overflow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servogen.controllers.design import (
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Table,
)
from servogen.controllers.errors import DesignError
from servogen.explicit.choose import Choice, Form, Lookup
from servogen.explicit.clips import RecursiveClips
from servogen.explicit.explore import solve
from servogen.explicit.feasible import FeasibleSet, always_feasible, feasible_set
from servogen.explicit.lookup import TreeLookup
from servogen.explicit.tolerances import EDGE
from servogen.precision import FloatArray, Precision
from servogen.progress import Progress
from servogen.qp.parametric import ParametricQP

# Largest theta taken, if the lookup's numbers allow it: beyond any measurement in any unit, and its
# products with tables up to 1e15 stay in range.
FARTHEST = {"float64": 1e100, "float32": 1e20}
# Share of the scalar type's range that the largest sum may reach: what rounding adds is far less.
HEADROOM = 0.25


@dataclass(frozen=True)
class LookupDesign:
    """A form of lookup with what surrounds it.

    Attributes:
        form: tree or recursive clips.
        feasible: None where every theta is; widened by ``EDGE``.
        low, high: (nu,) bounds of the first moves, infinite where there is none.
        reach: largest |theta_i| that is looked up.
        sample_time_s: of the controller that asks.
        unit: of the moves, for the comments.
    """

    prefix: str
    precision: Precision
    form: Lookup
    feasible: FeasibleSet | None
    low: FloatArray
    high: FloatArray
    reach: float
    sample_time_s: float
    unit: str

    @property
    def parameters(self) -> int:
        """p, length of theta."""
        form = self.form
        if isinstance(form, TreeLookup) and not form.matrix.size:
            return int(form.gains.shape[2])
        return int(form.matrix.shape[1])

    @property
    def moves(self) -> int:
        """nu, first moves."""
        return int(self.low.size)

    @property
    def safe(self) -> FloatArray:
        """(nu,) given where nothing is looked up: zero, or the bound next to it."""
        result: FloatArray = np.clip(0.0, self.low, self.high)
        return result


def design_lookup(
    prefix: str,
    precision: Precision,
    problem: ParametricQP,
    choice: Choice,
    sample_time_s: float,
    max_regions: int,
    unit: str = "mA",
    form: Form | None = None,
    progress: Progress | None = None,
) -> LookupDesign:
    """The lookup that was chosen for a program, or another of its forms.

    Args:
        problem, choice: see ``explicit.choose.choose``.
        max_regions: for the regions of the feasible set, where the program has more constraints
            than bounds on its variables.
        form: instead of the one chosen.

    Raises:
        DesignError: a form that could not be had, or tables of a size that the precision cannot
            compute with.
        ExplicitError: as ``solve``.
    """
    chosen = choice.chosen if form is None else form
    if chosen.lookup is None:
        raise DesignError("form", chosen.name, f"one that can be had ({chosen.note})")
    low, high = problem.lower[: problem.first_move], problem.upper[: problem.first_move]
    lookup = chosen.lookup
    feasible = (
        None if always_feasible(problem) else _feasible(problem, choice, max_regions, progress)
    )
    if feasible is not None:
        edge = EDGE[precision.name] * (1.0 + np.abs(feasible.bounds))
        feasible = FeasibleSet(feasible.rows, feasible.bounds + edge)
        if not feasible.bounds.size:
            feasible = None
    made = LookupDesign(
        prefix, precision, lookup, feasible, low, high, 0.0, sample_time_s, unit
    )  # fmt: skip
    return replace(made, reach=_reach(made))


def _feasible(
    problem: ParametricQP, choice: Choice, max_regions: int, progress: Progress | None
) -> FeasibleSet:
    """From the regions of the program itself: forms may have been made for one without bounds on
    the first move, which allows more."""
    own = choice.own
    if own is None or own.problem is not problem:
        own = solve(problem, max_regions, progress)
    return feasible_set(own)


def _reach(design: LookupDesign) -> float:
    """The largest power of ten for theta at which every sum stays within the scalar type."""
    slope, offset = _growth(design)
    farthest = FARTHEST[design.precision.name]
    room = HEADROOM * design.precision.max - offset
    largest = room / max(slope, 1.0)
    if not largest >= 1.0:
        expected = f"coefficients that {design.precision.name} can compute with"
        raise DesignError("lookup", f"up to {slope:.3g}", expected)
    return float(min(farthest, 10.0 ** np.floor(np.log10(largest))))


def _growth(design: LookupDesign) -> tuple[float, float]:
    """No intermediate result exceeds slope * max |theta| + offset in magnitude."""
    form = design.form
    rows = [np.ones((1, design.parameters))]
    if design.feasible is not None:
        rows.append(design.feasible.rows)
    direct = max(_sum(table) for table in rows)
    eta = (1.0, 0.0)
    if form.matrix.size:
        eta = (_sum(form.matrix), _largest(form.offset))
    if isinstance(form, TreeLookup):
        own = max(_sum(form.tree.normals), _sum(form.gains.reshape(-1, form.gains.shape[2])))
        constant = _largest(form.offsets)
    else:
        # delta is a clipped number less eta
        own = 1.0 + _sum(form.coefficients)
        constant = own + _largest(form.half) + _largest(form.middle)
    return max(direct, eta[0], own * eta[0]), (1.0 + own) * eta[1] + constant


def _sum(rows: FloatArray) -> float:
    return float(np.max(np.sum(np.abs(rows), axis=1), initial=0.0))


def _largest(values: FloatArray) -> float:
    return float(np.max(np.abs(values), initial=0.0))


def declare_lookup(design: LookupDesign) -> Declaration:
    """Names, sizes, tables and ports of the lookup."""
    form, p = design.form, design.parameters
    finite = bool(np.all(np.isfinite(design.low)) and np.all(np.isfinite(design.high)))
    move = Port(
        "move",
        design.unit,
        "first inputs of the optimum; zero, or the bound next to it, where the status is not OK",
        size=design.moves,
        low=float(np.min(design.low)) if finite else None,
        high=float(np.max(design.high)) if finite else None,
    )
    theta = Port(
        "theta",
        "in its units",
        "the program's parameter",
        size=p,
        low=-design.reach,
        high=design.reach,
    )
    own = _tree(design, form) if isinstance(form, TreeLookup) else _clips(design, form)
    found = (move, *own.operations[0].outputs)
    edges = 0 if design.feasible is None else design.feasible.bounds.size
    return replace(
        own,
        dimensions=(
            Dimension("PARAMETERS", p, "length of theta"),
            Dimension("MOVES", design.moves, "inputs that are looked up"),
            Dimension("EDGES", edges, "facets of the feasible set"),
            *own.dimensions,
        ),
        tables=(
            Table("safe", design.safe, "moves where nothing is looked up"),
            *_edge_tables(design),
            *own.tables,
        ),
        operations=(
            Operation("find", "The first move of the optimum for a parameter.", (theta,), found),
        ),
        trusting=(
            Operation(
                "solve",
                "As find, for a parameter that the caller has bounded: that it is a number and in "
                "range is not looked at.",
                (theta,), found, shares="find",
            ),
        ),
        facts={"has_edges": edges > 0, **own.facts},
    )  # fmt: skip


def _edge_tables(design: LookupDesign) -> tuple[Table, ...]:
    if design.feasible is None:
        return ()
    return (
        Table("edge_rows", design.feasible.rows, "feasible: rows theta <= bounds"),
        Table("edge_bounds", design.feasible.bounds, "their bounds, a rounding wide"),
    )


def _declared(design: LookupDesign, kind: str, summary: str, **parts: object) -> Declaration:
    given: dict[str, object] = {
        "kind": kind, "prefix": design.prefix, "summary": summary, "precision": design.precision,
        "sample_time_s": design.sample_time_s, "constants": (), **parts,
    }  # fmt: skip
    return Declaration(**given)  # type: ignore[arg-type]


def _tree(design: LookupDesign, form: TreeLookup) -> Declaration:
    tree, laws = form.tree, form.gains.shape[0]
    coordinates = form.gains.shape[2]
    most = 0.5 * design.precision.max
    law = Port("law", "1", "which law gave it; -1 for none", integer=True, low=-1, high=laws - 1)
    mirror = [Dimension("MIRROR", tree.mirror, "coordinate whose sign is taken off")]
    mirror = mirror if tree.mirror >= 0 else []
    tables = [*_image_tables(form)]
    if tree.inner:
        tables += [
            Table("normals", tree.normals, "of the hyperplanes, node by node"),
            Table("offsets", tree.offsets, "their heights"),
            Table("below", tree.children[:, 0], "where to, not above: node, or -1 - law", True),
            Table("above", tree.children[:, 1], "where to, above it", True),
        ]
    tables += [
        Table("gains", form.gains.reshape(-1, coordinates), "of the laws, move by move"),
        Table("constants", form.offsets.ravel(), "of the laws"),
    ]
    if form.bounded:
        tables += [
            Table("low", np.maximum(form.lower, -most), "lower bounds of the moves"),
            Table("high", np.minimum(form.upper, most), "upper bounds"),
        ]
    return _declared(
        design,
        "lookup_tree",
        f"First move from a search tree: {laws} laws, {tree.nodes} nodes",
        dimensions=(
            Dimension("COORDINATES", coordinates, "in which laws and hyperplanes are given"),
            Dimension("LAWS", laws, "distinct laws of the first move"),
            Dimension("NODES", tree.inner, "inner nodes"),
            Dimension("TREE_DEPTH", tree.depth, "most nodes on a way to a leaf"),
            *mirror,
        ),
        tables=tuple(tables),
        operations=(Operation("find", "", (), (law,)),),
        state=(
            *((StateField("eta", _NOTHING, "COORDINATES"),) if form.matrix.size else ()),
            StateField("law", "of the last move looked up, for whoever debugs", type="int32_t"),
        ),
        facts={
            "has_image": bool(form.matrix.size), "has_offset": bool(np.any(form.offset)),
            "mirrored": tree.mirror >= 0, "descends": tree.inner > 0, "bounded": form.bounded,
        },
    )  # fmt: skip


_NOTHING = "workspace, no meaning between calls"


def _clips(design: LookupDesign, form: RecursiveClips) -> Declaration:
    bounds = (
        Table("low", design.low, "lower bounds of the moves"),
        Table("high", design.high, "upper bounds"),
    )
    return _declared(
        design,
        "lookup_clips",
        f"First move from {form.index.size} clips, without a tree",
        dimensions=(
            Dimension("COORDINATES", form.matrix.shape[0], "variables of the program"),
            Dimension("CLIPS", form.index.size, "one after the other"),
        ),
        tables=(
            *_image_tables(form),
            Table("coefficients", form.coefficients, "of what was clipped off, clip by clip"),
            Table("index", form.index, "which variable is clipped", True),
            Table("last", form.moves, "the clip that leaves each move", True),
            Table("half", form.half, "half the way between a move's bounds"),
            Table("middle", form.middle, "its middle"),
            *(bounds if form.rounds else ()),
        ),
        operations=(Operation("find", "", (), ()),),
        state=(
            StateField("eta", _NOTHING, "COORDINATES"),
            StateField("delta", "workspace: what was clipped off", "COORDINATES"),
            StateField("found", "workspace: what each clip left", "CLIPS"),
        ),
        facts={"has_offset": bool(np.any(form.offset)), "rounds": form.rounds},
    )


def _image_tables(form: Lookup) -> tuple[Table, ...]:
    if not form.matrix.size:
        return ()
    offset = (Table("shift", form.offset, "added to them"),) if np.any(form.offset) else ()
    return (Table("matrix", form.matrix.T, "coordinates of theta, transposed"), *offset)
