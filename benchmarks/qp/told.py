"""The benchmark's table, its JSON and its plot."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from rich.console import Console
from rich.table import Table

from qp.counted import Measured
from qp.peers import DAQP
from qp.promises import Promise
from qp.sequence import Sequence
from qp.timed import BASE
from qp.tolerance import ACCURACY

Failed = Mapping[str, str]
SHARES = ("median_by_daqp", "max_by_daqp", "time_by_daqp")


def numbers(m: Measured, base: Measured | None) -> dict[str, Any]:
    """What is told of one solver on one sequence; ratios over the programs that it solved."""
    row: dict[str, Any] = {
        "unit": m.unit,
        "programs": len(m.cost),
        "median": float(np.median(m.cost)),
        "p99": float(np.percentile(m.cost, 99)),
        "max": float(np.max(m.cost)),
        "error": float(np.max(m.error)),
        "residual": float(np.max(m.residual)),
        "unsolved": int(np.sum(~m.solved)),
        "accurate": bool(np.max(m.error) <= ACCURACY),
        "iterations_max": int(np.max(m.iterations)),
        "median_us": float(1e6 * np.median(m.seconds)) if m.seconds.size else None,
        "max_us": float(1e6 * np.max(m.seconds)) if m.seconds.size else None,
        "code_bytes": m.code,
        "table_bytes": m.kept,
        "workspace_bytes": m.written,
        "note": m.note,
    }
    if base is not None and base.part.start <= m.part.start and m.part.stop <= base.part.stop:
        first = m.part.start - base.part.start
        same = base.cost[first : first + len(m.cost)]
        row["median_by_daqp"] = float(np.median(m.cost) / np.median(same))
        row["max_by_daqp"] = float(np.max(m.cost) / np.max(same))
        if m.seconds.size and base.seconds.size:
            spent = base.seconds[first : first + len(m.cost)]
            row["time_by_daqp"] = float(np.median(m.seconds) / np.median(spent))
    return row


def as_json(sequence: Sequence, found: Mapping[str, Measured], failed: Failed) -> dict[str, Any]:
    solvers: dict[str, Any] = {}
    for name, m in found.items():
        base = found.get(DAQP if m.unit == "instructions" else BASE)
        solvers[name] = numbers(m, base)
    for name, why in failed.items():
        solvers[name] = {"failed": why}
    return {
        "name": sequence.name,
        "source": sequence.source,
        "variables": sequence.variables,
        "rows": sequence.count,
        "programs": sequence.length,
        "active_median": float(np.median(sequence.active)),
        "active_max": int(np.max(sequence.active)),
        "solvers": solvers,
    }


def _bytes(value: int) -> str:
    return "-" if value < 0 else f"{value:,}"


def _cost(row: Mapping[str, Any], name: str) -> str:
    return f"{row[name]:,.0f}" if row["unit"] == "instructions" else f"{1e6 * row[name]:.1f} us"


def show(told: Mapping[str, Any], console: Console) -> None:
    """One sequence's table."""
    if "missing" in told:
        console.print(f"{told['name']}: {told['missing']}\n", style="red", highlight=False)
        return
    title = (
        f"{told['name']}: {told['variables']} variables, {told['rows']} rows, working sets to "
        f"{told['active_max']} ({told['source']})"
    )
    table = Table(title=title, title_justify="left", show_edge=False)
    table.add_column("solver", no_wrap=True)
    for head in ("programs", "median", "p99", "max", "median / DAQP", "max / DAQP", "us / DAQP",
                 "error", "residual", "tables", "workspace", "code"):  # fmt: skip
        table.add_column(head, justify="right")
    for name, row in told["solvers"].items():
        if "failed" in row:
            continue
        by = [f"{row[k]:.3f}" if k in row else "-" for k in SHARES]
        missed = "" if row["accurate"] else " [red]MISSED[/]"
        count = str(row["programs"])
        if row["unsolved"]:
            count += f" [red]({row['unsolved']} unsolved)[/]"
        table.add_row(
            name, count, _cost(row, "median"), _cost(row, "p99"), _cost(row, "max"), *by,
            f"{row['error']:.0e}{missed}", f"{row['residual']:.0e}", _bytes(row["table_bytes"]),
            _bytes(row["workspace_bytes"]), _bytes(row["code_bytes"]),
        )  # fmt: skip
    console.print(table)
    for name, row in told["solvers"].items():
        if "failed" in row:
            console.print(
                f"   {name}: {row['failed']}", style="red", highlight=False, soft_wrap=True
            )
    console.print()


def show_promises(made: list[Promise], console: Console) -> None:
    """All promises; of what is only reported, what does not hold."""
    for promise in made:
        if promise.promised or not promise.kept:
            alarm = "red" if promise.promised else "yellow"
            style = "" if promise.kept else alarm
            console.print(promise.sentence(), style=style, highlight=False, soft_wrap=True)


def growth(
    sequences: list[dict[str, Any]], prefix: str
) -> dict[str, list[tuple[int, float, float]]]:
    """Horizon, median and maximum of the instructions by solver, of the loops so named."""
    lines: dict[str, list[tuple[int, float, float]]] = {}
    for told in sequences:
        if not told["name"].startswith(prefix) or "missing" in told:
            continue
        for name, row in told["solvers"].items():
            if row.get("unit") == "instructions":
                lines.setdefault(name, []).append((told["variables"], row["median"], row["max"]))
    return lines


def plot(lines: Mapping[str, list[tuple[int, float, float]]], path: Path) -> None:
    """Growth with the horizon, both axes logarithmic: full lines maxima, dotted ones medians."""
    colours = (
        "#444444", "#0b6e99", "#5aa9c9", "#8a5aa9", "#c96f0b", "#a90b3c", "#2f8f4e", "#9aa02c",
        "#b8860b", "#c06fa8",
    )  # fmt: skip
    figure = go.Figure()
    for (name, points), colour in zip(lines.items(), colours, strict=False):
        horizon = [p[0] for p in points]
        for i, dash in ((2, "solid"), (1, "dot")):
            figure.add_scatter(
                x=horizon, y=[p[i] for p in points], name=name, legendgroup=name,
                showlegend=i == 2, mode="lines+markers", line={"color": colour, "dash": dash},
            )  # fmt: skip
    figure.update_xaxes(
        type="log", title="horizon, steps", tickvals=[5, 10, 20, 30, 50], range=[0.65, 1.75]
    )
    figure.update_yaxes(type="log", title="instructions per solve", dtick=1)
    figure.update_layout(
        template="plotly_white", width=900, height=560,
        title="Maximum (full), median (dotted); of those around the largest working set where slow",
    )  # fmt: skip
    write(
        figure.to_html(
            include_plotlyjs=True, full_html=True, div_id="growth", config={"displayModeBar": False}
        ),
        path,
    )


def write(text: str, path: Path) -> None:
    """In one go: a run that is broken off leaves no half of a file."""
    part = path.with_suffix(path.suffix + ".part")
    part.write_text(text)
    part.replace(path)


def write_json(told: dict[str, Any], path: Path) -> None:
    write(json.dumps(told, indent=1) + "\n", path)
