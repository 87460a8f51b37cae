"""The law with gains tabulated per direction, in the order of the C; see its design."""

from __future__ import annotations

import numpy as np

from servogen.controllers.arithmetic import cast, scalar_type
from servogen.controllers.contour_lq_design import AngleTable, ContourLqDesign
from servogen.controllers.contour_tangent import Course, TangentSweep
from servogen.precision import FloatArray
from servogen.qp.ordered import dot, matvec


class TabulatedLaw:
    """Of two axes; see ``Law``."""

    def __init__(self, design: ContourLqDesign, table: AngleTable) -> None:
        p = design.precision
        self._real = scalar_type(p)
        self._first = tuple(cast(axis.tables.first, p) for axis in design.axes)
        # (entries + 1, N + n of both axes, p), transposed for one pass over the inputs
        self._gains = cast(np.swapaxes(table.gains, 1, 2), p)
        self._entries, self._at = table.entries, table.at
        self._half = self._real(0.5 * table.entries)
        self._sweep = TangentSweep(2, design.preview, (1.0, 0.0), design.apart, p)

    def __call__(
        self, points: FloatArray, course: Course, given: list[FloatArray]
    ) -> tuple[list[np.floating], int, Course]:
        """See ``Law``."""
        slide, course = self._sweep(points, course)
        commands = [dot(first, own) for first, own in zip(self._first, given, strict=True)]
        if slide.known:
            phi = slide.kept[self._at - 1]
            share = phi * phi
            place, rest = self._place(slide.middle[self._at - 1])
            both = np.concatenate(given)
            low = matvec(self._gains[place], both)
            high = matvec(self._gains[place + 1], both)
            for a in range(2):
                commands[a] = commands[a] + share * (low[a] + rest * (high[a] - low[a]))
        return commands, slide.known, course

    def _place(self, way: FloatArray) -> tuple[int, np.floating]:
        """The entry before this direction, of whatever length, and the share of the way to the
        next."""
        one, zero = self._real(1.0), self._real(0.0)
        c, s = (way[0], way[1]) if way[0] >= zero else (-way[0], -way[1])
        place = (s / (c + abs(s)) + one) * self._half
        entry = min(max(int(place), 0), self._entries - 1)
        return entry, place - self._real(entry)
