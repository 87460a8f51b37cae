"""Critical regions on a slice, coloured by first-move law; the search tree over them."""

from __future__ import annotations

from typing import Any

import numpy as np

from servogen.explicit.choose import Form
from servogen.explicit.solution import ExplicitSolution
from servogen.explicit.tree import Tree
from servogen.precision import FloatArray
from servogen.reports.law_names import MEANING, law_names
from servogen.reports.servo_data import ServoReportData
from servogen.reports.slice_polygons import area, rectangle, section
from servogen.reports.style import PATH_COLOUR, Figure, Trace, layout, plain

# Colours of laws, one after the other; apart under the common kinds of colour blindness in the
# order in which neighbours get them.
LAW_COLOURS = (
    "#1f86cc", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#8a6fd1",
    "#5b8c5a", "#b07d62", "#4b5d78", "#c94f7c",
)  # fmt: skip
# How far the slice shows, in shares of what the limit can do at once.
REACH = 4.0
# Regions are beyond counting by eye; the largest on the slice are drawn.
MOST_REGIONS = 400
# Coefficients of one law from two solutions agree to this share of the largest.
SAME = 1e-8


def law_colour(law: int) -> str:
    """Of a law, by its number."""
    return LAW_COLOURS[law % len(LAW_COLOURS)]


def shown_form(data: ServoReportData) -> Form | None:
    """The form whose regions are drawn: those of the whole program, else the chosen form's."""
    forms = [form for form in data.choice.forms if form.solution is not None]
    whole = [
        form
        for form in forms
        if form.solution is not None and np.all(np.isfinite(form.solution.problem.lower))
    ]
    return next(iter(whole or forms), None)


def slice_of(data: ServoReportData) -> tuple[FloatArray, FloatArray]:
    """(p, 2) directions of theta and (2,) how far along each, to either side.

    Along the first, all references are one degree ahead; along the second, the axis turns at a
    degree a second and is to stop where it is. The reach is where the unconstrained first move
    passes its limit ``REACH`` times.
    """
    problem = data.parts.mpc.problem
    layout_, plant = problem.layout, problem.plant
    directions = np.zeros((layout_.size, 2))
    directions[layout_.reference, 0] = 1.0
    directions[layout_.increment, 1] = _turning(plant.a, plant.c) * plant.sample_time_s
    slope, _ = problem.qp.unconstrained()
    limit = float(max(abs(problem.qp.lower[0]), abs(problem.qp.upper[0])))
    gain = np.abs(slope[0] @ directions)
    return directions, REACH * limit / np.maximum(gain, 1e-12 * float(np.max(gain)))


def _turning(a: FloatArray, c: FloatArray) -> FloatArray:
    """(n,) the increments of a motion that goes on, one unit of output a sample: of the modes that
    the output shows the one nearest to z = 1."""
    values, vectors = np.linalg.eig(a)
    shown = np.abs(c[0] @ vectors) > 1e-9 * np.linalg.norm(c[0]) * np.linalg.norm(vectors, axis=0)
    order = np.argsort(np.where(shown, np.abs(values - 1.0), np.inf))
    mode = np.real(vectors[:, order[0]])
    result: FloatArray = mode / float(c[0] @ mode)
    return result


def regions_figure(data: ServoReportData) -> Figure | None:
    """The slice; None where no regions were enumerated."""
    form = shown_form(data)
    if form is None or form.solution is None:
        return None
    solution = form.solution
    directions, reach = slice_of(data)
    pieces = _pieces(solution, directions, reach)
    shape = layout("references ahead of the axis [deg]", ["speed of the axis [deg/s]"])
    shape["hovermode"] = "closest"
    shape["legend"] = {"orientation": "v", "x": 1.01, "y": 1.0}
    laws = len({law for law, _, _ in pieces})
    return Figure(
        "regions",
        "Critical regions",
        f"A slice through {len(solution.regions)} regions with {solution.laws.count} laws of the "
        "first move: all references the same distance ahead, the axis turning at the speed shown, "
        f"no current before. {len(pieces)} regions and {laws} laws meet it; colours are laws, and "
        f"the legend says what holds in each: {MEANING}.",
        _polygons(pieces, law_names(solution)),
        shape,
        height=520,
    )


Piece = tuple[int, int, FloatArray]


def _pieces(solution: ExplicitSolution, directions: FloatArray, reach: FloatArray) -> list[Piece]:
    """Law, number of the region, and its corners, by law."""
    plane, frame = solution.image.matrix @ directions, rectangle(*reach.tolist())
    found: list[Piece] = []
    for number, region in enumerate(solution.regions):
        polygon = section(region.h, region.k, plane, solution.image.offset, frame)
        if area(polygon) > 1e-9 * area(frame):
            found.append((region.law, number, polygon))
    found.sort(key=lambda piece: -area(piece[2]))
    return sorted(found[:MOST_REGIONS], key=lambda piece: piece[:2])


def _polygons(pieces: list[Piece], meanings: list[str]) -> list[Trace]:
    traces: list[Trace] = []
    told: set[int] = set()
    for law, number, polygon in pieces:
        closed = np.vstack([polygon, polygon[:1]])
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": f"law {law + 1}: {meanings[law]}",
                "legendgroup": f"law {law + 1}",
                "showlegend": law not in told,
                "x": plain(closed[:, 0]),
                "y": plain(closed[:, 1]),
                "fill": "toself",
                "fillcolor": law_colour(law),
                "line": {"color": PATH_COLOUR, "width": 0.6},
                "opacity": 0.8,
                "hoveron": "fills",
                "text": f"region {number + 1}, law {law + 1}: {meanings[law]}",
                "hoverinfo": "text",
            }
        )
        told.add(law)
    return traces


def tree_figure(data: ServoReportData) -> Figure | None:
    """The chosen form's tree; None where it has none."""
    chosen = data.choice.chosen
    tree = chosen.tree
    if tree is None or not tree.inner:
        return None
    spots, leaves = tree_places(tree)
    edges_x: list[float | None] = []
    edges_y: list[float | None] = []
    for parent, child in _edges(tree):
        (x0, y0), (x1, y1) = spots[parent], spots[child]
        edges_x += [x0, x1, None]
        edges_y += [y0, y1, None]
    traces: list[Trace] = [
        {
            "type": "scatter", "mode": "lines", "name": "ways", "x": edges_x, "y": edges_y,
            "line": {"color": PATH_COLOUR, "width": 1.0}, "hoverinfo": "skip", "showlegend": False,
        },
        _markers("node", [spots[i] for i in range(tree.inner)],
                 [f"node {i}" for i in range(tree.inner)], PATH_COLOUR, "circle"),
    ]  # fmt: skip
    number = _numbers(chosen, shown_form(data))
    assert chosen.solution is not None
    meanings = dict(zip(number, law_names(chosen.solution), strict=True))
    for law in sorted({number[law] for _, law in leaves}):
        places = [spots[key] for key, own in leaves if number[own] == law]
        name = f"law {law + 1}: {meanings[law]}"
        traces.append(_markers(name, places, [name] * len(places), law_colour(law), "square"))
    shape = layout("leaves in their order [1]", ["nodes passed [1]"])
    shape["yaxis"] |= {"autorange": "reversed", "dtick": 1}
    shape["xaxis"] |= {"showticklabels": False}
    shape["hovermode"] = "closest"
    shape["legend"] = {"orientation": "v", "x": 1.01, "y": 1.0}
    return Figure(
        "tree",
        "Search tree",
        f"The tree that is emitted: {chosen.name}, {tree.nodes} nodes, depth {tree.depth}. To the "
        "left where the height is not above the node's offset; squares are leaves, in the colours "
        "that their laws have among the critical regions"
        f"{', and the first move is clipped behind them' if chosen.name.startswith('clip') else ''}"
        f". The legend says what holds where a law applies: {MEANING}.",
        traces,
        shape,
        height=420,
    )


def _numbers(chosen: Form, shown: Form | None) -> list[int]:
    """Of the chosen form's laws: those that the regions' figure has, by what they are, then others.

    A form without bounds on the first move has the laws of the whole program in which it is free.
    """
    assert chosen.solution is not None
    own = _on_theta(chosen.solution)
    known = own[:0] if shown is None or shown.solution is None else _on_theta(shown.solution)
    scale = np.max(np.abs(own), axis=0)
    numbers, fresh = [], len(known)
    for law in own:
        apart = np.max(np.abs(known - law) / np.where(scale > 0.0, scale, 1.0), axis=1)
        same = np.flatnonzero(apart <= SAME)
        numbers.append(int(same[0]) if same.size else fresh)
        fresh += not same.size
    return numbers


def _on_theta(solution: ExplicitSolution) -> FloatArray:
    """(laws, nu (p + 1)) coefficients on the parameters, and the constant."""
    gains = solution.laws.gains @ solution.image.matrix
    constant = solution.laws.offsets + solution.laws.gains @ solution.image.offset
    both: FloatArray = np.concatenate([gains, constant[:, :, None]], axis=2)
    return both.reshape(len(both), -1)


def tree_places(
    tree: Tree,
) -> tuple[dict[int, tuple[float, float]], list[tuple[int, int]]]:
    """Where nodes stand: leaves in their order, a node in the middle of its leaves, at its depth.

    Returns the places by key, inner nodes by their number and leaves by -1, -2, ..., and for each
    leaf its key and law.
    """
    spots: dict[int, tuple[float, float]] = {}
    leaves: list[tuple[int, int]] = []

    def place(child: int, depth: int) -> float:
        if child < 0:
            key = -1 - len(leaves)
            leaves.append((key, -1 - child))
            spots[key] = (float(len(leaves) - 1), float(depth))
            return spots[key][0]
        below, above = (place(int(c), depth + 1) for c in tree.children[child])
        spots[child] = (0.5 * (below + above), float(depth))
        return spots[child][0]

    place(tree.root, 0)
    return spots, leaves


def _edges(tree: Tree) -> list[tuple[int, int]]:
    """Keys of parents and children as ``tree_places`` numbers them."""
    found: list[tuple[int, int]] = []
    count = 0

    def walk(at: int) -> None:
        nonlocal count
        for child in tree.children[at].tolist():
            if child < 0:
                count += 1
                found.append((at, -count))
            else:
                found.append((at, int(child)))
                walk(int(child))

    walk(tree.root)
    return found


def _markers(
    name: str, places: list[tuple[float, float]], told: list[str], colour: str, symbol: str
) -> Trace:
    marker: dict[str, Any] = {"size": 9, "color": colour, "symbol": symbol}
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": [x for x, _ in places],
        "y": [y for _, y in places],
        "text": told,
        "hovertemplate": "%{text}",
        "marker": marker,
    }
