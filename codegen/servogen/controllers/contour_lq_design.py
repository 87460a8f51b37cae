"""Receding-horizon LQ contour control of two or three axes: its design; see ``contour_tables``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servogen.controllers.contour_axis import AxisModel, axis_model
from servogen.controllers.contour_conditioning import check_ratio
from servogen.controllers.contour_observer import AxisObserver, axis_observer
from servogen.controllers.contour_tables import AxisTables, axis_tables, slides
from servogen.controllers.contour_tangent import distinct
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.controllers.errors import DesignError
from servogen.plants.statespace import Discrete, FloatArray
from servogen.precision import FLOAT64, Precision

AXES = ("x", "y", "z")
# Hidden states, in shares of the largest that inputs within the limit make: what a filter may make
# of them before it is held, and what is taken from elsewhere.
HIDDEN_BOUND = 2.0


@dataclass(frozen=True)
class AxisData:
    """What the user says of an axis.

    Attributes:
        plant: identified, any order, any coordinates; position in metres.
        input_limit: largest magnitude of its input, in its own unit.
        reach: largest magnitude of a position, m.
        disturbance: standard deviation of what is added to the input, in its unit.
        count: of the encoder, m.
    """

    plant: Discrete
    input_limit: float
    reach: float
    disturbance: float
    count: float


@dataclass(frozen=True)
class ContourAxis:
    """One axis: its model, the tables of its law, its filter."""

    model: AxisModel
    tables: AxisTables
    observer: AxisObserver


@dataclass(frozen=True)
class AngleTable:
    """Gains per direction, see ``contour_table_design``.

    Attributes:
        gains: (entries + 1, p, sum of N + n) of a straight contour less those of Q_max, the first
            ones again at the end. at: point of the preview whose direction counts.
    """

    gains: FloatArray
    at: int

    @property
    def entries(self) -> int:
        """Directions over half a turn."""
        return len(self.gains) - 1

    def gains_at(self, place: float) -> FloatArray:
        """(p, sum of N + n), linear between entries, for a place between -1 and 1."""
        where = (place + 1.0) * 0.5 * self.entries
        entry = min(int(where), self.entries - 1)
        low, high = self.gains[entry], self.gains[entry + 1]
        result: FloatArray = low + (where - entry) * (high - low)
        return result


@dataclass(frozen=True)
class ContourLqDesign:
    """All that the emitted controller is made of.

    Attributes:
        preview: N_p, points ahead of the present one. apart: m, see ``contour_tangent.distinct``.
        table: gains per direction in place of those computed on line.
    """

    prefix: str
    precision: Precision
    sample_time_s: float
    axes: tuple[ContourAxis, ...]
    weights: ContourWeights
    terminal: Terminal
    preview: int
    apart: float
    table: AngleTable | None = None

    @property
    def reach(self) -> float:
        """Largest magnitude of a position of any axis, m."""
        return max(axis.model.reach for axis in self.axes)

    @property
    def hidden(self) -> int:
        """Number of states but the positions, of all axes."""
        return sum(axis.model.hidden for axis in self.axes)

    @property
    def count(self) -> int:
        """S, points whose reference may slide; 0 without a weight on the contour error."""
        return slides(self.terminal, self.preview) if self.weights.contour > 0.0 else 0

    @property
    def share(self) -> float:
        """beta / (alpha + beta)."""
        return self.weights.contour / self.weights.largest

    @property
    def least_price(self) -> float:
        """alpha / (alpha + beta): no pivot is below it in exact arithmetic."""
        return self.weights.tracking / self.weights.largest

    @property
    def names(self) -> tuple[str, ...]:
        """Of the axes."""
        return AXES[: len(self.axes)]


def design_contour_lq(
    prefix: str,
    precision: Precision,
    axes: Sequence[AxisData],
    weights: ContourWeights,
    terminal: Terminal,
    preview: int,
    resolution: float = 0.0,
    on_line: bool = True,
) -> ContourLqDesign:
    """Coordinates, tables and filter of every axis.

    Args:
        resolution: m, distance between points below which they count as the same one; what the
            precision can tell if that is more.
        on_line: whether the target solves for the slides; with gains per angle the design does.

    Raises:
        DesignError: not two or three axes, different sample times, weights that the precision does
            not carry (``contour_conditioning``), and what ``axis_model``,
            ``axis_tables`` and ``axis_observer`` find. ``key`` begins with the axis's name where
            one of them is at fault.
    """
    if not 2 <= len(axes) <= len(AXES):
        raise DesignError("axes", len(axes), "two or three")
    periods = {axis.plant.sample_time_s for axis in axes}
    if len(periods) > 1:
        raise DesignError("sample_time_s", sorted(periods), "one for all axes")
    if not (np.isfinite(resolution) and resolution >= 0.0):
        raise DesignError("resolution", resolution, "zero or a positive number of metres")
    made = []
    for name, data in zip(AXES, axes, strict=False):
        try:
            model = axis_model(data.plant, data.input_limit, data.reach)
            made.append(
                ContourAxis(
                    model,
                    axis_tables(model, weights, terminal, preview),
                    axis_observer(model, data.disturbance, data.count / float(np.sqrt(12.0))),
                )
            )
        except DesignError as error:
            if error.key == "preview":
                raise
            raise DesignError(f"{name}.{error.key}", error.value, error.expected) from error
    if weights.contour > 0.0:
        rounding = max(axis.tables.rounding for axis in made)
        solved = precision if on_line else FLOAT64
        check_ratio(weights, solved, slides(terminal, preview), rounding)
    return ContourLqDesign(
        prefix, precision, axes[0].plant.sample_time_s, tuple(made), weights, terminal, preview,
        distinct(precision, max(axis.reach for axis in axes), resolution),
    )  # fmt: skip
