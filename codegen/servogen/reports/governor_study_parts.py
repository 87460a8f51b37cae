"""The comparison of a command governor's page: a picture, its table, and what the options do."""

from __future__ import annotations

import math

import numpy as np

from servogen.reports.governor_data import GovernorReportData
from servogen.reports.numbers import NOTHING, percent
from servogen.reports.style import PATH_COLOUR, X_COLOUR, Figure, Trace, layout
from servogen.reports.tables import BAD, MUTED, PLAIN, Cell, Missing, Table, figure_cell, text
from servogen.systems.command_governor_rows import GovernorRow
from servogen.systems.command_governor_study import EXTENDED, GovernorStudy
from servogen.systems.command_governor_sweeps import REFERENCES, Sweep, Trial

# Of both logarithmic axes: plotly's own leave out most decades.
_TICKS = [round(m * 10.0**e, 3) for e in range(-3, 5) for m in (1, 2, 5)]


def study_parts(data: GovernorReportData) -> list[object]:
    """Figure and tables, or what to run for them."""
    study = data.study
    if study is None:
        return [Missing("The controllers have not been compared", f"servogen study {data.toml}")]
    return [_figure(study), _table(study), *map(_sweep, study.sweeps)]


def used_cell(excess: float, tolerance: float, over: str) -> Cell:
    """Share of a limit that was used; ``over``: how it is coloured beyond the limit."""
    kind = over if excess > tolerance else PLAIN
    return Cell(percent(1.0 + excess), kind, numeric=True)


def _rms(row: GovernorRow) -> float:
    return float(np.sqrt(np.mean(np.square(row.motion.rms_acceleration))))


def _figure(study: GovernorStudy) -> Figure:
    """Time against noise, both logarithmic: the low pass is far away from the rest."""
    done = [row for row in study.rows if row.complete]
    own = [row for row in done if row.name.startswith(EXTENDED)]
    others = [row for row in done if row not in own]
    traces = [
        _marks("extended governor", own, X_COLOUR, "circle", ("bottom",)),
        _marks("others", others, PATH_COLOUR, "circle-open", ("top", "bottom", "bottom", "top")),
    ]
    shape = layout("RMS acceleration of both axes [m/s²]", ["time [s]"])
    shape["hovermode"] = "closest"
    for axis in ("xaxis", "yaxis"):
        shape[axis] |= {"type": "log", "tickvals": _TICKS, "automargin": True}
    return Figure(
        "study",
        "Time against acceleration",
        f"Left and low is better. Nothing is faster than {study.ideal_s:.2f} s, and the minimal "
        f"motion at the greatest velocity alone takes {study.velocity_bound_s:.2f} s.",
        [trace for trace in traces if trace["x"]],
        shape,
        height=520,
    )


def _marks(
    name: str, rows: list[GovernorRow], colour: str, symbol: str, places: tuple[str, ...]
) -> Trace:
    """``places`` of the names, in turn: neighbours in the list are neighbours in the picture."""
    edge = {"width": 2, "color": colour}
    return {
        "type": "scatter",
        "mode": "markers+text",
        "name": name,
        "x": [float(f"{_rms(row):.5g}") for row in rows],
        "y": [float(f"{row.time_s:.6g}") for row in rows],
        "text": [row.name for row in rows],
        "textposition": [f"{places[i % len(places)]} center" for i in range(len(rows))],
        "textfont": {"size": 11, "color": colour},
        "hovertemplate": "%{text}: %{y:.2f} s, %{x:.3f} m/s²<extra></extra>",
        "marker": {"size": 10, "color": colour, "symbol": symbol, "line": edge},
        "cliponaxis": False,
    }


def _table(study: GovernorStudy) -> Table:
    columns = ("controller", "time [s]", "of ideal", "largest |a| [m/s²]", "RMS a [m/s²]",
               "covered [m]", "work [J/kg]", "iterations", "velocity kept", "velocity between",
               "stroke kept", "stroke between")  # fmt: skip
    note = (
        "One machine and drawing; largest and RMS acceleration of both axes, distance and work "
        "summed over them; limits where the extended governor keeps them, and at every fast "
        "sample. SPRG commands points of its reference and plans nothing. The two-stage "
        "controllers know one reference for tool and stage: on the pattern they have the whole "
        "stroke; a minimal motion beside the pattern is nothing they can be told, so there they "
        "follow one that leaves half the stroke, and may lag behind it by that half. The low pass "
        "has the highest uniform feed that keeps every limit."
    )
    return Table("Comparison", columns, tuple(map(_row, study.rows)), note)


def _row(row: GovernorRow) -> tuple[Cell, ...]:
    motion = row.motion
    figures = (
        row.time_s, row.time_s / row.ideal_s, max(motion.largest_acceleration), _rms(row),
        sum(motion.distance_m), sum(motion.work_j_per_kg), row.iterations[0],
    )  # fmt: skip
    shares = (row.instants.velocity, row.between.velocity, row.instants.stroke, row.between.stroke)
    if not row.complete:
        empty = Cell(NOTHING, MUTED, numeric=True)
        return (text(f"{row.name}: {row.stopped}"), *([empty] * (len(figures) + len(shares))))
    return (
        text(row.name, "name"),
        *(figure_cell(value) for value in figures),
        *(text(NOTHING) if math.isnan(s) else used_cell(s, row.tolerance, PLAIN) for s in shares),
    )


def _sweep(sweep: Sweep) -> Table:
    """A setting a line: each figure on the minimal motion and on the pattern."""
    columns = [""]
    for told in REFERENCES.values():
        columns += [
            f"{told}: time [s]",
            "largest |a| [m/s²]",
            "velocity beyond",
            "stroke beyond",
        ]
    rows = tuple((text(trial.told, "name"), *_trial(trial)) for trial in sweep.trials)
    return Table(sweep.title, tuple(columns), rows, sweep.note)


def _trial(trial: Trial) -> list[Cell]:
    cells: list[Cell] = []
    for row in trial.rows:
        if not row.complete:
            empty = Cell(NOTHING, MUTED, numeric=True)
            cells += [text(row.stopped), empty, empty, empty]
            continue
        broken = BAD if row.broken else PLAIN
        cells += [
            figure_cell(row.time_s, kind=broken),
            figure_cell(max(row.motion.largest_acceleration), 3),
            Cell(f"{100.0 * row.between.velocity:+.2f} %", numeric=True),
            Cell(trial.over_stroke(row), numeric=True),
        ]
    return cells
