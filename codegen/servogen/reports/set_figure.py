"""The admissible set of each axis, looked at from above, with the motion inside."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection

from servogen.precision import FloatArray
from servogen.reports.data import ReportData
from servogen.reports.style import AXIS_COLOURS, LIMIT_COLOUR, Figure, Trace, layout, line, plain
from servogen.sets.admissible import AdmissibleSet
from servogen.systems.closed_loop import AXES


def shadow(admissible: AdmissibleSet) -> FloatArray:
    """(v, 2) corners, in order, of the set's projection on (p - r, velocity), for the command 0.

    SI units. A set that is not bounded, or has no inside, has no corners: (0, 2).
    """
    rows = admissible.h_x
    # Scaled so that a corner is near 1 in every direction; qhull's tolerances are absolute.
    scale = np.max(np.abs(rows), axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    halves = np.column_stack([rows / scale, -admissible.k])
    try:
        corners = HalfspaceIntersection(halves, np.zeros(rows.shape[1])).intersections
        flat = (corners / scale)[:, :2]
        flat = flat[np.isfinite(flat).all(axis=1)]
        hull: FloatArray = flat[ConvexHull(flat / np.max(np.abs(flat), axis=0)).vertices]
    except Exception as error:  # scipy has no public name for qhull's errors in older versions
        if type(error).__name__ not in ("QhullError", "ValueError", "IndexError"):
            raise
        return np.empty((0, 2))
    return hull


def set_figure(data: ReportData) -> Figure:
    """Slow samples against the section of O-infinity (Result 1), per axis."""
    run = data.run
    traces: list[Trace] = []
    shape = layout("", ["velocity [m/s]"])
    shape["xaxis"] |= {"domain": [0.0, 0.46], "title": {"text": "x: position less reference [mm]"}}
    shape["xaxis2"] = {
        "domain": [0.54, 1.0],
        "title": {"text": "y: position less reference [mm]"},
        "anchor": "y2",
        "zeroline": False,
    }
    shape["yaxis2"] = {"anchor": "x2", "zeroline": False}
    shape["hovermode"] = "closest"
    for i, (axis, admissible) in enumerate(
        zip(AXES, (data.machine.sets.x, data.machine.sets.y), strict=True)
    ):
        panel: dict[str, Any] = {"panel": i + 1}
        corners = shadow(admissible)
        closed = np.vstack([corners, corners[:1]])
        error = run.slow[:, i, 0] - run.reference[:: run.machine.ratio, i]
        traces.append(
            line("admissible set", 1e3 * closed[:, 0], closed[:, 1], LIMIT_COLOUR,
                 line={"dash": "dash"}, fill="toself", fillcolor="rgba(215,48,31,0.06)",
                 hoverinfo="skip", showlegend=i == 0, **panel)
        )  # fmt: skip
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": f"slow samples {axis}",
                "x": plain(1e3 * error),
                "y": plain(run.slow[:, i, 1]),
                "marker": {"size": 3, "color": AXIS_COLOURS[axis], "opacity": 0.55},
                "hovertemplate": "%{x:.2f} mm, %{y:.3f} m/s",
                "xaxis": f"x{i + 1}" if i else "x",
                "yaxis": f"y{i + 1}" if i else "y",
            }
        )
    return Figure(
        "sets",
        "Admissible set",
        "The shadow of the maximal admissible set on position error and velocity, for a reference "
        "at rest in the middle of the workspace, and the slow samples against their own reference. "
        "The governor keeps the end of every plan in the set.",
        traces,
        shape,
        height=420,
    )
