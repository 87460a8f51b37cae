"""A machine under the extended command governor: the paper's Figures 1 to 10 in kind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.precision import FloatArray, IntArray
from servogen.reports.decimation import keep_extremes, simplify
from servogen.reports.governor_data import GovernorReportData
from servogen.reports.governor_flow_figure import flow_figure
from servogen.reports.style import (
    BUCKETS,
    LIMIT_COLOUR,
    PATH_COLOUR,
    X_COLOUR,
    Y_COLOUR,
    Figure,
    Layout,
    Trace,
    layout,
    limit,
    limits,
    line,
    signal,
)

_TIME = "time [s]"
_COLOURS = (("x", X_COLOUR), ("y", Y_COLOUR))
# Of the drawing's extent: a tenth of a pixel at tenfold zoom.
_TOLERANCE_SHARE = 1e-5
# A limit that is so many times the largest value would leave a flat line to look at.
_FAR = 4.0


def motion_figures(data: GovernorReportData) -> list[Figure]:
    """In the order of the page."""
    return [
        flow_figure(data),
        pattern_figure(data),
        tube_figure(data),
        path_figure(data),
        response_figure(data),
        stroke_figure(data),
        limits_figure(data),
        taken_figure(data),
    ]


def pattern_figure(data: GovernorReportData) -> Figure:
    """Pattern and minimal motion (Figure 1)."""
    least = data.machine.project.controller.motion.reference == "minimal_motion"
    sent = "that is where the governor sends them" if least else "here they are sent to the pattern"
    return _map(
        data,
        "pattern",
        "Pattern and minimal motion",
        "The least that the slow stages have to move for the fast ones to reach every point; "
        f"{sent}.",
        ("minimal motion", data.machine.motion, Y_COLOUR),
    )


def path_figure(data: GovernorReportData) -> Figure:
    """Pattern and slow stages (Figure 6)."""
    return _map(
        data,
        "path",
        "Pattern and slow stage",
        "Where the slow stages went; the fast ones made up the rest.",
        ("slow stage", data.run.slow_fine[:, :, 0], X_COLOUR),
    )


def _map(
    data: GovernorReportData,
    name: str,
    title: str,
    caption: str,
    other: tuple[str, FloatArray, str],
) -> Figure:
    """The pattern from above, and another curve."""
    machine = data.machine
    tolerance = _TOLERANCE_SHARE * float(np.max(np.ptp(machine.points, axis=0)))
    told, curve, colour = other
    traces = [
        _curve("pattern", machine.timed.tool_path.points, tolerance, PATH_COLOUR, 1.0),
        _curve(told, curve, tolerance, colour, 1.8),
    ]
    shape = layout("x [m]", ["y [m]"])
    shape["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1, "constrain": "domain"}
    shape["xaxis"] |= {"constrain": "domain"}
    shape["hovermode"] = "closest"
    return Figure(name, title, caption, traces, shape, height=760, max_width="780px", square=True)


def tube_figure(data: GovernorReportData) -> Figure:
    """Pattern, envelope and minimal motion over the index (Figures 2, 4 and 5)."""
    machine = data.machine
    governor = machine.project.controller.governor
    traces: list[Trace] = []
    index = np.arange(len(machine.points), dtype=np.float64)
    for panel, (name, colour) in enumerate(_COLOURS, start=1):
        own = machine.points[:, panel - 1]
        reach = machine.sets[panel - 1].limits.fast_range_m - governor.stroke_margin_m
        reach -= machine.project.controller.motion.stroke_reserve_m
        shown = panel == 1
        for side, told in ((reach, True), (-reach, False)):
            traces.append(
                _by_index("envelope", index, own + side, LIMIT_COLOUR, panel, shown and told)
            )
        traces.append(_by_index("pattern", index, own, PATH_COLOUR, panel, shown))
        motion = machine.motion[:, panel - 1]
        traces.append(_by_index(f"minimal motion, {name}", index, motion, colour, panel, True))
    return Figure(
        "tube",
        "Minimal motion",
        "By the number of the point: the pattern, the envelope from which the fast stage reaches "
        "it with its reserve, and the least motion inside (19)-(20).",
        traces,
        layout("point [1]", ["x [m]", "y [m]"]),
        height=620,
    )


def response_figure(data: GovernorReportData) -> Figure:
    """Slow stages between the bounds that the points of every period make (Figures 7 and 8)."""
    run = data.run
    time, _ = _time(data)
    ends = run.period_s * np.arange(run.status.size + 1)
    held = {"line": {"shape": "hv", "dash": "dot"}}
    traces: list[Trace] = []
    for panel, (name, colour) in enumerate(_COLOURS, start=1):
        stroke = data.machine.sets[panel - 1].limits.fast_range_m
        least, greatest = machined_range(data, panel - 1)
        for bound, told in ((greatest - stroke, panel == 1), (least + stroke, False)):
            steps = np.append(bound, bound[-1])
            traces.append(
                line("stroke about the points of the period", ends, steps, LIMIT_COLOUR, 1.0,
                     panel, legendgroup="bound", showlegend=told, **held)
            )  # fmt: skip
        own = run.slow_fine[:, panel - 1, 0]
        traces.append(signal(f"slow stage {name}", time, own, colour, panel))
    return Figure(
        "response",
        "Response between the stroke's bounds",
        "In every period the slow stage has to be within the stroke of all points that are "
        "machined in it, at its beginning and at its end.",
        traces,
        layout(_TIME, ["x [m]", "y [m]"]),
        linked=True,
        height=620,
    )


def machined_range(data: GovernorReportData, axis: int) -> tuple[FloatArray, FloatArray]:
    """(K,) least and greatest coordinate of the tool in every slow period, m."""
    run, own = data.run, data.machine.points[:, axis]
    parts = [own[a : a + n + 1] for a, n in zip(run.first, run.taken, strict=True)]
    return np.array([np.min(p) for p in parts]), np.array([np.max(p) for p in parts])


def stroke_figure(data: GovernorReportData) -> Figure:
    """What is left to the fast stages, against the stroke."""
    run = data.run
    time, span = _time(data)
    traces: list[Trace] = []
    for panel, (name, colour) in enumerate(_COLOURS, start=1):
        left = run.tool[:, panel - 1] - run.slow_fine[:, panel - 1, 0]
        traces.append(signal(f"fast stage {name}", time, left, colour, panel))
        reach = data.machine.sets[panel - 1].limits.fast_range_m
        traces += limits(span, reach, panel, panel == 1)
    return Figure(
        "stroke",
        "Use of the stroke",
        "What is left to the fast stages, at most "
        f"{100.0 * (1.0 + data.row.between.stroke):.2f} % of their range at any fast sample.",
        traces,
        layout(_TIME, ["fast x [m]", "fast y [m]"]),
        linked=True,
        height=480,
    )


def limits_figure(data: GovernorReportData) -> Figure:
    """Velocities and accelerations of the slow stages with their limits (Figure 9)."""
    time, span = _time(data)
    traces: list[Trace] = []
    levels = [target.limits for target in data.machine.sets]
    for i, (name, colour) in enumerate(_COLOURS):
        for panel, state in ((1, 1), (2, 2)):
            values = data.run.slow_fine[:, i, state]
            own = {"legendgroup": name, "showlegend": panel == 1}
            traces.append(signal(name, time, values, colour, panel, **own))
    fastest = [level.velocity_m_per_s for level in levels]
    hardest = [level.acceleration_m_per_s2 for level in levels]
    traces += _levels(span, fastest, 1)
    told = ""
    largest = max(data.row.motion.largest_acceleration)
    near = [level if level <= _FAR * largest else None for level in hardest]
    traces += _levels(span, near, 2)
    if beyond := [level for level, shown in zip(hardest, near, strict=True) if shown is None]:
        each = " and ".join(f"{level:g} m/s²" for level in dict.fromkeys(beyond))
        told = f" The limit of the acceleration, {each}, is beyond the picture."
    return Figure(
        "limits",
        "Velocity and acceleration of the slow stages",
        f"Kept at {data.machine.project.controller.governor.sub_samples} instants of every slow "
        "period; between them velocity is at most "
        f"{100.0 * (1.0 + data.row.between.velocity):.2f} % of its limit.{told}",
        traces,
        layout(_TIME, ["velocity [m/s]", "acceleration [m/s²]"]),
        linked=True,
        height=520,
    )


def _levels(span: tuple[float, float], levels: Sequence[float | None], panel: int) -> list[Trace]:
    """The limit of both axes, or where they differ each in its axis's colour; None: not shown."""
    if levels[0] == levels[1]:
        return [] if levels[0] is None else limits(span, levels[0], panel, panel == 1)
    return [
        trace | {"name": f"limit, {name}", "line": trace["line"] | {"color": colour}}
        for level, (name, colour) in zip(levels, _COLOURS, strict=True)
        if level is not None
        for trace in limits(span, level, panel, panel == 1)
    ]


def taken_figure(data: GovernorReportData) -> Figure:
    """Points machined in every slow period (Figure 10), and the iterations that it took."""
    run = data.run
    time = run.period_s * np.arange(run.status.size)
    held = {"line": {"shape": "hv"}}
    traces = [signal("points", time, run.taken.astype(np.float64), PATH_COLOUR, 1, **held)]
    span = (0.0, run.time_s)
    traces.append(limit("M", span, float(data.machine.ratio), 1))
    for i, (name, colour) in enumerate(_COLOURS):
        steps = run.iterations[:, i].astype(np.float64)
        traces.append(signal(f"iterations {name}", time, steps, colour, 2, **held))
    return Figure(
        "taken",
        "Points and iterations of every slow period",
        "A period takes at most M points; where it takes fewer, the tool waits at the last one.",
        traces,
        _counted(layout(_TIME, ["points [1]", "iterations [1]"]), run.iterations),
        linked=True,
        height=480,
    )


def _counted(shape: Layout, iterations: IntArray) -> Layout:
    """With a range of iterations where there was none, which would else be about zero."""
    if not np.any(iterations):
        shape["yaxis2"] |= {"range": [-0.05, 1.0]}
    return shape


def _time(data: GovernorReportData) -> tuple[FloatArray, tuple[float, float]]:
    step = data.run.period_s / data.machine.ratio
    time = step * np.arange(len(data.run.tool))
    return time, (0.0, float(time[-1]))


def _by_index(
    name: str, index: FloatArray, values: FloatArray, colour: str, panel: int, shown: bool
) -> Trace:
    kept = keep_extremes(values, BUCKETS)
    return line(
        name, index[kept], values[kept], colour, 1.1, panel, showlegend=shown, legendgroup=name
    )


def _curve(name: str, points: FloatArray, tolerance: float, colour: str, width: float) -> Trace:
    kept = points[simplify(points, tolerance)]
    exact = {"simplify": False}  # else plotly makes polygons of small circles
    return line(name, kept[:, 0], kept[:, 1], colour, width, line=exact)
