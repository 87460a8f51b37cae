"""How figures look: plain plotly dictionaries, one palette, one layout.

The palette stays apart under the common kinds of colour blindness and on light and dark ground;
text and grid take their colours from the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from servogen.precision import FloatArray
from servogen.reports.decimation import keep_extremes

X_COLOUR, Y_COLOUR = "#1f86cc", "#e69f00"
AXIS_COLOURS = {"x": X_COLOUR, "y": Y_COLOUR}
LIMIT_COLOUR = "#e34a33"
PATH_COLOUR = "#8a94a0"
# From the strongest slowing to none: visible on white and on black.
SLOWED_SCALE = [[0.0, "#a50f15"], [0.5, "#ef6548"], [1.0, "#fdcc8a"]]
# Stretches per signal: two samples each at 3000 draws a screen of any width without a loss.
BUCKETS = 3000
SIGNIFICANT = 6

Trace = dict[str, Any]
Layout = dict[str, Any]


@dataclass(frozen=True)
class Figure:
    """One plot: ``name`` makes its id; ``linked``: shares the time axis with the others;
    ``square``: is no higher than a narrow screen is wide, but for its legends."""

    name: str
    title: str
    caption: str
    traces: list[Trace]
    layout: Layout
    linked: bool = False
    height: int = 380
    max_width: str = "none"
    square: bool = False


def plain(values: FloatArray | Sequence[float], digits: int = SIGNIFICANT) -> list[float | None]:
    """Numbers for JSON, to ``digits`` significant digits; what is not finite is a gap."""
    array = np.asarray(values, dtype=np.float64)
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in array.tolist()]


def line(
    name: str,
    x: FloatArray | Sequence[float],
    y: FloatArray | Sequence[float],
    colour: str,
    width: float = 1.4,
    panel: int = 1,
    **more: Any,
) -> Trace:
    """A line in a panel, counted from the top."""
    style = {"color": colour, "width": width} | more.pop("line", {})
    suffix = "" if panel == 1 else str(panel)
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": plain(x, 7),
        "y": plain(y),
        "line": style,
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
        **more,
    }


def signal(
    name: str, time: FloatArray, values: FloatArray, colour: str, panel: int = 1, **more: Any
) -> Trace:
    """A long signal, decimated so that every peak stays."""
    kept = keep_extremes(values, BUCKETS)
    return line(name, time[kept], values[kept], colour, panel=panel, **more)


def limit(
    name: str, span: tuple[float, float], level: float, panel: int = 1, shown: bool = True
) -> Trace:
    """A constant limit, dashed."""
    return line(
        name,
        span,
        (level, level),
        LIMIT_COLOUR,
        panel=panel,
        legendgroup="limit",
        showlegend=shown,
        hoverinfo="skip",
        line={"dash": "dash"},
    )


def limits(
    span: tuple[float, float], level: float, panel: int = 1, shown: bool = True
) -> list[Trace]:
    """Both sides of |value| <= level."""
    return [
        limit("limit", span, level, panel, shown),
        limit("limit", span, -level, panel, shown=False),
    ]


def layout(x_title: str, y_titles: Sequence[str], **more: Any) -> Layout:
    """Panels above each other over one x axis, their y titles from the top."""
    rows = len(y_titles)
    gap = 0.07 if rows > 1 else 0.0
    height = (1.0 - gap * (rows - 1)) / rows
    made: Layout = {
        "margin": {"l": 68, "r": 18, "t": 36, "b": 48},
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "xanchor": "left", "yanchor": "bottom"},
        "hovermode": "x unified" if rows == 1 else "x",
        "font": {"size": 13},
    }
    for row, title in enumerate(y_titles, start=1):
        suffix = "" if row == 1 else str(row)
        top = 1.0 - (row - 1) * (height + gap)
        made[f"yaxis{suffix}"] = {
            "title": {"text": title},
            "domain": [max(top - height, 0.0), top],
            "zeroline": False,
            "anchor": f"x{suffix}",
        }
        axis: dict[str, Any] = {"zeroline": False, "anchor": f"y{suffix}"}
        axis |= {"title": {"text": x_title}} if row == rows else {"showticklabels": False}
        if row > 1:
            axis["matches"] = "x"
        made[f"xaxis{suffix}"] = axis
    return made | more
