"""Spatial reference governor (14)-(15): how many points of the path the next interval may take.

For a given state the admissible set leaves an interval of references on each axis, so the search
tests two numbers per axis for (14b) and two for each end of the interval for (14c, d).

The paper tests the range against the position at the start of the interval; the position at its
end is tested too (``both_ends``), or the shifted plan of Corollary 1 could leave the fast range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from servogen.controllers.arithmetic import cast, check_port
from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
    Status,
    Table,
    Value,
)
from servogen.controllers.tracking_mpc import state_ports
from servogen.plants.statespace import Discrete
from servogen.precision import FloatArray, Precision
from servogen.qp.ordered import matvec
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


def point_ports(points: int, limits: tuple[AxisLimits, AxisLimits]) -> tuple[Port, ...]:
    """The next points of the path, one array per axis, and how many are valid."""
    ports = [
        Port(
            f"points_{axis}",
            "m",
            f"the next points of the path, {axis}; those beyond n_points are not read",
            size=points,
            low=-limit.position_m,
            high=limit.position_m,
        )
        for axis, limit in zip(AXES, limits, strict=True)
    ]
    return (*ports, Port("n_points", "1", "valid points", integer=True, low=0, high=points))


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
    outputs = [Port("points_taken", "1", "eta of (14)", integer=True)]
    for axis in AXES:
        outputs += [
            Port(f"reference_{axis}", "m", "r of (15b)"),
            Port(f"low_{axis}", "m", "least coordinate among the points of the interval"),
            Port(f"high_{axis}", "m", "greatest coordinate among them"),
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


class Governor:
    """Reference of the emitted governor, bit for bit."""

    def __init__(self, design: GovernorDesign) -> None:
        self.design = design
        self.declaration = declare_governor(design)
        p = design.precision
        self._real = p.dtype.type
        self._rows = [cast(s.rows.T, p) for s in design.sections]
        self._shift = [cast(s.shift, p) for s in design.sections]
        self._bound = [cast(s.bound, p) for s in design.sections]
        self._ahead = [cast(s.ahead[:, None], p) for s in design.sections]
        self._ahead_r = [p.dtype.type(s.ahead_reference) for s in design.sections]
        self._range = [p.dtype.type(lim.fast_range_m) for lim in design.limits]

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        n = self.design.order
        declared = self.declaration.operation(operation).inputs
        n_points = int(np.asarray(given["n_points"]))
        status = max(self._check(port, given[port.name], n_points) for port in declared)
        dtype = self.design.precision.dtype
        states = [
            np.array([given[port.name] for port in declared[i * n : (i + 1) * n]], dtype=dtype)
            for i in range(2)
        ]
        last = [dtype.type(given[f"last_{axis}"]) for axis in AXES]
        if status is not Status.OK:
            last = [self._bounded(i, value) for i, value in enumerate(last)]
            return status, self._outputs(0, last, last, last)
        points = [np.asarray(given[f"points_{axis}"], dtype=dtype) for axis in AXES]
        return self.step(states, last, points, n_points)

    def _bounded(self, i: int, value: np.floating) -> np.floating:
        """Within the position limit, whatever it is; a NaN becomes the lower limit, as in the C."""
        limit = self._real(self.design.limits[i].position_m)
        bounded: np.floating = min(value if value > -limit else -limit, limit)
        return bounded

    def _check(self, port: Port, value: Value, n_points: int) -> Status:
        if port.size and 0 <= n_points <= port.size:
            value = np.asarray(value)[:n_points]
            if n_points == 0:
                return Status.OK
        return check_port(port, value, self.design.precision)

    @staticmethod
    def _outputs(
        taken: int, reference: list[np.floating], low: list[np.floating], high: list[np.floating]
    ) -> dict[str, Value]:
        outputs: dict[str, Value] = {"points_taken": taken}
        for i, axis in enumerate(AXES):
            outputs[f"reference_{axis}"] = reference[i]
            outputs[f"low_{axis}"] = low[i]
            outputs[f"high_{axis}"] = high[i]
        return outputs

    def step(
        self,
        states: list[FloatArray],
        last: list[np.floating],
        points: list[FloatArray],
        n_points: int,
    ) -> tuple[Status, dict[str, Value]]:
        """States (n,) and points (M,) per axis, absolute; decremental search over eta."""
        paths = [np.append(last[i], points[i][:n_points]).astype(self._real) for i in range(2)]
        low = [np.minimum.accumulate(path) for path in paths]
        high = [np.maximum.accumulate(path) for path in paths]
        keep = self._real(1.0 - self.design.margin)
        allowed = self._allowed(states, paths, low, high, keep)
        taken = int(np.flatnonzero(allowed)[-1]) if np.any(allowed) else 0
        status = Status.OK
        if not np.any(allowed):
            whole = self._real(1.0)
            if not self._allowed(states, paths, low, high, whole)[0]:
                status = Status.INFEASIBLE
        return status, self._outputs(
            taken,
            [path[taken] for path in paths],
            [values[taken] for values in low],
            [values[taken] for values in high],
        )

    def _allowed(
        self,
        states: list[FloatArray],
        paths: list[FloatArray],
        low: list[FloatArray],
        high: list[FloatArray],
        keep: np.floating,
    ) -> np.ndarray:
        """(n_points + 1,) whether each eta keeps (14b)-(14d) on both axes."""
        allowed = np.ones(paths[0].size, dtype=bool)
        for i in range(2):
            origin, rest = states[i][0], states[i][1:]
            centre = matvec(self._rows[i], rest) + self._shift[i] * origin
            bound = self._bound[i] * keep
            least = np.max(-bound - centre)
            greatest = np.min(bound - centre)
            relative = paths[i] - origin
            reach = self._range[i] * keep
            highest, lowest = high[i] - origin, low[i] - origin
            allowed &= (relative >= least) & (relative <= greatest)
            allowed &= (highest <= reach) & (lowest >= -reach)
            if self.design.both_ends:
                ahead = matvec(self._ahead[i], rest)[0] + self._ahead_r[i] * relative
                allowed &= (highest - ahead <= reach) & (lowest - ahead >= -reach)
        return allowed
