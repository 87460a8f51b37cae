"""Draws batch.dxf, the bundled example: twelve laser-cut parts, the cuts between, the outline.

Run ``python make_drawing.py [FILE]``; the same bytes come out every time. Units are millimetres,
the machine's origin is the middle of the sheet. The entities follow the tool: each begins where
the one before ends, and straight moves between features are drawn on the layer TRAVERSE.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import ezdxf

Point = tuple[float, float]
Bulged = tuple[float, float, float]

LAYERS = {"TRAVERSE": 8, "HOLES": 1, "CONTOUR": 5, "MARK": 3, "OUTLINE": 7}
COLUMNS_MM = (-240.0, -80.0, 80.0, 240.0)
ROWS_MM = (-225.0, 0.0, 225.0)
TURNS_DEG = (0.0, 20.0, 0.0, 90.0, 35.0, 8.0, -15.0, 180.0, 10.0, -12.0, 90.0, -90.0)
OUTLINE_HALF_MM = 350.0
OUTLINE_CORNER_MM = 60.0
QUARTER = math.tan(math.radians(90.0) / 4.0)  # bulge of a quarter turn, counter-clockwise


class Pen:
    """Draws in a frame that is shifted and turned, and remembers where the tool is."""

    def __init__(self, space: object) -> None:
        self.space = space
        self.place(0.0, 0.0, 0.0)
        self.at: Point | None = None

    def place(self, x: float, y: float, turn_deg: float) -> None:
        """Draw the following in a frame with this origin and direction."""
        self.origin, self.turn_deg = (x, y), turn_deg

    def sheet(self, point: Point) -> Point:
        """Sheet coordinates of a point of the frame, rounded to a picometre's thousandfold."""
        cosine, sine = math.cos(math.radians(self.turn_deg)), math.sin(math.radians(self.turn_deg))
        x = self.origin[0] + cosine * point[0] - sine * point[1]
        y = self.origin[1] + sine * point[0] + cosine * point[1]
        return (round(x, 6), round(y, 6))

    def go(self, to: Point, layer: str = "TRAVERSE") -> None:
        """A straight move; the very first one only says where the tool starts."""
        target = self.sheet(to)
        if self.at is not None and self.at != target:
            self.space.add_line(self.at, target, dxfattribs={"layer": layer})
        self.at = target

    def circle(self, center: Point, radius: float, layer: str) -> None:
        middle = self.sheet(center)
        start = (round(middle[0] + radius, 6), middle[1])
        if self.at is not None:
            self.space.add_line(self.at, start, dxfattribs={"layer": "TRAVERSE"})
        self.space.add_circle(middle, radius, dxfattribs={"layer": layer})
        self.at = start

    def arc(self, center: Point, radius: float, start_deg: float, end_deg: float) -> None:
        """Counter-clockwise arc of a contour, from where the tool is."""
        self.space.add_arc(
            self.sheet(center),
            radius,
            start_deg + self.turn_deg,
            end_deg + self.turn_deg,
            dxfattribs={"layer": "CONTOUR"},
        )
        end = math.radians(end_deg)
        self.at = self.sheet(
            (center[0] + radius * math.cos(end), center[1] + radius * math.sin(end))
        )

    def polyline(self, points: list[Bulged], layer: str, closed: bool = True) -> None:
        self.go(points[0][:2])
        rows = [(*self.sheet((x, y)), round(bulge, 9)) for x, y, bulge in points]
        self.space.add_lwpolyline(rows, format="xyb", close=closed, dxfattribs={"layer": layer})
        self.at = rows[0][:2] if closed else rows[-1][:2]

    def ellipse(self, center: Point, half_length: float, ratio: float) -> None:
        self.go((center[0] + half_length, center[1]))
        middle, tip = self.sheet(center), self.sheet((center[0] + half_length, center[1]))
        axis = (round(tip[0] - middle[0], 6), round(tip[1] - middle[1], 6))
        self.space.add_ellipse(middle, axis, ratio, dxfattribs={"layer": "CONTOUR"})

    def spline(self, control: list[Point]) -> None:
        """A clamped cubic spline whose first and last control points are its ends."""
        self.go(control[0])
        points = [self.sheet(point) for point in control]
        self.space.add_open_spline(points, degree=3, dxfattribs={"layer": "CONTOUR"})
        self.at = points[-1]


def polar(radius: float, angle_deg: float) -> Point:
    angle = math.radians(angle_deg)
    return (radius * math.cos(angle), radius * math.sin(angle))


def arc_bulge(angle_deg: float) -> float:
    return math.tan(math.radians(angle_deg) / 4.0)


def rounded_rectangle(half_x: float, half_y: float, radius: float) -> list[Bulged]:
    """Counter-clockwise from the middle of the lower side."""
    return [
        (0.0, -half_y, 0.0),
        (half_x - radius, -half_y, QUARTER),
        (half_x, -half_y + radius, 0.0),
        (half_x, half_y - radius, QUARTER),
        (half_x - radius, half_y, 0.0),
        (-half_x + radius, half_y, QUARTER),
        (-half_x, half_y - radius, 0.0),
        (-half_x, -half_y + radius, QUARTER),
        (-half_x + radius, -half_y, 0.0),
    ]


def flange(pen: Pen) -> None:
    """Bore, eight bolt holes, four vents, a rim with two flats."""
    pen.circle((0.0, 0.0), 11.0, "CONTOUR")
    for k in range(8):
        pen.circle(polar(23.0, 45.0 * k + 10.0), 3.0, "HOLES")
    for k in range(4):
        middle = 90.0 * k + 45.0
        pen.polyline(vent(15.0, 17.0, middle - 25.0, middle + 25.0), "CONTOUR")
    flat = math.degrees(math.acos(30.0 / 33.0))
    corners = [polar(33.0, angle) for angle in (flat, 180.0 - flat, 180.0 + flat, -flat)]
    side = arc_bulge(180.0 - 2.0 * flat)
    bulges = (side, 0.0, side, 0.0)
    pen.polyline([(*p, b) for p, b in zip(corners, bulges, strict=True)], "CONTOUR")


def vent(inner: float, outer: float, start_deg: float, end_deg: float) -> list[Bulged]:
    """A slot bent around the centre, with round ends."""
    sweep = end_deg - start_deg
    return [
        (*polar(outer, start_deg), arc_bulge(sweep)),
        (*polar(outer, end_deg), 1.0),
        (*polar(inner, end_deg), -arc_bulge(sweep)),
        (*polar(inner, start_deg), 1.0),
    ]


def gear(pen: Pen) -> None:
    """Bore with keyway, five bent slots, eighteen teeth with rounded tips."""
    half_key = math.degrees(math.asin(2.5 / 8.0))
    pen.polyline(
        [
            (*polar(8.0, 90.0 + half_key), arc_bulge(360.0 - 2.0 * half_key)),
            (*polar(8.0, 90.0 - half_key), 0.0),
            (2.5, 10.5, 0.0),
            (-2.5, 10.5, 0.0),
        ],
        "CONTOUR",
    )
    for k in range(5):
        pen.polyline(vent(15.0, 20.0, 72.0 * k + 12.0, 72.0 * k + 52.0), "CONTOUR")
    teeth: list[Bulged] = []
    for k in range(18):
        base = 20.0 * k
        teeth += [
            (*polar(27.0, base), arc_bulge(7.0)),
            (*polar(27.0, base + 7.0), 0.0),
            (*polar(32.0, base + 10.5), 0.35),
            (*polar(32.0, base + 16.5), 0.0),
        ]
    pen.polyline(teeth, "CONTOUR")


def plate(pen: Pen) -> None:
    """Four holes, the mark MNZVW in zigzag strokes over a zigzag rule, a rounded edge."""
    for x, y in ((-38.0, -20.0), (38.0, -20.0), (38.0, 20.0), (-38.0, 20.0)):
        pen.circle((x, y), 3.5, "HOLES")
    letters = {
        "M": [(0, 0), (0, 12), (4, 5), (8, 12), (8, 0)],
        "N": [(0, 0), (0, 12), (8, 0), (8, 12)],
        "Z": [(0, 12), (8, 12), (0, 0), (8, 0)],
        "V": [(0, 12), (4, 0), (8, 12)],
        "W": [(0, 12), (2, 0), (4, 8), (6, 0), (8, 12)],
    }
    for number, letter in enumerate("MNZVW"):
        left = -28.0 + 12.0 * number
        strokes = [(left + x, 0.0 + y, 0.0) for x, y in letters[letter]]
        pen.polyline(strokes, "MARK", closed=False)
    rule = [(28.0 - 3.5 * k, -6.0 if k % 2 else -12.0, 0.0) for k in range(17)]
    pen.polyline(rule, "MARK", closed=False)
    half_x, half_y, radius = 46.0, 28.0, 8.0
    pen.go((-half_x + radius, -half_y))
    for side, (dx, dy) in enumerate(((1, -1), (1, 1), (-1, 1), (-1, -1))):
        corner = (dx * (half_x - radius), dy * (half_y - radius))
        start = -90.0 + 90.0 * side
        along = polar(radius, start)
        pen.go((corner[0] + along[0], corner[1] + along[1]), "CONTOUR")
        pen.arc(corner, radius, start, start + 90.0)


def bracket(pen: Pen) -> None:
    """An elliptic window, a wavy slot, three holes and an obround in a rounded L."""
    pen.ellipse((-20.0, 18.0), 9.0, 0.5)
    wave = [(-8.0, -14.0), (2.0, -8.0), (8.0, -26.0), (16.0, -10.0), (24.0, -24.0), (30.0, -14.0)]
    pen.spline(wave)
    pen.spline([wave[-1], (34.0, -20.0), (28.0, -28.0), (8.0, -30.0), (-14.0, -26.0), wave[0]])
    for x, y in ((-26.0, -24.0), (-26.0, 2.0), (-12.0, 2.0)):
        pen.circle((x, y), 3.0, "HOLES")
    pen.polyline(
        [(-12.0, 28.0, 0.0), (-26.0, 28.0, -1.0), (-26.0, 34.0, 0.0), (-12.0, 34.0, -1.0)],
        "CONTOUR",
    )
    pen.polyline(
        [
            (-36.0, -30.0, QUARTER),
            (-30.0, -36.0, 0.0),
            (36.0, -36.0, QUARTER),
            (42.0, -30.0, 0.0),
            (42.0, -8.0, QUARTER),
            (36.0, -2.0, 0.0),
            (8.0, -2.0, -QUARTER),
            (-2.0, 8.0, 0.0),
            (-2.0, 36.0, QUARTER),
            (-8.0, 42.0, 0.0),
            (-30.0, 42.0, QUARTER),
            (-36.0, 36.0, 0.0),
        ],
        "CONTOUR",
    )


def separate(pen: Pen) -> None:
    """Straight cuts that part the sheet: two between the rows, one between the columns."""
    reach = OUTLINE_HALF_MM - 20.0
    for number, y in enumerate((112.5, -112.5)):
        side = reach if number % 2 == 0 else -reach
        pen.go((-side, y))
        pen.go((side, y), "OUTLINE")
    pen.go((0.0, -reach))
    pen.go((0.0, reach), "OUTLINE")


def draw() -> ezdxf.document.Drawing:
    """The whole sheet: twelve parts on a serpentine, the cuts between them, the outline."""
    document = ezdxf.new("R2000", setup=False, units=4)
    for name, color in LAYERS.items():
        document.layers.add(name, color=color)
    pen = Pen(document.modelspace())
    parts = (flange, gear, plate, bracket)
    for number, turn in enumerate(TURNS_DEG):
        row, step = divmod(number, len(COLUMNS_MM))
        column = step if row % 2 == 0 else len(COLUMNS_MM) - 1 - step
        pen.place(COLUMNS_MM[column], ROWS_MM[row], turn)
        parts[number % len(parts)](pen)
    pen.place(0.0, 0.0, 0.0)
    separate(pen)
    pen.place(0.0, 0.0, 180.0)
    outline = rounded_rectangle(OUTLINE_HALF_MM, OUTLINE_HALF_MM, OUTLINE_CORNER_MM)
    pen.polyline(outline, "OUTLINE")
    return document


def main() -> None:
    target = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("batch.dxf"))
    ezdxf.options.write_fixed_meta_data_for_testing = True
    draw().saveas(target)


if __name__ == "__main__":
    main()
