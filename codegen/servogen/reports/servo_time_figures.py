"""Runs of a servo drive over time: the paper's Figures 5, 6, 9, 10 and 14 to 16 in kind."""

from __future__ import annotations

from typing import Any

import numpy as np

from servogen.precision import FloatArray
from servogen.reports.servo_data import ServoReportData
from servogen.reports.style import (
    PATH_COLOUR,
    X_COLOUR,
    Y_COLOUR,
    Figure,
    Trace,
    layout,
    limit,
    line,
    signal,
)
from servogen.systems.servo_figures import Disturbance, Waterfall
from servogen.systems.servo_loop import DriveRun, Track
from servogen.systems.servo_study import FAST, within
from servogen.systems.servo_task import TRACKING_KEY, TaskRow

_TIME = "time [s]"
COLOURS = {"MPC": X_COLOUR, "PID": Y_COLOUR}
_HELD: dict[str, Any] = {"line": {"shape": "hv"}}


def task_figures(data: ServoReportData) -> list[Figure]:
    """Figures 14 and 15 in kind: every task, both controllers in one plot."""
    names = dict.fromkeys(row.task for row in data.rows)
    return [_task(data, i, name) for i, name in enumerate(names)]


def _task(data: ServoReportData, index: int, name: str) -> Figure:
    runs = [(row, run) for row, run in data.runs if row.task == name]
    low, high = data.servo.project.controller.mpc.current_limit_ma
    traces: list[Trace] = []
    first = runs[0][1]
    panels = {row.controller: 2 + i for i, (row, _) in enumerate(runs)}  # of the errors
    last = 2 + len(panels)
    traces.append(
        line("reference", first.time_s, first.reference, PATH_COLOUR, line={"dash": "dot"})
    )
    for row, run in runs:
        traces += _signals(row, run, panels[row.controller], last)
    span = (float(first.time_s[0]), float(first.time_s[-1]))
    traces += [limit("limit", span, high, last), limit("limit", span, low, last, shown=False)]
    traces += _tracking_limit(runs[0][0], span)
    figures = "Figures 14 and 15" if index == 0 else "Figure 16"
    return Figure(
        f"task{index}",
        name.capitalize(),
        f"{figures} of the paper in kind, on the machine and through its encoder, with what "
        "the project simulates inside. Errors are output less reference, each controller's on an "
        "axis of its own: compare the numbers, not the heights.",
        traces,
        layout(
            _TIME,
            ["position [deg]", *(f"{name} error [deg]" for name in panels), "current [mA]"],
        ),
        linked=False,
        height=200 * last + 20,
    )


def _tracking_limit(row: TaskRow, span: tuple[float, float]) -> list[Trace]:
    """Of the MPC, whose errors are in the second panel."""
    found = [bound.limit for bound in row.bounds if bound.key == TRACKING_KEY]
    return [limit("limit", span, side * most, 2, False) for most in found for side in (1.0, -1.0)]


def _signals(row: TaskRow, run: DriveRun, errors: int, last: int) -> list[Trace]:
    colour, group = COLOURS[row.controller], {"legendgroup": row.controller}
    hidden: dict[str, Any] = {**group, "showlegend": False}
    return [
        signal(row.controller, run.time_s, run.output, colour, 1, **group),
        signal(row.controller, run.time_s, run.error, colour, errors, **hidden),
        signal(row.controller, run.fine_time_s, run.current, colour, last, **hidden, **_HELD),
    ]


def tracking_figure(track: Track, pid: DriveRun | None) -> Figure:
    """Figures 5 and 6 in kind."""
    traces = [
        line("reference", track.time_s, track.reference, PATH_COLOUR, line={"dash": "dot"}),
        line("MPC", track.time_s, track.output, COLOURS["MPC"], legendgroup="MPC"),
        line("MPC", track.time_s, track.error, COLOURS["MPC"], panel=2, legendgroup="MPC",
             showlegend=False),
        line("MPC", track.time_s, track.current, COLOURS["MPC"], panel=3, legendgroup="MPC",
             showlegend=False, **_HELD),
    ]  # fmt: skip
    if pid is not None:
        hidden: dict[str, Any] = {"legendgroup": "PID", "showlegend": False}
        traces += [
            line("PID", pid.time_s, pid.output, COLOURS["PID"], legendgroup="PID"),
            line("PID", pid.time_s, pid.error, COLOURS["PID"], panel=2, **hidden),
            signal("PID", pid.fine_time_s, pid.current, COLOURS["PID"], 3, **hidden, **_HELD),
        ]
    return Figure(
        "sine",
        f"Sine at {FAST.frequency_hz:g} Hz",
        "Figures 5 and 6 of the paper in kind: the MPC with a first-order hold and "
        f"H_t = H_u = 8, state known, beside the PID; {within((FAST,))}.",
        traces,
        layout(_TIME, ["position [deg]", "error [deg]", "current [mA]"]),
        height=620,
    )


def waterfall_figure(falls: tuple[tuple[str, Waterfall], ...], period_s: float) -> Figure:
    """Figures 9 and 10 in kind: what was planned at each sample, and what was given."""
    traces: list[Trace] = []
    titles = []
    for panel, (extension, fall) in enumerate(falls, start=1):
        time, plan = _tails(fall, period_s)
        shown: dict[str, Any] = {"showlegend": panel == 1}
        traces += [
            line("planned", time, plan, Y_COLOUR, 0.7, panel, legendgroup="planned", **shown),
            line("given", fall.time_s, fall.current, X_COLOUR, 1.6, panel, legendgroup="given",
                 **shown, **_HELD),
        ]  # fmt: skip
        titles.append(f"{extension.replace('_', ' ')} hold [mA]")
    told = ", ".join(
        f"{fall.gap:.0f} mA with the {extension.replace('_', '-')} hold"
        for extension, fall in falls
    )
    return Figure(
        "waterfall",
        "Planned and given current",
        "Figures 9 and 10 of the paper in kind, H_t = H_u = 4: every plan from its sample on, "
        f"{within((FAST,))}. Mean distance from a plan's last input to what was given then: "
        f"{told}.",
        traces,
        layout(_TIME, titles),
        height=560,
    )


def _tails(fall: Waterfall, period_s: float) -> tuple[FloatArray, FloatArray]:
    """Every plan as a stretch of its own, a gap behind each."""
    steps = np.arange(fall.plan.shape[1]) * period_s
    time = fall.time_s[:, None] + steps
    gap = np.full((fall.plan.shape[0], 1), np.nan)
    joined = np.hstack([time, time[:, -1:]]).ravel(), np.hstack([fall.plan, gap]).ravel()
    return joined


def law_figure(pulled: Disturbance) -> Figure:
    """Figure 16 in kind, with the law that each sample was in."""
    run = pulled.run
    traces = [
        signal("position", run.time_s, run.output, X_COLOUR, 1),
        signal("current", run.fine_time_s, run.current, Y_COLOUR, 2, **_HELD),
        line("law", run.time_s, pulled.law.astype(np.float64), PATH_COLOUR, 1.4, 3, **_HELD),
    ]
    shape = layout(_TIME, ["position [deg]", "current [mA]", "law [1]"])
    shape["yaxis3"] |= {"dtick": 1}
    return Figure(
        "laws",
        "Laws met under a pull on the load",
        f"Figure 16 of the paper in kind: {abs(pulled.torque):.3g} N m, more than the project's "
        "own current limit can hold, then let go. Law 1 is the one without bounds; the others are "
        "numbered as they appear.",
        traces,
        shape,
        height=600,
    )
