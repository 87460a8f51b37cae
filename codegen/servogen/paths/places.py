"""Names for places on a path, for messages."""

from __future__ import annotations

from servogen.paths.timing import TimedPath


def describe_point(timed: TimedPath, index: int) -> str:
    """A point by index, coordinates and entity: "point 7 at (0.1200 m, -0.0310 m), ARC #2F"."""
    place = ", ".join(f"{value:.4f} m" for value in timed.points[index].tolist())
    label = timed.tool_path.labels[int(timed.piece[index])]
    return f"point {index} at ({place}), {label}"
