"""A contour controller's run: the contour with its error magnified, errors, commands in time."""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray
from servogen.reports.contour_data import ContourReportData
from servogen.reports.decimation import simplify
from servogen.reports.numbers import number
from servogen.reports.style import (
    PATH_COLOUR,
    X_COLOUR,
    Y_COLOUR,
    Figure,
    Trace,
    layout,
    limit,
    limits,
    line,
    signal,
)

_TIME = "time [s]"
Z_COLOUR = "#3a9d6e"
COLOURS = {"x": X_COLOUR, "y": Y_COLOUR, "z": Z_COLOUR}
# The magnified error is to take this share of the contour's extent where it is largest.
_SHOWN_SHARE = 0.06
# A limit that is so many times the largest value would leave a flat line to look at.
_FAR = 5.0
# Of the contour's extent: a tenth of a pixel at tenfold zoom.
_TOLERANCE_SHARE = 1e-5


def run_figures(data: ContourReportData) -> list[Figure]:
    """In the order of the page."""
    return [
        contour_figure(data),
        *side_figures(data),
        error_figure(data),
        command_figure(data),
    ]


def contour_figure(data: ContourReportData) -> Figure:
    """The contour from above and where the tool went, its distance from the contour magnified."""
    flat = "" if len(data.machine.axes) == 2 else " Seen from above; errors along z do not show."
    return _view(data, "contour", "Contour and tool", (0, 1), flat)


def side_figures(data: ContourReportData) -> list[Figure]:
    """The same from the side, where a third axis moves: against the wider one of the others."""
    wanted = data.run.wanted
    if wanted.shape[1] < 3 or not np.ptp(wanted[:, 2]) > 0.0:
        return []
    wide = int(np.argmax(np.ptp(wanted[:, :2], axis=0)))
    told = f" Seen along {'yx'[wide]}."
    return [_view(data, "side", "Contour and tool from the side", (wide, 2), told)]


def _view(
    data: ContourReportData, name: str, title: str, seen: tuple[int, int], told: str
) -> Figure:
    """The contour in two of the axes, the error magnified."""
    task, names = data.machine.task, data.machine.names
    wanted = data.run.wanted[:, seen]
    shown = slice(0, task.end) if task.last - task.first < 2 else slice(task.first, task.last)
    away = _away(data)[:, seen]
    extent = float(np.max(np.ptp(wanted, axis=0)))
    largest = float(np.max(np.linalg.norm(away[shown], axis=1), initial=0.0))
    factor = magnification(_SHOWN_SHARE * extent, largest)
    drawn = 1e3 * (wanted + factor * away)[shown]
    tolerance = _TOLERANCE_SHARE * 1e3 * extent
    traces = [
        _curve("contour", 1e3 * wanted[shown], tolerance, PATH_COLOUR, 1.2),
        _curve(f"tool, error {number(factor)} times", drawn, tolerance, X_COLOUR, 1.6),
    ]
    shape = layout(f"{names[seen[0]]} [mm]", [f"{names[seen[1]]} [mm]"])
    shape["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1, "constrain": "domain"}
    shape["xaxis"] |= {"constrain": "domain"}
    shape["hovermode"] = "closest"
    return Figure(
        name,
        title,
        f"What the tool is off the contour, across it, drawn {number(factor)} times as large, of "
        f"the samples that count.{told}",
        traces,
        shape,
        height=640 if name == "contour" else 420,
        max_width="680px",
        square=True,
    )


def magnification(wanted: float, largest: float) -> float:
    """1, 2 or 5 times a power of ten, at most ``wanted`` over ``largest`` and at least one."""
    if not largest > 0.0 or wanted <= largest:
        return 1.0
    ratio = wanted / largest
    power = 10.0 ** np.floor(np.log10(ratio))
    step = next(s for s in (5.0, 2.0, 1.0) if s * power <= ratio * (1.0 + 1e-12))
    return float(step * power)


def _away(data: ContourReportData) -> FloatArray:
    """(K, p) part of the error across the contour: along it the tool is only early or late."""
    wanted, off = data.run.wanted, data.run.output - data.run.wanted
    points = data.machine.task.motion.points
    ahead = points[1 : len(wanted) + 1] - wanted
    length = np.linalg.norm(ahead, axis=1)
    way = ahead / np.where(length > 0.0, length, 1.0)[:, None]
    across = off - np.sum(off * way, axis=1)[:, None] * way
    size = np.linalg.norm(across, axis=1)
    scale = data.errors.contour / np.where(size > 0.0, size, 1.0)
    result: FloatArray = across * scale[:, None]
    return result


def error_figure(data: ContourReportData) -> Figure:
    """Contour and tracking errors over the whole run."""
    time, span = _time(data)
    allowed, told = data.machine.project.target.contour_error_limit_m, ""
    largest = float(np.max(data.errors.contour))
    traces = [signal("contour error", time, 1e6 * data.errors.contour, X_COLOUR, 1)]
    if allowed <= _FAR * largest:
        traces.append(limit("limit", span, 1e6 * allowed, 1))
    else:
        told = f" The limit of {number(1e6 * allowed)} µm is beyond the picture."
    traces += [
        signal("tracking error", time, 1e6 * data.errors.tracking, Y_COLOUR, 2),
        *_counted(data),
    ]
    return Figure(
        "errors",
        "Errors in time",
        "Contour: to the nearest point of the contour. Tracking: to the point that was due. "
        f"Dotted: where the errors begin and end to count.{told}",
        traces,
        layout(_TIME, ["contour error [µm]", "tracking error [µm]"]),
        linked=True,
        height=520,
    )


def _counted(data: ContourReportData) -> list[Trace]:
    task, period = data.machine.task, data.design.sample_time_s
    traces = []
    for panel, values in ((1, data.errors.contour), (2, data.errors.tracking)):
        top = 1e6 * float(np.max(values))
        for place in (task.first, task.last):
            at = period * place
            traces.append(
                line("counted", (at, at), (0.0, top), PATH_COLOUR, 1.0, panel, showlegend=False,
                     hoverinfo="skip", line={"dash": "dot"})
            )  # fmt: skip
    return traces


def command_figure(data: ContourReportData) -> Figure:
    """Commands of every axis against their limits, and points ahead with a direction."""
    time, span = _time(data)
    traces: list[Trace] = []
    shares = data.run.command / data.machine.limits
    for a, name in enumerate(data.machine.names):
        traces.append(signal(name, time, shares[:, a], COLOURS[name], 1))
    if np.max(np.abs(shares)) > 0.25:
        traces += limits(span, 1.0, 1)
    known, titles = data.run.known.astype(np.float64), ["command / limit [1]"]
    told = "As shares of their limits. "
    if np.ptp(known) > 0.0:
        held = {"line": {"shape": "hv"}}
        traces.append(signal("points known", time, known, PATH_COLOUR, 2, **held))
        titles.append("points [1]")
        told += "Below: points ahead with a direction; without one every error is one of contour."
    else:
        told += f"All {number(data.design.preview)} points ahead had a direction in every sample."
    shape = layout(_TIME, titles)
    return Figure("commands", "Commands", told, traces, shape, linked=True, height=400)


def _time(data: ContourReportData) -> tuple[FloatArray, tuple[float, float]]:
    time = data.design.sample_time_s * np.arange(len(data.run.output))
    return time, (0.0, float(time[-1]))


def _curve(name: str, points: FloatArray, tolerance: float, colour: str, width: float) -> Trace:
    kept = points[simplify(points, tolerance)]
    exact = {"simplify": False}  # else plotly makes polygons of small circles
    return line(name, kept[:, 0], kept[:, 1], colour, width, line=exact)
