"""The second form: gains of straight contours, tabulated per direction, for two axes.

For targets that cannot spare the slides' system. One direction stands for all points ahead, that of
a point ``at`` samples on. Stored is by how much the gains differ from those of Q_max; where the
contour turns (phi < 1, see ``contour_tangent``) or has no direction, so much less of it is
taken, as the weight itself does.

The place in the table needs no angle: with the direction (c, s) turned to c >= 0, as r r' allows,
s / (|c| + s) runs from -1 to 1 as the angle does from -90 to 90 degrees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from servogen.controllers.contour_lq_design import AngleTable, ContourLqDesign
from servogen.controllers.contour_recursion import Machine
from servogen.controllers.errors import DesignError
from servogen.plants.statespace import FloatArray, read_only

# Directions between two entries at which the table is held against the gains it stands for.
BETWEEN = 4


def direction_gains(
    design: ContourLqDesign, direction: FloatArray, dtype: type[np.floating] = np.float64
) -> FloatArray:
    """(p, sum of N + n) first inputs per (d_1, ..., d_N, y, xi) of all axes on a straight contour
    along ``direction`` (p,), of length one; all zeros: those of Q_max. The slides are solved for in
    ``dtype``."""
    tables = [axis.tables for axis in design.axes]
    gains = np.asarray(scipy.linalg.block_diag(*(part.first[None, :] for part in tables)))
    if not (design.count and np.any(direction)):
        return gains
    system = sum(
        (part.stiffness * r**2 for part, r in zip(tables, direction, strict=True)),
        np.eye(design.count) * design.least_price,
    )
    errors = np.hstack([part.error * r for part, r in zip(tables, direction, strict=True)])
    slides = np.linalg.solve(system.astype(dtype), errors.astype(dtype)).astype(np.float64)
    moved = [r * (part.slide @ slides) for part, r in zip(tables, direction, strict=True)]
    result: FloatArray = gains + np.array(moved)
    return result


def table_direction(place: float) -> FloatArray:
    """(2,) of length one for a place between -1 and 1."""
    way = np.array([1.0 - abs(place), place])
    result: FloatArray = way / np.linalg.norm(way)
    return result


def tabulate(design: ContourLqDesign, entries: int, at: int) -> ContourLqDesign:
    """The same controller with its gains from a table.

    Args:
        entries: directions over half a turn. at: samples ahead of the point that gives its
            direction, 1..N_p.

    Raises:
        DesignError: not two axes, no weight on the contour error, fewer than four entries, or no
            such point.
    """
    if len(design.axes) != 2:
        raise DesignError("axes", len(design.axes), "two axes for gains tabulated per angle")
    if not design.count:
        raise DesignError("contour_weight", 0.0, "a number above zero for gains per angle")
    if entries < 4:
        raise DesignError("entries", entries, "four directions or more")
    if not 1 <= at <= design.preview:
        raise DesignError("at", at, f"a point of the preview, 1..{design.preview}")
    places = np.linspace(-1.0, 1.0, entries + 1)
    isotropic = direction_gains(design, np.zeros(2))
    gains = np.array([direction_gains(design, table_direction(p)) - isotropic for p in places])
    gains[-1] = gains[0]  # the same line
    return replace(design, table=AngleTable(read_only(gains), at))


@dataclass(frozen=True)
class TableQuality:
    """deviation: largest difference of an interpolated gain, in shares of the largest gain;
    modulus: largest of the closed loop's eigenvalues with interpolated gains, and ``angle_deg`` of
    the contour at which it occurs."""

    deviation: float
    modulus: float
    angle_deg: float


def table_quality(design: ContourLqDesign) -> TableQuality:
    """At the entries and between them.

    Raises:
        DesignError: a design without a table.
    """
    table = design.table
    if table is None:
        raise DesignError("table", None, "a controller with gains per angle")
    machine, isotropic = _machine(design), direction_gains(design, np.zeros(2))
    worst, deviation, angle = 0.0, 0.0, 0.0
    for place in np.linspace(-1.0, 1.0, BETWEEN * table.entries + 1):
        way = table_direction(float(place))
        found = isotropic + table.gains_at(float(place))
        exact = direction_gains(design, way)
        off = np.max(np.abs(found - exact)) / np.max(np.abs(exact))
        deviation = max(deviation, float(off))
        closed = machine.a + machine.b @ state_gains(design, found)
        modulus = float(np.max(np.abs(np.linalg.eigvals(closed))))
        if modulus > worst:
            worst, angle = modulus, float(np.degrees(np.arctan2(way[1], way[0])))
    return TableQuality(deviation, worst, angle)


def state_gains(design: ContourLqDesign, gains: FloatArray) -> FloatArray:
    """(p, n) inputs per (y, xi) of all axes: d_j = y_d - y makes the preview's gains feedback."""
    parts, start = [], 0
    for axis in design.axes:
        own = gains[:, start : start + design.preview + axis.model.order]
        feedback = own[:, design.preview :].copy()
        feedback[:, 0] -= np.sum(own[:, : design.preview], axis=1)
        parts.append(feedback)
        start += own.shape[1]
    return np.hstack(parts)


def _machine(design: ContourLqDesign) -> Machine:
    models = [axis.model for axis in design.axes]
    a = np.asarray(scipy.linalg.block_diag(*(model.a for model in models)))
    b = np.asarray(scipy.linalg.block_diag(*(model.b[:, None] for model in models)))
    c = np.asarray(scipy.linalg.block_diag(*(np.eye(model.order)[:1] for model in models)))
    return Machine(a, b, c)
