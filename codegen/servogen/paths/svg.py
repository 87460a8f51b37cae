"""SVG drawings to strokes, in metres, shape by shape in document order.

The origin of the user units is the machine's origin and the y axis is turned round, so that up on
the screen is up on the machine: a point (x, y) of the drawing is (s x, -s y) metres. With a
``viewBox`` and ``width`` and ``height`` in mm, cm, in, pt, pc or px, s follows from them; else a
user unit is a pixel of 1/96 inch. A group's name (``inkscape:label`` or ``id``) is its layer.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from svgpathtools.parser import parse_transform

from servogen.errors import InputError
from servogen.paths.affine import transformed
from servogen.paths.curves import FloatArray, Stroke
from servogen.paths.settings import PathSettings
from servogen.paths.svg_shapes import SHAPES, shape_chains
from servogen.paths.svg_units import METRES_PER_PIXEL, length_in_pixels
from servogen.paths.text import finite_number, read_text

_NAMESPACE = "http://www.w3.org/2000/svg"
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_GROUPS = ("g", "a")
# Elements that draw nothing where they stand.
_SILENT = (
    *("defs", "title", "desc", "metadata", "style", "script", "view", "cursor", "symbol"),
    *("clipPath", "mask", "marker", "pattern", "filter", "linearGradient", "radialGradient"),
)
_SHEET_FAULTS = re.compile(
    r"\b(transform|translate|rotate|scale|d)\s*:|\b(display\s*:\s*none|visibility\s*:\s*hidden)"
)
_DEEPEST = 100
_SUPPORTED = ", ".join((*SHAPES, "g"))
_ASPECT_TOLERANCE = 1e-3


@dataclass(frozen=True)
class _Place:
    """Where in the document a shape stands."""

    matrix: FloatArray
    layers: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Shape:
    kind: str
    element: Element
    label: str
    place: _Place


def read_svg(file: Path, settings: PathSettings) -> list[Stroke]:
    """Strokes of an SVG drawing, one for each shape and each subpath of a path.

    Raises:
        InputError: no SVG, an unknown unit, an element or a property that is not supported, or a
            hidden element; elements are named by kind and id, or number where they have none.
    """
    root = _root(file)
    scale = _metres_per_unit(root, file)
    shapes = list(_shapes(root, _Place(np.diag([scale, -scale, 1.0])), file))
    feeds = _layer_feeds(shapes, file, settings)
    strokes: list[Stroke] = []
    for shape in shapes:
        try:
            chains = shape_chains(shape.kind, shape.element)
        except ValueError as error:
            value, _, expected = str(error).partition("|")
            raise InputError(file, shape.label, value, expected) from error
        named = [feeds[layer] for layer in shape.place.layers if layer in feeds]
        for number, chain in enumerate(chains, start=1):
            label = shape.label if len(chains) == 1 else f"{shape.label}, part {number}"
            segments = tuple(transformed(segment, shape.place.matrix) for segment in chain)
            strokes.append(Stroke(label, segments, named[-1] if named else None))
    return strokes


def _root(file: Path) -> Element:
    text = read_text(file, "an SVG file")
    try:
        root = ElementTree.fromstring(re.sub(r"^\s*<\?xml[^>]*\?>", "", text))
    except ElementTree.ParseError as error:
        reason, line = str(error).split(":")[0], error.position[0]
        raise InputError(file, f"line {line}", f"broken ({reason})", "valid XML") from error
    if _name(root) != "svg":
        raise InputError(file, "drawing", f"a <{root.tag[:40]}>", "an <svg> element at its root")
    return root


def _name(element: Element) -> str | None:
    """The element's name, or None where it is not SVG's."""
    tag = element.tag
    if tag.startswith("{"):
        space, name = tag[1:].split("}", 1)
        return name if space == _NAMESPACE else None
    return tag


def _metres_per_unit(root: Element, file: Path) -> float:
    box = _view_box(root, file)
    scales = []
    for name, side in zip(("width", "height"), box, strict=True):
        text = root.get(name, "auto").strip()
        if text == "auto" or text.endswith("%"):
            continue
        pixels = length_in_pixels(text)
        if pixels is None or not pixels > 0.0:
            expected = "a length above 0 in px, mm, cm, in, pt or pc"
            raise InputError(file, f"svg {name}", f'"{text[:40]}"', expected)
        scales.append(1.0 if side is None else pixels / side)
    if scales and max(scales) - min(scales) > _ASPECT_TOLERANCE * min(scales):
        value = f"stretched ({scales[0]:.6g} along x and {scales[1]:.6g} along y)"
        raise InputError(file, "svg viewBox", value, "the proportions of width and height")
    return METRES_PER_PIXEL * min(scales, default=1.0)


def _view_box(root: Element, file: Path) -> tuple[float | None, float | None]:
    """Width and height of the viewBox in user units, None without one."""
    text = root.get("viewBox")
    if text is None:
        return None, None
    numbers = [finite_number(part) for part in re.split(r"[\s,]+", text.strip())]
    sides = [number for number in numbers[2:] if number is not None and number > 0.0]
    if len(numbers) != 4 or len(sides) != 2 or None in numbers:
        expected = "four numbers, the last two above 0"
        raise InputError(file, "svg viewBox", f'"{text[:40]}"', expected)
    return sides[0], sides[1]


def _shapes(root: Element, place: _Place, file: Path) -> Iterator[_Shape]:
    """All shapes in document order; whatever else would be drawn is refused."""
    counts: dict[str, int] = {}
    stack = [(element, place, 1) for element in reversed(root)]
    _check_drawn_as_is(root, "svg", file)
    while stack:
        element, outer, depth = stack.pop()
        kind = _name(element)
        if kind == "style":
            _check_style_sheet(element, file)
        if kind is None or kind in _SILENT:
            continue
        counts[kind] = counts.get(kind, 0) + 1
        name = element.get("id")
        label = f"{kind} #{name}" if name else f"{kind} {counts[kind]}"
        if kind not in SHAPES and kind not in _GROUPS:
            raise InputError(file, label, "not supported", f"one of {_SUPPORTED}")
        if depth > _DEEPEST:
            raise InputError(file, label, f"{depth} groups deep", f"at most {_DEEPEST}")
        _check_drawn_as_is(element, label, file)
        inner = replace(outer, matrix=outer.matrix @ _matrix(element, label, file))
        if kind in SHAPES:
            yield _Shape(kind, element, label, inner)
            continue
        names = tuple(text for text in (name, element.get(_LABEL)) if text)
        inner = replace(inner, layers=(*outer.layers, *(text.lower() for text in names)))
        stack.extend((child, inner, depth + 1) for child in reversed(element))


def _matrix(element: Element, label: str, file: Path) -> FloatArray:
    text = element.get("transform")
    try:
        matrix: FloatArray = parse_transform(text, strict=True)
    except ValueError as error:
        shown = " ".join((text or "").split())[:60]
        raise InputError(file, label, f'with transform "{shown}"', "a valid transform") from error
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:2, :2])) < 1e-12:
        raise InputError(file, label, "flattened by its transform", "a transform with an inverse")
    return matrix


def _check_drawn_as_is(element: Element, label: str, file: Path) -> None:
    """Refuse what hides an element, or moves it in a way that is not read here."""
    style = dict(part.split(":", 1) for part in element.get("style", "").split(";") if ":" in part)
    properties = {key.strip(): value.strip() for key, value in style.items()}
    for key in ("display", "visibility"):
        value = properties.get(key, element.get(key, ""))
        if value in ("none", "hidden", "collapse"):
            raise InputError(file, label, f"hidden ({key}: {value})", "a visible element or none")
    moves = [key for key in ("transform", "translate", "rotate", "scale", "d") if key in properties]
    if moves:
        value = f"with {moves[0]} in its style"
        raise InputError(file, label, value, "an attribute transform instead")


def _check_style_sheet(element: Element, file: Path) -> None:
    text = "".join(element.itertext())
    found = _SHEET_FAULTS.search(text)
    if found:
        value = f"a sheet that sets {found[1] or found[2]}"
        raise InputError(file, "style", value, "attributes of the elements themselves")


def _layer_feeds(shapes: list[_Shape], file: Path, settings: PathSettings) -> dict[str, float]:
    known = {layer for shape in shapes for layer in shape.place.layers}
    for name in settings.layer_feeds_m_per_s:
        if name.lower() not in known:
            key = f"path.layer_feeds_m_per_s.{name}"
            raise InputError(None, key, None, f"a group of {file.name} with shapes in it")
    return {name.lower(): feed for name, feed in settings.layer_feeds_m_per_s.items()}
