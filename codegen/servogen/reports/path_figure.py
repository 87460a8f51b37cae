"""The picture of the two stages: path, slow stage, and where the governor slows down."""

from __future__ import annotations

import numpy as np

from servogen.precision import BoolArray, FloatArray
from servogen.reports.data import ReportData
from servogen.reports.decimation import simplify
from servogen.reports.numbers import percent
from servogen.reports.style import (
    PATH_COLOUR,
    SLOWED_SCALE,
    X_COLOUR,
    Figure,
    Trace,
    layout,
    line,
    plain,
)
from servogen.systems.closed_loop import Run

# Of the drawing's extent: a tenth of a pixel at tenfold zoom.
_TOLERANCE_SHARE = 1e-5
_MARKS_PER_INTERVAL = 4


def slowed_intervals(run: Run) -> BoolArray:
    """(K,) whether the governor took fewer than M points though the path had more."""
    last = len(run.machine.timed.points) - 1
    short = run.interval_points < run.machine.ratio
    result: BoolArray = short & (run.first_point + run.interval_points < last)
    return result


def slowed_places(run: Run) -> tuple[FloatArray, FloatArray]:
    """Points (p, 2) m on the path inside slowed intervals and their feed ratio (p,).

    The slowest come last, so that they are drawn on top.
    """
    places, ratios = [], []
    for k in np.flatnonzero(slowed_intervals(run)):
        first, taken = int(run.first_point[k]), int(run.interval_points[k])
        marks = np.unique(np.linspace(first, first + taken, _MARKS_PER_INTERVAL).astype(np.int64))
        places.append(run.machine.timed.points[marks])
        ratios.append(np.full(len(marks), taken / run.machine.ratio))
    if not places:
        return np.empty((0, 2)), np.empty(0)
    ratio = np.concatenate(ratios)
    order = np.argsort(-ratio, kind="stable")
    return np.concatenate(places)[order], ratio[order]


def path_figure(data: ReportData) -> Figure:
    """Paper 1, Figure 7."""
    run = data.run
    path = run.machine.timed.tool_path.points
    tolerance = _TOLERANCE_SHARE * float(np.max(np.ptp(path, axis=0)))
    traces = [
        _curve("path", path, tolerance, PATH_COLOUR, 1.1),
        _curve("slow stage", run.slow_fine[:, :, 0], tolerance, X_COLOUR, 1.7),
        _slowed(run),
    ]
    share = float(np.mean(slowed_intervals(run))) if run.periods else 0.0
    shape = layout("x [m]", ["y [m]"])
    shape["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1, "constrain": "domain"}
    shape["xaxis"] |= {"constrain": "domain"}
    shape["hovermode"] = "closest"
    shape["margin"] = {**shape["margin"], "b": 120}
    return Figure(
        "path",
        "Path and slow stage",
        "The tool draws the path; the slow stage cuts its corners and the fast stage makes up the "
        f"rest. Coloured: where the governor slows down ({percent(share)} of the slow periods), "
        "the darker the more.",
        traces,
        shape,
        height=840,
        max_width="780px",
        square=True,
    )


def _curve(name: str, points: FloatArray, tolerance: float, colour: str, width: float) -> Trace:
    kept = points[simplify(points, tolerance)]
    hover = "x %{x:.4f} m, y %{y:.4f} m"
    exact = {"simplify": False}  # else plotly makes polygons of small circles
    return line(name, kept[:, 0], kept[:, 1], colour, width, hovertemplate=hover, line=exact)


def _slowed(run: Run) -> Trace:
    places, ratio = slowed_places(run)
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "slowed down",
        "x": plain(places[:, 0]),
        "y": plain(places[:, 1]),
        "text": [f"η/M = {value:.3f}" for value in ratio.tolist()],
        "hovertemplate": "%{text}<br>x %{x:.4f} m, y %{y:.4f} m",
        "marker": {
            "size": 5,
            "color": plain(ratio, 4),
            "colorscale": SLOWED_SCALE,
            "cmin": 0,
            "cmax": 1,
            "showscale": True,
            "colorbar": {
                "title": {"text": "feed ratio η/M [1]", "side": "bottom"},
                "orientation": "h",
                "thickness": 10,
                "len": 0.6,
                "x": 0.5,
                "yref": "container",
                "y": 0.01,
                "yanchor": "bottom",
                "outlinewidth": 0,
            },
        },
    }
