"""One SVG shape to chains of segments in user units, before any transform.

svgpathtools reads path data. Its own conversions of the other shapes and its transforms of arcs
are not used: they take neither units nor skews, and its arcs come out with a centre that can be
off by 1e-4 of the radius when they are nearly half an ellipse.
"""

from __future__ import annotations

import math
import re
import warnings
from itertools import pairwise
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from svgpathtools import Arc, parse_path
from svgpathtools import Line as SvgLine

from servogen.paths.curves import EllipticArc, Line, Segment, bezier
from servogen.paths.svg_units import length_in_pixels

Chain = list[Segment]
Point = tuple[float, float]

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_PATH_DATA = re.compile(rf"(?:[MmZzLlHhVvCcSsQqTtAa]|{_NUMBER}|[\s,])*")
_POINT_LIST = re.compile(rf"(?:{_NUMBER}|[\s,])*")
# Flatter arcs (pixels) are lines: their centre is too far away for double precision.
_FLATTEST_SAG = 1e-6
SHAPES = ("path", "line", "polyline", "polygon", "rect", "circle", "ellipse")


def shape_chains(kind: str, element: Element) -> list[Chain]:
    """Chains of segments that follow one another; a path may have several.

    Raises:
        ValueError: an attribute is missing or wrong; the text is "... is ...|expected".
    """
    if kind == "path":
        return _path(element.get("d", ""))
    if kind in ("polyline", "polygon"):
        return [_polygon(element.get("points", ""), closed=kind == "polygon")]
    if kind == "line":
        start = (_length(element, "x1"), _length(element, "y1"))
        return [[Line(start, (_length(element, "x2"), _length(element, "y2")))]]
    if kind == "rect":
        return [_rect(element)]
    return [_ellipse(element, kind)]


def _length(element: Element, name: str, default: float = 0.0) -> float:
    text = element.get(name)
    if text is None:
        return default
    value = length_in_pixels(text)
    if value is None:
        raise ValueError(f'with {name}="{text[:40]}"|a length in px, mm, cm, in, pt, pc or none')
    return value


def _size(element: Element, name: str) -> float:
    value = _length(element, name)
    if not value > 0.0:
        raise ValueError(f"with {name} {value:g}|{name} above 0")
    return value


def _rect(element: Element) -> Chain:
    """Clockwise as seen on the screen from the upper left, as the standard draws it."""
    x, y = _length(element, "x"), _length(element, "y")
    width, height = _size(element, "width"), _size(element, "height")
    given = [name for name in ("rx", "ry") if element.get(name, "auto") != "auto"]
    rx = min(_length(element, given[0]) if given else 0.0, 0.5 * width)
    ry = min(_length(element, given[-1]) if given else 0.0, 0.5 * height)
    if rx < 0.0 or ry < 0.0:
        raise ValueError("with a corner radius below 0|rx and ry of 0 or more")
    if rx == 0.0 or ry == 0.0:
        corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
        return [Line(start, end) for start, end in pairwise(corners)]
    chain: Chain = []
    at = (x + rx, y)
    right, left, low, high = x + width - rx, x + rx, y + ry, y + height - ry
    inner = ((right, low), (right, high), (left, high), (left, low))
    for quarter, center in enumerate(inner):
        t0 = 0.5 * math.pi * (quarter - 1)
        arc = EllipticArc(center, (rx, 0.0), (0.0, ry), t0, t0 + 0.5 * math.pi)
        begin, end = (
            (float(px), float(py)) for px, py in arc.sample(np.array([arc.t0, arc.t1]))[0]
        )
        if math.dist(at, begin) > 1e-12 * (width + height):
            chain.append(Line(at, begin))
        chain.append(arc)
        at = end
    return chain


def _ellipse(element: Element, kind: str) -> Chain:
    """From the right, as the standard draws it."""
    center = (_length(element, "cx"), _length(element, "cy"))
    rx, ry = (_size(element, name) for name in (("r", "r") if kind == "circle" else ("rx", "ry")))
    return [EllipticArc(center, (rx, 0.0), (0.0, ry), 0.0, 2.0 * math.pi)]


def _polygon(text: str, *, closed: bool) -> Chain:
    if not _POINT_LIST.fullmatch(text):
        raise ValueError(f'with points "{text[:40]}"|pairs of numbers')
    numbers = [float(number) for number in re.findall(_NUMBER, text)]
    if len(numbers) % 2 or len(numbers) < 4:
        raise ValueError(f"of {len(numbers)} coordinates|pairs of numbers, two at least")
    points = list(zip(numbers[::2], numbers[1::2], strict=True))
    if closed and points[-1] != points[0]:
        points.append(points[0])
    return [Line(start, end) for start, end in pairwise(points) if start != end]


def _path(text: str) -> list[Chain]:
    data = text.strip()
    if not data:
        raise ValueError("without path data|an attribute d")
    if not _PATH_DATA.fullmatch(data):
        odd = re.sub(_PATH_DATA, "", data, count=1)[:20]
        raise ValueError(f'with "{odd}" in its path data|commands and numbers')
    if data[0] not in "Mm":
        raise ValueError(f'with path data that begins with "{data[0]}"|M at its beginning')
    # svgpathtools takes "1.e3" for two numbers.
    data = re.sub(r"(?<=[0-9])\.(?![0-9])", ".0", data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an arc of radius 0 becomes a line, as it should
            segments = list(parse_path(data))
    except AssertionError as error:
        raise ValueError("with an arc that ends at its start|two arcs for an ellipse") from error
    except (ValueError, ArithmeticError, LookupError, TypeError) as error:
        reason = " ".join(str(error).split()).rstrip(".")[:80]
        raise ValueError(f"with broken path data ({reason})|valid path data") from error
    return _chains(segments)


def _chains(segments: list[Any]) -> list[Chain]:
    """svgpathtools' segments, cut where the pen is lifted; those without a length are left out."""
    chains: list[Chain] = []
    at: complex | None = None
    for segment in segments:
        if at is None or segment.start != at:
            chains.append([])
        at = segment.end
        points = segment.apoints()[:1] if isinstance(segment, Arc) else segment.bpoints()
        if isinstance(segment, Arc) or any(point != points[0] for point in points):
            chains[-1].append(_segment(segment))
    return [chain for chain in chains if chain]


def _segment(segment: Any) -> Segment:
    if isinstance(segment, Arc):
        return _arc(segment)
    if isinstance(segment, SvgLine):
        return Line(_point(segment.start), _point(segment.end))
    return bezier(np.array([_point(point) for point in segment.bpoints()]))


def _point(z: complex) -> Point:
    return (float(z.real), float(z.imag))


def _arc(arc: Any) -> Segment:
    """Centre and angles from the end points, where the ellipse is the unit circle."""
    rx, ry = float(arc.radius.real), float(arc.radius.imag)
    turn = complex(math.cos(float(arc.phi)), math.sin(float(arc.phi)))

    def to_circle(z: complex) -> complex:
        turned = z / turn
        return complex(turned.real / rx, turned.imag / ry)

    start, end = to_circle(arc.start), to_circle(arc.end)
    chord = end - start
    if not arc.large_arc and abs(chord) ** 2 * max(rx, ry) < 8.0 * _FLATTEST_SAG:
        return Line(_point(arc.start), _point(arc.end))
    height = math.sqrt(max(1.0 - 0.25 * abs(chord) ** 2, 0.0))
    # The centre of the shorter arc of growing angle is to the left of the chord.
    side = height if arc.large_arc != arc.sweep else -height
    center = 0.5 * (start + end) + 1j * side * chord / abs(chord)
    first, last = (math.atan2((z - center).imag, (z - center).real) for z in (start, end))
    sweep = (last - first if arc.sweep else first - last) % (2.0 * math.pi)
    return EllipticArc(
        _point(turn * complex(rx * center.real, ry * center.imag)),
        _point(rx * turn),
        _point(1j * ry * turn),
        first,
        first + sweep if arc.sweep else first - sweep,
    )
