"""Spatial reference governor (14)-(15): how many points of the path the next interval may take.

For a given state the admissible set leaves an interval of references on each axis, so the search
tests two numbers per axis for (14b) and two for each end of the interval for (14c, d).

The paper tests the range against the position at the start of the interval; the position at its
end is tested too (``both_ends``), or the shifted plan of Corollary 1 could leave the fast range.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Table,
)
from servogen.controllers.mpc_design import state_ports
from servogen.plants.statespace import Discrete
from servogen.precision import FloatArray, Precision
from servogen.sets.admissible import AdmissibleSet
from servogen.sets.constraints import AxisLimits

AXES = ("x", "y")


@dataclass(frozen=True)
class AxisSection:
    """O-infinity of one axis, solved for the reference relative to the position.

    |shift p + rows x' + (r - p)| <= bound for x' = (v, a, ...); rows (pairs, n-1), others (pairs,).
    ``ahead`` (n-1,) and ``ahead_reference``: position at the end of the interval, less p.
    """

    rows: FloatArray
    shift: FloatArray
    bound: FloatArray
    ahead: FloatArray
    ahead_reference: float


@dataclass(frozen=True)
class GovernorDesign:
    """Both axes' sections; ``margin`` as a share of every bound; ``points`` M per interval."""

    prefix: str
    precision: Precision
    points: int
    order: int
    both_ends: bool
    margin: float
    sample_time_s: float
    limits: tuple[AxisLimits, AxisLimits]
    sections: tuple[AxisSection, AxisSection]


def axis_section(admissible: AdmissibleSet, plant: Discrete) -> AxisSection:
    """Rows of (13) divided by their coefficient of r.

    Rows without r say nothing about the choice of r: a state that breaks one has already broken a
    limit that no reference can mend.
    """
    h_x, h_r, k = admissible.pairs()
    used = h_r != 0.0
    h_x, h_r, k = h_x[used], h_r[used], k[used]
    return AxisSection(
        rows=h_x[:, 1:] / h_r[:, None],
        shift=(h_x[:, 0] + h_r) / h_r,
        bound=k / np.abs(h_r),
        ahead=plant.a[0, 1:],
        ahead_reference=float(plant.b[0]),
    )


def _axis_tables(axis: str, section: AxisSection) -> tuple[Table, ...]:
    return (
        Table(f"rows_{axis}", section.rows.T, f"{axis}: (13) on (v, a, ...), transposed"),
        Table(f"shift_{axis}", section.shift, f"{axis}: (13) on p"),
        Table(f"bound_{axis}", section.bound, f"{axis}: (13), right-hand side"),
        Table(f"ahead_{axis}", section.ahead, f"{axis}: end position on (v, a, ...)"),
    )


# Of the points beyond n_points: a part is given them as zeros, so that it can check all alike.
ZERO_BEYOND = "in range, as zero is, beyond n_points too"
NOT_READ = "those beyond n_points are not read"


def point_ports(
    points: int, limits: tuple[AxisLimits, AxisLimits], beyond: str = ZERO_BEYOND
) -> tuple[Port, ...]:
    """The next points of the path, one array per axis, and how many are valid; ``beyond`` says
    what is asked of the other elements."""
    ports = [
        Port(
            f"points_{axis}",
            "m",
            f"the next points of the path, {axis}; {beyond}",
            size=points,
            low=-limit.position_m,
            high=limit.position_m,
        )
        for axis, limit in zip(AXES, limits, strict=True)
    ]
    return (*ports, Port("n_points", "1", "valid points", integer=True, low=0, high=points))


def _told(axis: str, limits: AxisLimits) -> Iterator[Port]:
    """What the governor says of an interval: all of it points of the path."""
    for name, what in (
        ("reference", "r of (15b)"),
        ("low", "least coordinate among the points of the interval"),
        ("high", "greatest coordinate among them"),
    ):
        reach = limits.position_m
        yield Port(f"{name}_{axis}", "m", what, low=-reach, high=reach)


def declare_governor(design: GovernorDesign) -> Declaration:
    """Names, sizes, tables and ports of the governor."""
    ranges = zip(AXES, design.limits, design.sections, strict=True)
    constants: list[Constant] = [
        Constant("keep", 1.0 - design.margin, "share of every bound that may be used"),
    ]
    for axis, limit, section in ranges:
        constants += [
            Constant(f"range_{axis}", limit.fast_range_m, f"m: fast stage range, {axis}"),
            Constant(f"limit_{axis}", limit.position_m, f"m: path points, {axis}"),
            Constant(f"ahead_reference_{axis}", section.ahead_reference, "end position on r - p"),
        ]
    state = tuple(
        port
        for axis, limit in zip(AXES, design.limits, strict=True)
        for port in state_ports(f"{axis}_", design.order, limit)
    )
    last = tuple(
        Port(f"last_{a}", "m", "last point taken", low=-lim.position_m, high=lim.position_m)
        for a, lim in zip(AXES, design.limits, strict=True)
    )
    outputs = [
        Port("points_taken", "1", "eta of (14)", integer=True, low=0, high=design.points),
        *(port for a, lim in zip(AXES, design.limits, strict=True) for port in _told(a, lim)),
    ]
    return Declaration(
        kind="governor",
        prefix=design.prefix,
        summary="Spatial reference governor (14)-(15), both axes",
        precision=design.precision,
        sample_time_s=design.sample_time_s,
        dimensions=(
            Dimension("ORDER", design.order, "states of a slow stage"),
            Dimension("POINTS", design.points, "M, points per interval at the most"),
            Dimension("CHOICES", design.points + 1, "eta = 0..M"),
            *(
                Dimension(f"PAIRS_{a.upper()}", s.bound.size, f"row pairs of (13), {a}")
                for a, s in zip(AXES, design.sections, strict=True)
            ),
        ),
        constants=tuple(constants),
        tables=tuple(
            table
            for axis, section in zip(AXES, design.sections, strict=True)
            for table in _axis_tables(axis, section)
        ),
        state=tuple(
            StateField(f"{name}_{axis}", "workspace, no meaning between calls", "CHOICES")
            for axis in AXES
            for name in ("least", "greatest")
        ),
        operations=(
            Operation(
                "step",
                "The most points, at most M, that keep (14b)-(14d); none is always allowed.",
                inputs=(*state, *last, *point_ports(design.points, design.limits)),
                outputs=tuple(outputs),
            ),
        ),
        facts={"both_ends": design.both_ends},
    )
