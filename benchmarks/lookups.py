"""Explicit lookups of a first move: servogen's forms, sequential search, PPOPT, solvers on line.

    python benchmarks/lookups.py [--quick] [--only NAME ...] [-o FOLDER]

Counts instructions per call with valgrind's callgrind, judges every move against the program solved
in float64, and writes a table, lookups.json, lookups.md and lookups.html. Status 0 where all
promises are kept, 1 where one is broken or was not measured or a tool is missing, 2 where nothing
has the name given. ``--quick`` and ``--only`` are for trying it out: then no promise is judged, and
the files are named lookups_part.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import numpy as np
import plotly.graph_objects as go
from lookup.contenders import BEATEN, CHOSEN, CONTENDERS, OWN, Explicit
from lookup.programs import programs
from qp.chosen import UnknownName
from qp.counted import COMPILER, FLAGS, Measured, PeerFailed
from qp.document import lookup_parts
from qp.promises import Promise, as_rows, status
from qp.told import numbers, show_promises, write, write_json
from qp.tolerance import ACCURACY
from rich.console import Console
from rich.table import Table

Results = Mapping[str, Mapping[str, Measured]]


def measure(given: Explicit, work: Path) -> tuple[dict[str, Measured], dict[str, str]]:
    """Results by contender, and why the others gave none."""
    found: dict[str, Measured] = {}
    failed: dict[str, str] = {}
    for name, contender in CONTENDERS:
        folder = work / "".join(c if c.isalnum() else "_" for c in name)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            found[name] = contender(given, folder)
        except PeerFailed as why:
            failed[name] = str(why)
    return found, failed


def promises(results: Results) -> list[Promise]:
    """The chosen form is never slower than any other lookup, and all of ours are right."""
    made = []
    for program, found in results.items():
        others = [float(np.max(found[name].cost)) for name in BEATEN if name in found]
        own = found.get(CHOSEN)
        ratio = None if own is None or not others else float(np.max(own.cost)) / min(others)
        told = f"{program}: maximum of the chosen form by the best sequential search's or PPOPT's"
        made.append(Promise(told, 1.0, ratio))
    ours = [found[name] for found in results.values() for name in OWN if name in found]
    largest = max((float(np.max(m.error)) for m in ours), default=None)
    made.append(Promise("servogen's lookups: largest error", ACCURACY, largest))
    missed = float(sum(int(np.sum(~m.solved)) for m in ours)) if ours else None
    made.append(Promise("servogen's lookups: parameters without a move", 0, missed))
    return made


def as_json(
    given: Explicit, found: Mapping[str, Measured], failed: Mapping[str, str]
) -> dict[str, Any]:
    rows: dict[str, Any] = {}
    for name, _ in CONTENDERS:  # in their order
        if name in found:
            rows[name] = numbers(found[name], None)
        else:
            rows[name] = {"failed": failed[name]}
    program = given.program
    return {
        "name": program.name,
        "source": program.source,
        "asked": len(program.theta),
        "variables": program.qp.variables,
        "contenders": rows,
    }


def show(told: Mapping[str, Any], console: Console) -> None:
    title = f"{told['name']}: {told['variables']} variables; {told['source']}"
    table = Table(title=title, title_justify="left", show_edge=False)
    table.add_column("", no_wrap=True)
    for head in ("median", "p99", "max", "median us", "error", "tables", "workspace", "code"):
        table.add_column(head, justify="right")
    table.add_column("")
    for name, row in told["contenders"].items():
        if "failed" in row:
            continue
        missed = "" if row["accurate"] and not row["unsolved"] else " [red]MISSED[/]"
        table.add_row(
            name, *(f"{row[key]:,.0f}" for key in ("median", "p99", "max")),
            f"{row['median_us']:.3f}", f"{row['error']:.0e}{missed}",
            *(f"{row[key]:,}" for key in ("table_bytes", "workspace_bytes", "code_bytes")),
            row["note"],
        )  # fmt: skip
    console.print(table)
    for name, row in told["contenders"].items():
        if "failed" in row:
            console.print(f"   {name}: {row['failed']}", style="red", highlight=False)
    console.print()


def plot(told: list[dict[str, Any]], path: Path) -> None:
    """Maxima over the control horizon of the servo drive."""
    figure = go.Figure()
    driven = [each for each in told if each["name"].startswith("servo_drive_")]
    for name, _ in CONTENDERS:
        points = [
            (each["variables"], each["contenders"][name]["max"])
            for each in driven
            if "failed" not in each["contenders"][name]
        ]
        if points:
            own = name.startswith("servogen")
            figure.add_scatter(
                x=[p[0] for p in points], y=[p[1] for p in points], name=name,
                mode="lines+markers", line={"dash": "solid" if own else "dash"},
            )  # fmt: skip
    figure.update_xaxes(title="control horizon H_u", dtick=1)
    figure.update_yaxes(type="log", title="instructions, the most of a call", dtick=1)
    figure.update_layout(
        template="plotly_white", width=900, height=560,
        title="First move of the servo drive: servogen (full), others (dashed)",
    )  # fmt: skip
    write(
        figure.to_html(
            include_plotlyjs=True,
            full_html=True,
            div_id="lookups",
            config={"displayModeBar": False},
        ),
        path,
    )


def main() -> int:
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("-o", "--output", type=Path, default=Path("out/bench"))
    reader.add_argument("--quick", action="store_true", help="short horizons")
    reader.add_argument(
        "--only", nargs="+", default=[], metavar="NAME",
        help="programs: whole names, or what names begin with before an underscore",
    )  # fmt: skip
    given = reader.parse_args()
    for tool in (COMPILER, "valgrind", "nm"):
        if shutil.which(tool) is None:
            print(f"this benchmark needs {tool}")
            return 1
    given.output.mkdir(parents=True, exist_ok=True)
    try:
        return compare(given.output, given.quick, tuple(given.only))
    except UnknownName as unknown:
        print(f"{reader.prog}: {unknown}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("broken off: nothing written")
        return 130


def compare(output: Path, quick: bool, only: tuple[str, ...]) -> int:
    begin, console = time.monotonic(), Console(width=max(170, Console().width))
    work = output.resolve() / "work"
    told: list[dict[str, Any]] = []
    results: dict[str, dict[str, Measured]] = {}
    for program in programs(quick, only):
        given = Explicit(program)
        found, failed = measure(given, work)
        results[program.name] = found
        told.append(as_json(given, found, failed))
        show(told[-1], console)
    whole = not (quick or only)
    made = promises(results) if whole else []
    show_promises(made, console)
    written = {
        "schema": "servogen.bench.lookups/1",
        "whole": whole,
        "seconds": round(time.monotonic() - begin),
        "flags": list(FLAGS),
        "accuracy": ACCURACY,
        "programs": told,
        "promises": as_rows(made),
    }
    name = "lookups" if whole else "lookups_part"
    write_json(written, output / f"{name}.json")
    write("\n\n".join(lookup_parts(written).values()) + "\n", output / f"{name}.md")
    plot(told, output / f"{name}.html")
    minutes = (time.monotonic() - begin) / 60.0
    console.print(f"{output / name}.json, .md, .html: {minutes:.1f} minutes", highlight=False)
    return status(made)


if __name__ == "__main__":
    sys.exit(main())
