"""The first input from the points ahead and the state: sliding references, summed as in the C."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from servogen.controllers.arithmetic import cast, scalar_type
from servogen.controllers.contour_lq_design import ContourAxis, ContourLqDesign
from servogen.controllers.contour_slide_bounds import slide_bounds
from servogen.controllers.contour_slides import solve_slides
from servogen.controllers.contour_tangent import Course, TangentSweep
from servogen.precision import FloatArray, Precision
from servogen.qp.ordered import dot, matvec


class Law(Protocol):
    """Points (N + 1, p), the course up to the last one, (d_1, ..., d_N, y, xi) of every axis: the
    inputs, the points with a direction, and the course from here."""

    def __call__(
        self, points: FloatArray, course: Course, given: list[FloatArray]
    ) -> tuple[list[np.floating], int, Course]: ...


class AxisLaw:
    """Tables of one axis in the target precision."""

    def __init__(self, axis: ContourAxis, p: Precision) -> None:
        tables = axis.tables
        self._first, self._error = cast(tables.first, p), cast(tables.error.T, p)
        self._slide, self.stiffness = cast(tables.slide, p), cast(tables.stiffness, p)

    def unslid(self, given: FloatArray) -> np.floating:
        """First input under Q_max."""
        return dot(self._first, given)

    def errors(self, given: FloatArray) -> FloatArray:
        """(S,) errors left by that plan, times -beta / q."""
        return matvec(self._error, given)

    def slid(self, along: FloatArray, s: FloatArray) -> np.floating:
        """What the slides add to the first input."""
        return dot(self._slide * along, s)


class SlidingLaw:
    """The exact law, its gains new in every sample."""

    def __init__(self, design: ContourLqDesign) -> None:
        p = design.precision
        self._slides = design.count > 0
        self._axes = tuple(AxisLaw(axis, p) for axis in design.axes)
        real = scalar_type(p)
        bounds = slide_bounds(design)
        self._least_price = real(design.least_price)
        self._stiffest, self._farthest = real(bounds.stiffest), real(bounds.farthest)
        count = design.count or design.preview
        price = (design.least_price, design.share)
        self._sweep = TangentSweep(len(design.axes), count, price, design.apart, p)

    def __call__(
        self, points: FloatArray, course: Course, given: list[FloatArray]
    ) -> tuple[list[np.floating], int, Course]:
        """See ``Law``."""
        slide, course = self._sweep(points, course)
        commands = [axis.unslid(own) for axis, own in zip(self._axes, given, strict=True)]
        if self._slides:
            s = solve_slides(
                [axis.stiffness for axis in self._axes],
                slide.along,
                slide.price,
                [axis.errors(own) for axis, own in zip(self._axes, given, strict=True)],
                self._least_price,
                self._stiffest,
                self._farthest,
            )
            for a, axis in enumerate(self._axes):
                commands[a] = commands[a] + axis.slid(slide.along[:, a], s)
        return commands, slide.known, course
