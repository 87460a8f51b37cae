"""Who tells whom what: the machine and its governor as blocks (paper 4, Figure 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from servogen.reports.governor_data import GovernorReportData
from servogen.reports.numbers import number
from servogen.reports.style import PATH_COLOUR, X_COLOUR, Y_COLOUR, Figure, Trace, line

_WIDTH, _HEIGHT = 22.0, 10.0


@dataclass(frozen=True)
class _Block:
    """A box about (x, y), in the units of the drawing."""

    x: float
    y: float
    colour: str
    lines: tuple[str, ...]


def flow_figure(data: GovernorReportData) -> Figure:
    """Pattern, reference, governor, both stages and the tool."""
    blocks = _blocks(data)
    traces = [_box(block) for block in blocks.values()]
    shape: dict[str, Any] = {
        "xaxis": {"visible": False, "range": [-14, 104], "fixedrange": True},
        "yaxis": {"visible": False, "range": [-8, 42], "fixedrange": True},
        "margin": {"l": 8, "r": 8, "t": 8, "b": 8},
        "showlegend": False,
        "hovermode": False,
        "font": {"size": 12},
        "annotations": [*map(_words, blocks.values()), *_arrows()],
    }
    return Figure(
        "flow",
        "Signal flow",
        f"Once in {number(1e3 * data.machine.period_s)} ms from the state of the slow stages to "
        "their next command and the points of the coming period; the fast stages make up what the "
        "slow ones are away from the point, at every fast sample.",
        traces,
        shape,
        height=380,
    )


def _blocks(data: GovernorReportData) -> dict[str, _Block]:
    machine = data.machine
    governor = machine.project.controller.governor
    least = machine.project.controller.motion.reference == "minimal_motion"
    made = "streamed" if machine.project.controller.motion.streamed_window else "offline"
    sent = ("Minimal motion", f"(19)-(20), {made}") if least else ("Pattern itself", "as reference")
    variables = data.design.axes[0].program.variables
    period = f"every {number(1e3 * machine.period_s)} ms"
    fast = f"every {number(1e6 * machine.period_s / machine.ratio)} µs"
    points = f"{number(len(machine.points))} points"
    return {
        "pattern": _Block(0, 30, PATH_COLOUR, ("Pattern c", points)),
        "motion": _Block(0, 4, PATH_COLOUR, sent),
        "indices": _Block(
            30, 30, X_COLOUR, ("Predicted indices", f"{number(machine.ratio)} a period at most")
        ),
        "governor": _Block(
            30, 4, X_COLOUR,
            (
                "Governor (17)",
                f"n = {governor.horizon}, N = {governor.sub_samples}",
                f"{variables} unknowns an axis",
            ),
        ),
        "slow": _Block(62, 4, Y_COLOUR, ("Slow stages", period)),
        "fast": _Block(62, 30, Y_COLOUR, ("Fast stages", fast)),
        "tool": _Block(92, 17, PATH_COLOUR, ("Tool", "slow + fast")),
    }  # fmt: skip


def _box(block: _Block) -> Trace:
    half_w, half_h = 0.5 * _WIDTH, 0.5 * _HEIGHT
    x = [block.x + s * half_w for s in (-1, 1, 1, -1, -1)]
    y = [block.y + s * half_h for s in (-1, -1, 1, 1, -1)]
    soft = "rgba(128,140,155,0.10)"
    return line(block.lines[0], x, y, block.colour, 1.6, fill="toself", fillcolor=soft)


def _words(block: _Block) -> dict[str, Any]:
    first, *rest = block.lines
    text = "<br>".join([f"<b>{first}</b>", *rest])
    return {"x": block.x, "y": block.y, "text": text, "showarrow": False}


def _arrows() -> list[dict[str, Any]]:
    half_w, half_h = 0.5 * _WIDTH, 0.5 * _HEIGHT
    low, high, middle = 4.0, 30.0, 17.0
    return [
        _arrow((half_w, high), (30 - half_w, high)),
        _arrow((0, high - half_h), (0, low + half_h)),
        _arrow((half_w, low), (30 - half_w, low)),
        _arrow((27, high - half_h), (27, low + half_h)),
        _arrow((33, low + half_h), (33, high - half_h)),
        _arrow((30 + half_w, low), (62 - half_w, low)),
        _arrow((30 + half_w, high), (62 - half_w, high)),
        _arrow((62, low + half_h), (62, high - half_h)),
        _arrow((62 + half_w, high), (92, middle + half_h)),
        _arrow((62 + half_w, low), (92, middle - half_h)),
        _arrow((62, low - half_h - 5), (30, low - half_h - 5), head=False),
        _arrow((62, low - half_h), (62, low - half_h - 5), head=False),
        _arrow((30, low - half_h - 5), (30, low - half_h)),
        _word(15, low + 2.5, "ĉ"),
        _word(26.4, middle, "references,<br>stroke", "right"),
        _word(33.6, middle, "plan", "left"),
        _word(46, low + 2.5, "command"),
        _word(46, high + 4, "points of<br>the period"),
        _word(62.6, middle, "less position", "left"),
        _word(46, low - half_h - 3, "state"),
    ]


def _arrow(
    begin: tuple[float, float], end: tuple[float, float], head: bool = True
) -> dict[str, Any]:
    return {
        "x": end[0], "y": end[1], "ax": begin[0], "ay": begin[1],
        "xref": "x", "yref": "y", "axref": "x", "ayref": "y",
        "showarrow": True, "arrowhead": 2 if head else 0, "arrowsize": 1.1, "arrowwidth": 1.3,
        "arrowcolor": PATH_COLOUR, "text": "",
    }  # fmt: skip


def _word(x: float, y: float, text: str, side: str = "center") -> dict[str, Any]:
    return {"x": x, "y": y, "text": text, "showarrow": False, "xanchor": side}
