"""Draws figures.svg, the bundled example: five figures in five rows on a plate of 250 mm.

Run ``python make_drawing.py [FILE]``; the same bytes come out every time. Units are millimetres, up
is up. Every figure stays within 20 mm of the middle of its cell; the moves between them are added
when the drawing is read.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

Point = tuple[float, float]
Curve = Callable[[float], Point]

SIDE_MM, CELLS, REACH_MM = 250.0, 5, 20.0
PITCH_MM = SIDE_MM / CELLS
SMALL = 1e-4  # of a turn, for tangents


def polar(radius: float, angle: float) -> Point:
    return (radius * math.cos(angle), radius * math.sin(angle))


def star(points: int) -> list[Point]:
    """Corners on two circles in turn."""
    radii = (REACH_MM, 0.55 * REACH_MM)
    return [polar(radii[i % 2], math.pi * (0.5 + i / points)) for i in range(2 * points)]


def gear(teeth: int) -> list[Point]:
    """Teeth with straight flanks."""
    shape = ((0.0, 0.78), (0.28, 0.78), (0.42, 1.0), (0.72, 1.0), (0.86, 0.78))
    return [
        polar(share * REACH_MM, 2.0 * math.pi * (tooth + along) / teeth)
        for tooth in range(teeth)
        for along, share in shape
    ]


def rose(petals: int) -> Curve:
    """Loops that just miss the middle."""
    return lambda t: polar(REACH_MM * (0.55 + 0.45 * math.cos(petals * t)), t)


def weave(across: int, along: int) -> Curve:
    """Sines of different numbers in x and y."""
    phase = math.pi / (4.0 * across)
    return lambda t: (
        REACH_MM * math.sin(across * t + phase),
        REACH_MM * math.sin(along * t),
    )


def rolled(loops: int) -> Curve:
    """What a point of a rolling wheel draws."""
    inner = REACH_MM / 1.6
    return lambda t: (
        inner * math.cos(t) + 0.6 * inner * math.cos((loops - 1) * t),
        inner * math.sin(t) - 0.6 * inner * math.sin((loops - 1) * t),
    )


def number(value: float) -> str:
    return f"{value:.4f}".rstrip("0").rstrip(".") or "0"


def pair(point: Point) -> str:
    x, y = (0.0 if abs(v) < 5e-5 else v for v in point)
    return f"{number(x)},{number(y)}"


def polygon(corners: list[Point]) -> str:
    return "M" + "L".join(pair(corner) for corner in corners) + "Z"


def smooth(curve: Curve, pieces: int) -> str:
    """A closed curve as cubics with its points and tangents."""
    step = 2.0 * math.pi / pieces
    path = ""
    for i in range(pieces + 1):
        t = i % pieces * step
        here, ahead, behind = curve(t), curve(t + SMALL), curve(t - SMALL)
        arm = [step / 3.0 * (a - b) / (2.0 * SMALL) for a, b in zip(ahead, behind, strict=True)]
        before = (here[0] - arm[0], here[1] - arm[1])
        path += f"M{pair(here)}" if i == 0 else f"{pair(before)} {pair(here)}"
        path += f"C{pair((here[0] + arm[0], here[1] + arm[1]))} " if i < pieces else "Z"
    return path


WOVEN = ((1, 2), (2, 3), (1, 3), (3, 2), (3, 1))
ROWS: tuple[Callable[[int], str], ...] = (
    lambda column: polygon(star(5 + column)),
    lambda column: smooth(rose(2 + column), 16 * (2 + column)),
    lambda column: smooth(weave(*WOVEN[column]), 24 * max(WOVEN[column])),
    lambda column: polygon(gear(8 + 2 * column)),
    lambda column: smooth(rolled(3 + column), 24 * (1 + column)),
)


def draw() -> str:
    side = number(SIDE_MM)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{side}mm" height="{side}mm" '
        f'viewBox="0 -{side} {side} {side}">',
        '<g transform="scale(1 -1)" fill="none" stroke="black" stroke-width="0.1">',
    ]
    for row, figure in enumerate(ROWS):
        for step in range(CELLS):
            column = step if row % 2 == 0 else CELLS - 1 - step
            middle = pair(((column + 0.5) * PITCH_MM, (row + 0.5) * PITCH_MM))
            lines.append(
                f'<path id="r{row}c{column}" transform="translate({middle})" d="{figure(column)}"/>'
            )
    return "\n".join([*lines, "</g>", "</svg>", ""])


def main() -> None:
    target = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("figures.svg"))
    target.write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    main()
