"""DXF drawings to strokes, in metres, entity by entity in drawing order."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
from ezdxf.math import bulge_to_arc

from servogen.errors import InputError
from servogen.paths.curves import EllipticArc, Line, Nurbs, Segment, Stroke, circular_arc
from servogen.paths.settings import PathSettings

# $INSUNITS codes; 0 (unitless, or no header) is taken as millimetres.
_METRES_PER_UNIT = {
    0: 1e-3,
    1: 0.0254,
    2: 0.3048,
    4: 1e-3,
    5: 1e-2,
    6: 1.0,
    8: 0.0254e-6,
    9: 0.0254e-3,
    10: 0.9144,
    13: 1e-6,
    14: 0.1,
}
_SUPPORTED = "LINE, ARC, CIRCLE, LWPOLYLINE, POLYLINE, SPLINE, ELLIPSE or INSERT"


def read_dxf(file: Path, settings: PathSettings) -> list[Stroke]:
    """Strokes of a DXF drawing's model space, blocks exploded.

    Raises:
        InputError: the file is unreadable or corrupt, its unit is unknown, or it holds an entity
            that has no place in a flat tool path; entities are named by type and handle.
    """
    document = _open(file)
    scale = _metres_per_unit(document, file)
    feeds = _layer_feeds(document, file, settings)
    strokes: list[Stroke] = []
    for entity, handle, layer in _flat_entities(document.modelspace(), file):
        label = f"{entity.dxftype()} #{handle}"
        if document.layers.has_entry(layer):
            shown = document.layers.get(layer)
            if shown.is_off() or shown.is_frozen():
                raise InputError(
                    file, label, f"on the hidden layer {layer}", "a visible layer or no entity"
                )
        try:
            segments = _segments(entity, scale, label, file)
        except (ezdxf.DXFError, ValueError, ArithmeticError, AttributeError) as error:
            raise InputError(
                file, label, f"broken ({error})", f"a valid {entity.dxftype()}"
            ) from error
        strokes.append(Stroke(label, tuple(segments), feeds.get(layer.lower())))
    return strokes


def _open(file: Path) -> Any:
    try:
        text = file.read_bytes()
    except OSError as error:
        raise InputError(file, "drawing", "unreadable", f"a DXF file ({error.strerror})") from error
    if not text.strip():
        raise InputError(file, "drawing", "empty", "a DXF file")
    try:
        return ezdxf.readfile(file)
    except Exception as error:  # a broken file can break the parser anywhere
        reason = " ".join(str(error).split()).rstrip(".") or type(error).__name__
        raise InputError(file, "drawing", f"broken ({reason})", "a valid DXF file") from error


def _metres_per_unit(document: Any, file: Path) -> float:
    code = document.header.get("$INSUNITS", 0)
    if code not in _METRES_PER_UNIT:
        raise InputError(file, "$INSUNITS", code, "a known unit such as 4 (mm) or 1 (inch)")
    return _METRES_PER_UNIT[code]


def _layer_feeds(document: Any, file: Path, settings: PathSettings) -> dict[str, float]:
    known = {layer.dxf.name.lower() for layer in document.layers}
    known |= {entity.dxf.layer.lower() for entity in document.modelspace()}
    for name in settings.layer_feeds_m_per_s:
        if name.lower() not in known:
            raise InputError(
                None, f"path.layer_feeds_m_per_s.{name}", None, f"a layer of {file.name}"
            )
    return {name.lower(): feed for name, feed in settings.layer_feeds_m_per_s.items()}


def _flat_entities(
    entities: Any, file: Path, handle: str = "", layer: str = "0"
) -> Iterator[tuple[Any, str, str]]:
    """Entities with handle and layer; a block's layer "0" is the layer of its INSERT."""
    for entity in entities:
        own_handle = handle or entity.dxf.handle
        own_layer = layer if handle and entity.dxf.layer == "0" else entity.dxf.layer
        if entity.dxftype() != "INSERT":
            yield entity, own_handle, own_layer
            continue
        if entity.block() is None:
            name = entity.dxf.get("name", "?")
            raise InputError(
                file, f"INSERT #{own_handle}", f"of the missing block {name}", "a defined block"
            )
        copies = entity.multi_insert() if entity.mcount > 1 else [entity]
        for copy in copies:
            yield from _flat_entities(copy.virtual_entities(), file, own_handle, own_layer)


def _segments(entity: Any, scale: float, label: str, file: Path) -> list[Segment]:
    kind = entity.dxftype()
    _require_flat(entity, label, file)
    if kind == "LINE":
        return [Line(_xy(entity.dxf.start, scale), _xy(entity.dxf.end, scale))]
    if kind in ("ARC", "CIRCLE"):
        return [_arc(entity, scale, label, file)]
    if kind == "LWPOLYLINE":
        rows = entity.get_points("xyb")
        return _bulged(rows, bool(entity.closed), scale, _mirror(entity), label, file)
    if kind == "POLYLINE":
        if not entity.is_2d_polyline and not entity.is_3d_polyline:
            raise InputError(file, label, "a mesh", "a plane polyline")
        if any(
            vertex.dxf.location.z != entity.vertices[0].dxf.location.z for vertex in entity.vertices
        ):
            raise InputError(file, label, "not flat", "a plane drawing")
        bulged = [
            (v.dxf.location.x, v.dxf.location.y, v.dxf.get("bulge", 0.0)) for v in entity.vertices
        ]
        return _bulged(bulged, bool(entity.is_closed), scale, _mirror(entity), label, file)
    if kind == "ELLIPSE":
        return [_ellipse(entity, scale, label, file)]
    if kind == "SPLINE":
        return [_spline(entity, scale, label, file)]
    raise InputError(file, label, "not supported", _SUPPORTED)


def _xy(vector: Any, scale: float) -> tuple[float, float]:
    return (scale * float(vector.x), scale * float(vector.y))


def _require_flat(entity: Any, label: str, file: Path) -> None:
    extrusion = entity.dxf.get("extrusion", (0.0, 0.0, 1.0)) if entity.is_alive else (0, 0, 1)
    if abs(extrusion[0]) > 1e-9 or abs(extrusion[1]) > 1e-9:
        raise InputError(file, label, "tilted out of the plane", "a plane drawing")
    if entity.dxftype() == "LINE" and entity.dxf.start.z != entity.dxf.end.z:
        raise InputError(file, label, "not flat", "a plane drawing")


def _mirror(entity: Any) -> float:
    """-1 where the entity's own plane is seen from below, which mirrors its x."""
    return -1.0 if entity.dxf.get("extrusion", (0.0, 0.0, 1.0))[2] < 0.0 else 1.0


def _arc(entity: Any, scale: float, label: str, file: Path) -> EllipticArc:
    center, radius = _xy(entity.dxf.center, scale), scale * float(entity.dxf.radius)
    if not radius > 0.0:
        raise InputError(file, label, f"of radius {entity.dxf.radius:g}", "a radius above 0")
    start, end = 0.0, 2.0 * math.pi
    if entity.dxftype() == "ARC":
        start = math.radians(entity.dxf.start_angle)
        end = start + _sweep(start, math.radians(entity.dxf.end_angle))
    mirror = _mirror(entity)
    return EllipticArc(
        (mirror * center[0], center[1]), (mirror * radius, 0.0), (0.0, radius), start, end
    )


def _sweep(start: float, end: float) -> float:
    """Counter-clockwise angle from start to end in (0, 2 pi]; equal angles are a full turn."""
    sweep = math.fmod(end - start, 2.0 * math.pi)
    return sweep + 2.0 * math.pi if sweep <= 1e-12 else sweep


def _bulged(
    rows: Any, closed: bool, scale: float, mirror: float, label: str, file: Path
) -> list[Segment]:
    """Straight pieces and arcs of a polyline; equal neighbours are passed over."""
    rows = [(float(x), float(y), float(bulge)) for x, y, bulge in rows]
    if len(rows) < 2:
        raise InputError(file, label, f"a polyline of {len(rows)} vertices", "at least 2 vertices")
    pairs = list(zip(rows[:-1], rows[1:], strict=True))
    if closed:
        pairs.append((rows[-1], rows[0]))
    segments: list[Segment] = []
    for (x0, y0, bulge), (x1, y1, _) in pairs:
        if (x0, y0) == (x1, y1):
            continue
        start, end = (mirror * scale * x0, scale * y0), (mirror * scale * x1, scale * y1)
        bulge *= mirror
        segments.append(Line(start, end) if bulge == 0.0 else _bulge_arc(start, end, bulge))
    if not segments:
        raise InputError(file, label, "of length zero", "a line or curve with a length")
    return segments


def _bulge_arc(start: tuple[float, float], end: tuple[float, float], bulge: float) -> EllipticArc:
    """The arc of a bulge (tangent of a quarter of its angle, positive counter-clockwise)."""
    center, _, _, radius = bulge_to_arc(start, end, bulge)
    first = math.atan2(start[1] - center.y, start[0] - center.x)
    return circular_arc((center.x, center.y), radius, first, first + 4.0 * math.atan(bulge))


def _ellipse(entity: Any, scale: float, label: str, file: Path) -> EllipticArc:
    ratio = float(entity.dxf.ratio)
    if not 0.0 < abs(ratio) <= 1.0 + 1e-9:
        raise InputError(file, label, f"of axis ratio {ratio:g}", "a ratio in (0, 1]")
    start = float(entity.dxf.start_param)
    return EllipticArc(
        _xy(entity.dxf.center, scale),
        _xy(entity.dxf.major_axis, scale),
        _xy(entity.minor_axis, scale),
        start,
        start + _sweep(start, float(entity.dxf.end_param)),
    )


def _spline(entity: Any, scale: float, label: str, file: Path) -> Nurbs:
    if len(entity.control_points) == 0 and len(entity.fit_points) < 2:
        raise InputError(file, label, "without points", "control points or fit points")
    curve = entity.construction_tool()
    control = np.array([[point.x, point.y] for point in curve.control_points], dtype=float)
    weights = np.array(curve.weights() or np.ones(len(control)), dtype=float)
    knots = np.array(curve.knots(), dtype=float)
    if not (weights > 0.0).all():
        raise InputError(file, label, "with a weight of 0 or less", "weights above 0")
    if len(knots) != len(control) + curve.degree + 1 or (np.diff(knots) < 0.0).any():
        raise InputError(file, label, "with contradictory knots", "knots that match its points")
    return Nurbs(scale * control, weights, knots, curve.degree)
