"""The head of a two-stage machine's page: what was made, how well it does, in words and figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from servogen.reports.data import ReportData
from servogen.reports.numbers import fixed, number, percent
from servogen.reports.path_figure import slowed_intervals
from servogen.reports.tiles import KeyFigure, cycles_tile

_KINDS = {
    "sprg_mpc": "a spatial reference governor with tracking MPC",
    "sprg": "a spatial reference governor alone",
    "lfs": "low-pass frequency separation",
}


def summary(data: ReportData) -> str:
    """One paragraph for somebody who reads nothing else."""
    p, machine = data.row.performance, data.machine
    path = machine.timed.tool_path.points
    length = float(np.sum(np.hypot(*np.diff(path, axis=0).T)))
    kind = _KINDS.get(machine.project.controller.kind, machine.project.controller.kind)
    drawing = Path(machine.project.path.file).name
    parts = [
        f"Two-stage machine “{machine.project.name}” under {kind}, drawing "
        f"{drawing}: {number(length, 3)} m of path in {fixed(p.time_s, 2)} s, "
        f"{_over_ideal(p.ratio)} the {fixed(machine.timed.duration_s, 2)} s of an ideal machine "
        "that has the slow stage's reach and the fast stage's speed."
    ]
    if not data.row.complete:
        parts[0] = (
            f"Two-stage machine “{machine.project.name}” under {kind} did not finish its drawing "
            f"{drawing} within {fixed(p.time_s, 2)} s."
        )
    worst = max((b for b in data.row.bounds if b.enforced), key=lambda b: b.worst / b.limit)
    parts.append(
        f"Of the enforced constraints the most used is “{worst.name}” at "
        f"{percent(worst.worst / worst.limit)} of its limit; the tool stays within "
        f"{number(1e6 * data.row.contour_error_m, 3)} µm of the path."
    )
    return " ".join(parts)


def _over_ideal(ratio: float) -> str:
    return f"{percent(ratio - 1.0)} more than" if ratio >= 1.0 else f"{percent(1.0 - ratio)} below"


def key_figures(data: ReportData) -> list[KeyFigure]:
    """The tiles, in the order of interest."""
    row, p = data.row, data.row.performance
    worst = max((b for b in row.bounds if b.enforced), key=lambda b: b.worst / b.limit)
    slowed = float(np.mean(slowed_intervals(data.run))) if data.run.periods else 0.0
    tiles = [
        KeyFigure("Completion time", f"{fixed(p.time_s, 2)} s", f"{fixed(p.ratio, 4)} of ideal"),
        KeyFigure(
            "Slowed down",
            percent(slowed),
            f"of {number(row.periods)} slow periods",
        ),
        KeyFigure(
            "Worst constraint use",
            percent(worst.worst / worst.limit),
            f"{worst.name}, {worst.where}",
        ),
        KeyFigure(
            "Contour error",
            f"{number(1e6 * row.contour_error_m, 3)} µm",
            f"limit {number(1e6 * data.contour_limit_m)} µm",
        ),
        KeyFigure(
            "Backups",
            number(row.backups),
            f"of {number(2 * row.periods)} axis steps",
        ),
        cycles_tile(data),
        KeyFigure("Design", data.digest[:8], f"{data.design.governor.precision.name}, sha-256"),
    ]
    return tiles
