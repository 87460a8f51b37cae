"""Signals over time: positions, velocity, acceleration, fast stage, feed, iterations, error."""

from __future__ import annotations

from typing import Any

import numpy as np

from servogen.controllers.design import Status
from servogen.precision import FloatArray
from servogen.reports.data import ReportData
from servogen.reports.decimation import keep_extremes
from servogen.reports.style import (
    AXIS_COLOURS,
    BUCKETS,
    LIMIT_COLOUR,
    PATH_COLOUR,
    Figure,
    Trace,
    layout,
    limit,
    limits,
    line,
    plain,
    signal,
)
from servogen.systems.closed_loop import AXES, Run

_TIME = "time [s]"
_UNFED = (int(Status.BACKUP), int(Status.INFEASIBLE))
# Where a logarithmic axis shows zero iterations.
_ZERO = 0.5


def time_figures(data: ReportData) -> list[Figure]:
    """In the order of the paper's Figures 8 to 11, then the contour error."""
    return [
        _positions(data.run),
        _motion(data.run),
        _fast_stage(data.run),
        _feed(data),
        _contour(data),
    ]


def _fine_time(run: Run) -> FloatArray:
    return np.arange(run.periods * run.machine.ratio) * run.machine.fast_period_s


def _slow_time(run: Run) -> FloatArray:
    return np.arange(run.periods) * run.machine.slow_period_s


def _span(run: Run) -> tuple[float, float]:
    return 0.0, run.time_s


def _positions(run: Run) -> Figure:
    time = _fine_time(run)
    traces: list[Trace] = []
    for i, axis in enumerate(AXES):
        panel, reach = i + 1, run.machine.limits[i].fast_range_m
        reference = run.reference[:, i]
        kept = keep_extremes(reference, BUCKETS)
        bound: dict[str, Any] = {
            "legendgroup": "bound",
            "width": 0.9,
            "line": {"dash": "dash"},
            "panel": panel,
            "hoverinfo": "skip",
        }
        lower, upper = reference[kept] - reach, reference[kept] + reach
        shade: dict[str, Any] = {"fill": "tonexty", "fillcolor": "rgba(215,48,31,0.07)"}
        name = "reference ± fast range"
        traces += [
            line(name, time[kept], lower, LIMIT_COLOUR, showlegend=False, **bound),
            line(name, time[kept], upper, LIMIT_COLOUR, showlegend=i == 0, **shade, **bound),
            signal(f"slow stage {axis}", time, run.slow_fine[:, i, 0], AXIS_COLOURS[axis], panel),
            *limits(_span(run), run.machine.limits[i].position_m, panel, shown=i == 0),
        ]
    return Figure(
        "positions",
        "Slow stage position",
        "Each axis between its moving bounds: the reference, less and plus the fast stage's range.",
        traces,
        layout(_TIME, [f"{axis} [m]" for axis in AXES]),
        linked=True,
        height=620,
    )


def _motion(run: Run) -> Figure:
    time = _fine_time(run)
    traces: list[Trace] = []
    for i, axis in enumerate(AXES):
        shared = {"legendgroup": axis}
        colour = AXIS_COLOURS[axis]
        traces += [
            signal(f"{axis}", time, run.slow_fine[:, i, 1], colour, 1, **shared),
            signal(f"{axis}", time, run.slow_fine[:, i, 2], colour, 2, showlegend=False, **shared),
        ]
    span = _span(run)
    for level in sorted({lim.velocity_m_per_s for lim in run.machine.limits}):
        traces += limits(span, level, 1)
    for level in sorted({lim.acceleration_m_per_s2 for lim in run.machine.limits}):
        traces += limits(span, level, 2, shown=False)
    return Figure(
        "motion",
        "Slow stage velocity and acceleration",
        "Between the slow samples too; the design enforces the limits at the slow samples and at "
        "the inter-sample instants it was asked for.",
        traces,
        layout(_TIME, ["velocity [m/s]", "acceleration [m/s²]"]),
        linked=True,
        height=560,
    )


def _fast_stage(run: Run) -> Figure:
    time = _fine_time(run)
    traces = [
        signal(axis, time, 1e3 * run.fast_position[:, i], AXIS_COLOURS[axis])
        for i, axis in enumerate(AXES)
    ]
    for level in sorted({lim.fast_range_m for lim in run.machine.limits}):
        traces += limits(_span(run), 1e3 * level)
    return Figure(
        "fast",
        "Fast stage position",
        "What the fast stage makes up, and its range.",
        traces,
        layout(_TIME, ["position [mm]"]),
        linked=True,
    )


def _feed(data: ReportData) -> Figure:
    run, time = data.run, _slow_time(data.run)
    ratio = run.interval_points / run.machine.ratio
    step: dict[str, Any] = {"line": {"shape": "hv"}}
    traces = [line("η/M", time, ratio, PATH_COLOUR, showlegend=False, **step)]
    titles = ["feed ratio η/M [1]"]
    shape_more: dict[str, Any] = {}
    if data.design.mpc:
        cap = data.design.mpc[0].solver.cap
        titles.append("iterations [1]")
        for i, axis in enumerate(AXES):
            shown = np.maximum(run.iterations[:, i], _ZERO)
            told = [str(count) for count in run.iterations[:, i].tolist()]
            traces.append(
                line(axis, time, shown, AXIS_COLOURS[axis], 1.0, 2, text=told,
                     hovertemplate="%{text}", **step)
            )  # fmt: skip
        traces += [_backups(run), limit("cap", _span(run), cap, 2)]
        ticks = [1, *(10**e for e in range(1, 7) if 10**e < 0.7 * cap), cap]
        shape_more = {
            "type": "log",
            "tickvals": [_ZERO, *ticks],
            "ticktext": ["0", *(str(tick) for tick in ticks)],
            "range": [float(np.log10(0.8 * _ZERO)), float(np.log10(1.6 * max(cap, 2)))],
        }
    shape = layout(_TIME, titles)
    shape["yaxis"] |= {"range": [-0.04, 1.08]}
    if shape_more:
        shape["yaxis2"] |= shape_more
    return Figure(
        "feed",
        "Feed and solver",
        "Points processed in each slow period against M, and what each axis's solver needed; "
        "crosses mark periods in which the cap was reached and the shifted plan was used.",
        traces,
        shape,
        linked=True,
        height=520,
    )


def _backups(run: Run) -> Trace:
    period, axis = np.nonzero(np.isin(run.status_axis, _UNFED))
    return {
        "type": "scatter",
        "mode": "markers",
        "name": f"backup ({len(period)})",
        "x": plain(_slow_time(run)[period], 7),
        "y": plain(np.maximum(run.iterations[period, axis], _ZERO)),
        "text": [AXES[i] for i in axis.tolist()],
        "hovertemplate": "backup, %{text}",
        "marker": {"symbol": "x", "size": 8, "color": LIMIT_COLOUR},
        "xaxis": "x2",
        "yaxis": "y2",
    }


def _contour(data: ReportData) -> Figure:
    run = data.run
    return Figure(
        "contour",
        "Contour error",
        "Distance of the tool, both stages together, from the path.",
        [
            signal("contour error", _fine_time(run), 1e6 * data.contour_error, AXIS_COLOURS["x"]),
            limit("limit", _span(run), 1e6 * data.contour_limit_m),
        ],
        layout(_TIME, ["contour error [µm]"]),
        linked=True,
        height=320,
    )
