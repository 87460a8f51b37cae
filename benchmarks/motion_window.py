"""What a window of the streamed minimal motion loses, on both axes of the bundled drawing.

    python benchmarks/motion_window.py [--stroke 0.035] [--margin 0.001] [--block 150]
        [--picture FILE.png] [WINDOW ...]

The path is streamed through the emitted C, block after block; every row is held against the motion
of the whole path: share of the references that were settled when they went out, distance, largest
difference, sum of squared steps, largest step, share of points within a micron of the envelope.
Status 1 where a point left the tube by more than rounding, or where a window covered more distance
than an end that it cannot see explains: four times the reach on an axis. The picture shows some
seconds of the first axis with the first of the windows, and needs a Chromium.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import numpy as np
import plotly.graph_objects as go
from write_docs import picture

from servogen.controllers.design import Status, Value
from servogen.controllers.motion_window_design import MotionWindowDesign, declare_motion_window
from servogen.emit.package import emit_package
from servogen.paths.minimal_motion import look_ahead, pattern_motion, tube_around
from servogen.precision import FLOAT64, FloatArray
from servogen.project import load_project
from servogen.resources import resource_dir
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.judgement import timed_path

WINDOWS = (1, 150, 500, 1000, 2000, 4000, 8000, 16000, 32000, 64000)
TOUCHING_M = 1e-6
# Of the picture: the part shown, and every which point of it is drawn.
PERIOD_S, SHOWN_S, EVERY = 2e-4, (12.0, 18.0), 10


def streamed(
    controller: CompiledController, path: FloatArray, block: int
) -> tuple[FloatArray, int]:
    """References of a path, and how many of them were settled."""
    controller.call("reset", {"start": float(path[0])})
    references, settled, at, status = [], 0, 0, Status.OK
    while status is not Status.FINISHED:
        some = path[at : at + block]
        at += block
        points = np.zeros(block)
        points[: some.size] = some
        inputs: dict[str, Value] = {
            "points": points,
            "n_points": some.size,
            "ended": int(at >= path.size),
        }
        status, out = controller.call("step", inputs)
        references.append(np.asarray(out["reference"])[: int(np.asarray(out["n_references"]))])
        settled += int(np.asarray(out["n_decided"]))
    return np.concatenate(references), settled


def row(window: int, settled: float, y: FloatArray, best: FloatArray, room: FloatArray) -> str:
    """A line of the table; all arrays (points, 2), ``room`` to the envelope."""
    steps, own = np.abs(np.diff(best, axis=0)), np.abs(np.diff(y, axis=0))
    more = float(own.sum() / steps.sum()) - 1.0
    return (
        f"| {window:,} | {100.0 * settled:.0f} % | {more:+.0e} | "
        f"{1e3 * np.abs(y - best).max():.1f} mm | {np.sum(own**2) / np.sum(steps**2):.3f} | "
        f"{own.max() / steps.max():.2f} | {100.0 * np.mean(room < TOUCHING_M):.0f} % |"
    )


def draw(motions: dict[str, FloatArray], path: FloatArray, reach: float, image: Path) -> None:
    """Pattern, envelope and motions (mm) over time (s) between ``SHOWN_S``."""
    begin, end = (round(time / PERIOD_S) for time in SHOWN_S)
    shown = slice(begin, end, EVERY)
    t = PERIOD_S * np.arange(path.size)[shown]
    figure = go.Figure()
    curves = {"pattern": path, **motions, "envelope": path - reach, "": path + reach}
    styles = [
        ("#8a94a0", 1.0),
        ("#1f86cc", 2.5),
        ("#e69f00", 1.5),
        ("#e34a33", 1.0),
        ("#e34a33", 1.0),
    ]
    for (name, values), (colour, width) in zip(curves.items(), styles, strict=True):
        line = {"color": colour, "width": width}
        figure.add_scatter(
            x=t, y=1e3 * values[shown], name=name, showlegend=bool(name), mode="lines", line=line
        )
    figure.update_layout(
        template="plotly_white", width=900, height=560, margin=dict(l=60, r=20, t=20, b=45),
        xaxis_title="time (s)", yaxis_title="x (mm)", legend=dict(orientation="h", y=1.06),
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "motion.html"
        figure.write_html(page, include_plotlyjs=True, config={"displayModeBar": False})
        if not picture(page, image.resolve()):
            print("no picture: no Chromium here")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("windows", nargs="*", type=int, default=list(WINDOWS))
    parser.add_argument("--stroke", type=float, default=0.035)
    parser.add_argument("--margin", type=float, default=0.001)
    parser.add_argument("--block", type=int, default=150)
    parser.add_argument("--picture", type=Path)
    given = parser.parse_args()
    project = load_project(resource_dir("examples") / "two_stage" / "servogen.toml")
    pattern = np.asarray(timed_path(project).points)
    reach = given.stroke - given.margin
    best = pattern_motion(pattern, given.stroke, given.margin)
    for axis in range(2):
        lower, upper = tube_around(pattern[:, axis], given.stroke, given.margin)
        ends = {"start": float(pattern[0, axis]), "end": float(pattern[-1, axis])}
        print(f"axis {axis}: {look_ahead(lower, upper, **ends):,} points ahead settle every one")
    lengths = [float(np.abs(np.diff(each, axis=0)).sum()) for each in (pattern, best)]
    print(f"{len(pattern):,} points, {lengths[0]:.3f} m of pattern, {lengths[1]:.3f} m of motion\n")
    print("| WINDOW | settled | distance | difference | squares | fastest | touching |")
    print("|---|---|---|---|---|---|---|")
    limit = 1.01 * float(np.abs(pattern).max())
    faults = 0
    first: FloatArray | None = None
    for window in given.windows:
        design = MotionWindowDesign("motion", FLOAT64, window, given.block, reach, limit, 0.03)
        own = declare_motion_window(design)
        with built(emit_package("motion", (own,))) as module:
            axes = [
                streamed(CompiledController(module, own), pattern[:, axis], given.block)
                for axis in range(2)
            ]
        y = np.column_stack([references for references, _ in axes])
        first = y if first is None else first
        room = reach - np.abs(y - pattern)
        settled = sum(count for _, count in axes) / pattern.size
        print(row(window, settled, y, best, room), flush=True)
        longer = float(np.abs(np.diff(y, axis=0)).sum()) - lengths[1]
        faults += bool(room.min() < -4.0 * np.spacing(limit) or longer > 8.0 * reach)
    if given.picture is not None and first is not None:
        name = f"WINDOW = {given.windows[0]:,}"
        draw({"minimal motion": best[:, 0], name: first[:, 0]}, pattern[:, 0], reach, given.picture)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
