"""One DXF entity to segments in metres."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from ezdxf.math import bulge_to_arc

from servogen.errors import InputError
from servogen.paths.curves import EllipticArc, Line, Nurbs, Segment, circular_arc

# What a file must say of an entity; ezdxf would put zeros where it does not.
_REQUIRED = {
    "LINE": ("start", "end"),
    "ARC": ("center", "radius", "start_angle", "end_angle"),
    "CIRCLE": ("center", "radius"),
    "ELLIPSE": ("center", "major_axis"),
    "LWPOLYLINE": (),
    "POLYLINE": (),
    "SPLINE": (),
}
_SUPPORTED = "LINE, ARC, CIRCLE, LWPOLYLINE, POLYLINE, SPLINE, ELLIPSE or INSERT"
# An arc that leaves its chord by less is a line: the centre of a flatter one is too far away
# for its ends to be found again in double precision.
_FLATTEST_SAG_M = 1e-9
_SPLINE_FRAME = 16  # flag of a vertex that only controls the curve a POLYLINE was fitted to


def check_supported(entity: Any, label: str, file: Path) -> None:
    """Raises InputError for an entity that has no place on a tool path."""
    if entity.dxftype() not in (*_REQUIRED, "INSERT"):
        raise InputError(file, label, "not supported", _SUPPORTED)


def entity_segments(entity: Any, scale: float, label: str, file: Path) -> list[Segment]:
    """Segments of an entity whose coordinates are ``scale`` metres each.

    Raises:
        InputError: the entity is incomplete, not flat or without length.
        ezdxf.DXFError, ValueError, ArithmeticError, AttributeError, LookupError: it is broken.
    """
    kind = entity.dxftype()
    for name in _REQUIRED[kind]:
        if not entity.dxf.hasattr(name):
            raise InputError(
                file, label, f"without its {name.replace('_', ' ')}", f"a complete {kind}"
            )
    _require_flat(entity, label, file)
    if kind == "LINE":
        return [Line(_xy(entity.dxf.start, scale), _xy(entity.dxf.end, scale))]
    if kind in ("ARC", "CIRCLE"):
        return [_arc(entity, scale, label, file)]
    if kind == "LWPOLYLINE":
        rows = entity.get_points("xyb")
        return _bulged(rows, bool(entity.closed), scale, _mirror(entity), label, file)
    if kind == "POLYLINE":
        return _polyline(entity, scale, label, file)
    if kind == "ELLIPSE":
        return [_ellipse(entity, scale, label, file)]
    return [_spline(entity, scale, label, file)]


def _xy(vector: Any, scale: float) -> tuple[float, float]:
    return (scale * float(vector.x), scale * float(vector.y))


def _require_flat(entity: Any, label: str, file: Path) -> None:
    extrusion = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    if abs(extrusion[0]) > 1e-9 or abs(extrusion[1]) > 1e-9:
        raise InputError(file, label, "tilted out of the plane", "a plane drawing")
    heights = {0.0}
    match entity.dxftype():
        case "LINE":
            heights = {entity.dxf.start.z, entity.dxf.end.z}
        case "ELLIPSE":
            heights = {0.0, entity.dxf.major_axis.z}
        case "POLYLINE":
            heights = {vertex.dxf.location.z for vertex in entity.vertices}
        case "SPLINE":
            heights = {point[2] for point in (*entity.control_points, *entity.fit_points)}
    if heights and max(heights) - min(heights) > 1e-9:
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


def _polyline(entity: Any, scale: float, label: str, file: Path) -> list[Segment]:
    if not entity.is_2d_polyline and not entity.is_3d_polyline:
        raise InputError(file, label, "a mesh", "a plane polyline")
    rows = [
        (vertex.dxf.location.x, vertex.dxf.location.y, vertex.dxf.get("bulge", 0.0))
        for vertex in entity.vertices
        if not vertex.dxf.flags & _SPLINE_FRAME
    ]
    return _bulged(rows, bool(entity.is_closed), scale, _mirror(entity), label, file)


def _bulged(
    rows: Any, closed: bool, scale: float, mirror: float, label: str, file: Path
) -> list[Segment]:
    """Straight pieces and arcs of a polyline; equal neighbours are passed over."""
    rows = [(float(x), float(y), float(bulge)) for x, y, bulge in rows]
    if len(rows) < 2:
        raise InputError(file, label, f"a polyline of {len(rows)} vertices", "at least 2 vertices")
    pairs = list(pairwise(rows))
    if closed:
        pairs.append((rows[-1], rows[0]))
    segments: list[Segment] = []
    for (x0, y0, bulge), (x1, y1, _) in pairs:
        if (x0, y0) == (x1, y1):
            continue
        start, end = (mirror * scale * x0, scale * y0), (mirror * scale * x1, scale * y1)
        straight = 0.5 * abs(bulge) * math.dist(start, end) < _FLATTEST_SAG_M
        segments.append(Line(start, end) if straight else _bulge_arc(start, end, mirror * bulge))
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
