"""Table I as a picture: time against smoothness."""

from __future__ import annotations

from collections.abc import Sequence

from servogen.reports.style import PATH_COLOUR, X_COLOUR, Figure, Trace, layout, line
from servogen.systems.study import PAPER, PAPER_IDEAL_S, StudyRow


def study_figure(rows: Sequence[StudyRow]) -> Figure:
    """Completion ratio against the mean acceleration of both axes; the paper's beside ours."""
    ours = [(r.name, _mean(r.performance.mean_acceleration), r.performance.ratio) for r in rows]
    paper = [
        (name, _mean(PAPER[name][2]), PAPER[name][0] / PAPER_IDEAL_S)
        for name, _, _ in ours
        if name in PAPER
    ]
    traces = [
        _points("this machine", ours, X_COLOUR, "circle", "bottom center"),
        _points("paper", paper, PATH_COLOUR, "circle-open", "top center"),
    ]
    theirs = {name: (a, t) for name, a, t in paper}
    for name, a, t in ours:
        if name in theirs:
            pair = ((a, theirs[name][0]), (t, theirs[name][1]))
            traces.append(
                line(name, *pair, PATH_COLOUR, 0.8, showlegend=False, hoverinfo="skip",
                     line={"dash": "dot"})
            )  # fmt: skip
    shape = layout("mean |acceleration| of both axes [m/s²]", ["completion time / ideal [1]"])
    shape["hovermode"] = "closest"
    return Figure(
        "study",
        "Time against smoothness",
        "Left and low is better. Dotted lines lead from our controller to the paper's of the same "
        "name; plant, path and weights of the paper are unpublished.",
        traces,
        shape,
        height=460,
    )


def _mean(pair: tuple[float, float]) -> float:
    return 0.5 * (pair[0] + pair[1])


def _points(
    name: str, points: list[tuple[str, float, float]], colour: str, symbol: str, place: str
) -> Trace:
    return {
        "type": "scatter",
        "mode": "markers+text",
        "name": name,
        "x": [a for _, a, _ in points],
        "y": [t for _, _, t in points],
        "text": [label for label, _, _ in points],
        "textposition": place,
        "textfont": {"size": 11, "color": colour},
        "hovertemplate": "%{text}: %{y:.4f} of the ideal time, %{x:.3f} m/s²",
        "marker": {
            "size": 10,
            "color": colour,
            "symbol": symbol,
            "line": {"width": 2, "color": colour},
        },
    }
