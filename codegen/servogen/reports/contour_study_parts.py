"""The comparison of a contour controller's page: spectra, sweeps, the table."""

from __future__ import annotations

import numpy as np

from servogen.controllers.contour_stability import FrozenSpectrum
from servogen.controllers.contour_weights import Terminal
from servogen.reports.contour_data import ContourReportData
from servogen.reports.style import (
    PATH_COLOUR,
    X_COLOUR,
    Y_COLOUR,
    Figure,
    Trace,
    layout,
    line,
)
from servogen.reports.tables import BAD, PLAIN, Cell, Missing, Table, figure_cell, share_cell, text
from servogen.systems.contour_proofs import design_spectrum
from servogen.systems.contour_rows import ContourRow
from servogen.systems.contour_study import PLAIN_ALL, ContourStudy, ContourSweep

_ENDS = {
    Terminal.OUTPUT: ("C'QC at the end", Y_COLOUR),
    Terminal.STATIONARY: ("H_s(Q_max) at the end", X_COLOUR),
}
_MARKED = {"mode": "lines+markers", "marker": {"size": 7}}


def spectrum_figure(data: ContourReportData) -> Figure:
    """Largest modulus over direction at the project's preview, and over the preview."""
    spectra = data.study.spectra if data.study else (design_spectrum(data.design),)
    traces: list[Trace] = []
    flat = len(data.machine.axes) == 2
    for spectrum in spectra:
        name, colour = _ENDS[spectrum.terminal]
        own = spectrum.modulus[data.design.preview - 1]
        group = {"legendgroup": name}
        places, values = _by_direction(spectrum, own, flat)
        traces.append(line(name, places, values, colour, 1.6, 1, **group))
        count = len(spectrum.modulus)
        worst = spectrum.modulus.max(axis=1)
        marked = {**_MARKED, **group, "showlegend": False}
        traces.append(
            line(name, np.arange(1.0, count + 1.0), worst, colour, 1.6, 2,
                 **{**marked, "xaxis": "x2"})
        )  # fmt: skip
    shape = layout("", ["largest modulus [1]"])
    shape["xaxis"] |= {
        "domain": [0.0, 0.47],
        "title": {"text": "direction of the contour [deg]" if flat else "direction [1]"},
    }
    shape["xaxis2"] = {
        "domain": [0.56, 1.0],
        "anchor": "y2",
        "zeroline": False,
        "title": {"text": "preview N_p [samples]"},
    }
    shape["yaxis2"] = {
        "anchor": "x2",
        "zeroline": False,
        "title": {"text": "largest modulus, any direction [1]"},
    }
    shape["hovermode"] = "closest"
    told = " ".join(data.notes) or "No choice made here comes near the unit circle."
    return Figure(
        "spectrum",
        "Closed loop on straight contours",
        f"Largest eigenvalue modulus of (17) in the project's weights: by direction with its "
        f"preview of {data.design.preview} points, and by preview over all directions. With "
        f"H_s(Q_max) below one by Theorem 1; with C'QC by what is seen here. {told}",
        traces,
        shape,
        height=400,
    )


def _by_direction(
    spectrum: FrozenSpectrum, modulus: np.ndarray, flat: bool
) -> tuple[np.ndarray, np.ndarray]:
    if not flat:
        return np.arange(1.0, len(modulus) + 1.0), modulus
    angle = np.degrees(np.arctan2(spectrum.directions[:, 1], spectrum.directions[:, 0]))
    return np.append(angle, 180.0), np.append(modulus, modulus[0])


def study_parts(data: ContourReportData) -> list[object]:
    """Figures and tables, or what to run for them."""
    study = data.study
    if study is None:
        return [Missing("The controllers have not been compared", f"servogen study {data.toml}")]
    return [trade_figure(study), *_sweep_figures(study), study_table(study), *trouble_tables(study)]


def trade_figure(study: ContourStudy) -> Figure:
    """Contour against tracking error, both logarithmic."""
    groups = (
        ("this project", X_COLOUR, "circle", [r for r in study.rows if _own(r)]),
        ("the paper's cases", Y_COLOUR, "diamond", [r for r in study.rows if _case(r)]),
        (
            "plain tracking, finite preview",
            PATH_COLOUR,
            "circle-open",
            [r for r in study.rows if not (_own(r) or _case(r))],
        ),
    )
    traces = [_marks(*group) for group in groups if group[3]]
    shape = layout("tracking error [µm RMS]", ["contour error [µm RMS]"])
    shape["hovermode"] = "closest"
    ticks = [round(m * 10.0**e, 4) for e in range(-3, 6) for m in (1, 2, 5)]
    for axis in ("xaxis", "yaxis"):
        shape[axis] |= {"type": "log", "tickvals": ticks, "automargin": True}
    return Figure(
        "trade",
        "Contour against tracking error",
        "Low is what counts for the part; left is what counts for the clock. Point at a mark for "
        "its name.",
        traces,
        shape,
        height=480,
    )


def _own(row: ContourRow) -> bool:
    return row.name.startswith("this project")


def _case(row: ContourRow) -> bool:
    return row.name.startswith("case ")


def _mark(row: ContourRow) -> str:
    """What stands beside a mark: of the paper's cases, and of the rival."""
    if _case(row):
        return row.name.split(":")[0]
    return "plain, alpha + beta" if row.name == PLAIN_ALL else ""


def _marks(name: str, colour: str, symbol: str, rows: list[ContourRow]) -> Trace:
    cases = [_mark(row) for row in rows]
    return {
        "type": "scatter",
        "mode": "markers+text",
        "name": name,
        "x": [float(f"{1e6 * row.tracking_rms_m:.5g}") for row in rows],
        "y": [float(f"{1e6 * row.contour_rms_m:.5g}") for row in rows],
        "text": cases,
        "customdata": [row.name for row in rows],
        "textposition": "top center",
        "textfont": {"size": 12, "color": colour},
        "hovertemplate": "%{customdata}: tracking %{x}, contour %{y}<extra></extra>",
        "marker": {
            "size": 10,
            "color": colour,
            "symbol": symbol,
            "line": {"width": 2, "color": colour},
        },
        "cliponaxis": False,
    }


def _sweep_figures(study: ContourStudy) -> list[Figure]:
    previews = [s for s in study.sweeps if s.title.startswith("Preview")]
    weights = [s for s in study.sweeps if s.title.startswith("Contour weight")]
    return [
        _sweep_figure("previews", "How much preview", previews),
        _sweep_figure("weights", "How much contour weight", weights),
    ]


def _sweep_figure(name: str, title: str, sweeps: list[ContourSweep]) -> Figure:
    """Contour errors above, tracking errors below."""
    traces: list[Trace] = []
    for sweep, colour in zip(sweeps, (Y_COLOUR, X_COLOUR), strict=False):
        for panel, what in ((1, "contour_rms_m"), (2, "tracking_rms_m")):
            values = [1e6 * getattr(row, what) for row in sweep.rows]
            own = {**_MARKED, "legendgroup": sweep.title, "showlegend": panel == 1}
            traces.append(line(sweep.title, sweep.values, values, colour, 1.6, panel, **own))
    shape = layout(sweeps[0].key, ["contour error [µm RMS]", "tracking error [µm RMS]"])
    for axis, what in (("yaxis", "contour_rms_m"), ("yaxis2", "tracking_rms_m")):
        values = [1e6 * getattr(row, what) for sweep in sweeps for row in sweep.rows]
        shape[axis] |= {"type": "log", "tickvals": _ticks(values)}
    told = " ".join(f"{sweep.title}: {sweep.note}" for sweep in sweeps)
    return Figure(name, title, told, traces, shape, height=520)


def _ticks(values: list[float]) -> list[float]:
    """Of a logarithmic axis: decades, with 2 and 5 between where there are few of them."""
    steps = (1,) if max(values) > 200.0 * min(values) else (1, 2, 5)
    return [round(m * 10.0**e, 5) for e in range(-4, 6) for m in steps]


def study_table(study: ContourStudy) -> Table:
    """Every row of the comparison."""
    columns: tuple[str, ...] = (
        *("controller", "tracking RMS [µm]", "largest [µm]", "contour RMS [µm]", "largest [µm]"),
        *("command of limit", "cut in samples"),
    )
    note = (
        "The project's contour at its feed, the whole state known but where encoders are named. "
        "With alpha + beta on every error, tracking is weighted as heavily as contour is here: "
        "what contour weight is worth shows against that. "
        "The paper's weights are for these drives times "
        f"{study.scale:.3g}, which makes them mean the same here."
    )
    rows = tuple(map(_row, study.rows))
    if not any(row.limited for row in study.rows):
        columns, rows = columns[:-1], tuple(row[:-1] for row in rows)
    return Table("Comparison", columns, rows, note)


def trouble_tables(study: ContourStudy) -> list[Table]:
    """What contour weight is worth where the machine cannot do as it is told."""
    if not study.troubles:
        return []
    columns = ("trouble and controller", "tracking RMS [µm]", "largest [µm]", "contour RMS [µm]",
               "largest [µm]")  # fmt: skip
    note = (
        "The same contour on a machine that cannot do as it is told, which the controller does not "
        "know. With contour weight the other axis waits; plain tracking of the same weight goes on "
        "without the one that is behind."
    )
    rows = tuple(_row(row)[: len(columns)] for row in study.troubles)
    return [Table("In trouble", columns, rows, note)]


def _row(row: ContourRow) -> tuple[Cell, ...]:
    errors = (row.tracking_rms_m, row.tracking_max_m, row.contour_rms_m, row.contour_max_m)
    return (
        text(row.name, "name"),
        *(figure_cell(1e6 * value, 3) for value in errors),
        share_cell(max(row.command_share)),
        figure_cell(row.limited, kind=BAD if row.limited else PLAIN),
    )
