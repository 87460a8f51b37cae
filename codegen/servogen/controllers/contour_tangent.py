"""Tangents of a contour that arrives point by point, where it stands, turns and comes back too.

A point of the contour has a direction by which it is reached and one by which it is left: those
from the last and to the next *distinct* point. Points nearer to the last distinct one than a
threshold make none, so a standstill keeps the directions by which it was reached and will be left,
and a motion slower than the precision resolves is seen when it has gone far enough. A point without
the one takes the other. The last point, which nobody knows the next one of, is taken to turn on as
it did at the point before: with the direction that reached it alone the end of the preview would
lag by half a step of every curve.

Where the two agree the tangent lies between them, and a reversal (the same line) changes nothing,
since the weight takes r r'. Where they do not, no single direction is harmless: with c the cosine
between them, r is shortened to phi = c^2 (2 - c^2). It falls off by the fourth power of a small
angle, so that curvature costs nothing, and is zero at a right angle: a corner is a point to be
hit from all sides, W = I. The same holds as long as no direction is known at all. W = I is the
safe side: Q_max, for which the law is time-invariant and stable by (16) itself.

No root is taken: directions are scaled to a largest component of one, and the length that a tangent
ought to have goes to the price of its slide, see ``Slide.price``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.arithmetic import scalar_type
from servogen.precision import FloatArray, Precision

# Rounding two points to the target's precision turns the direction between them by at most a
# sixteenth where they are this many units in the last place of the largest coordinate apart.
UNITS_APART = 32.0


def distinct(precision: Precision, reach: float, resolution: float) -> float:
    """Metres between points, in the coordinate that differs most, from which on there is a
    direction between them: what was asked for, or what the precision can tell."""
    return max(float(resolution), UNITS_APART * float(np.finfo(precision.dtype).eps) * reach)


@dataclass
class Course:
    """Where the contour has been: the last distinct point (p,) and the direction by which it was
    reached, largest component one; zeros where none is known."""

    point: FloatArray
    direction: FloatArray


@dataclass(frozen=True)
class Slide:
    """Along which the references may slide.

    Attributes:
        along: (S, p) t_j, of any length; zeros where no direction is known.
        price: (S,) tau_j (alpha/q + beta/q (1 - phi^2)) for tau_j the squared length of t_j / phi,
            or one: with it the weight is (alpha + beta) I - beta phi^2 t t' / |t|^2.
        middle: (S, p) t_j / phi_j, never shorter than one where a direction is known.
        kept: (S,) phi_j.
        known: number of points j = 1..N with a direction.
    """

    along: FloatArray
    price: FloatArray
    middle: FloatArray
    kept: FloatArray
    known: int


class TangentSweep:
    """Forward over the points for the directions they are reached by, and back for the others."""

    def __init__(
        self, axes: int, count: int, price: tuple[float, float], apart: float, p: Precision
    ) -> None:
        """``price``: alpha/q and beta/q, each as it is: their difference from one loses the small
        one's digits."""
        self._axes, self._count = axes, count
        real = scalar_type(p)
        self._least, self._share = real(price[0]), real(price[1])
        self._apart, self._dtype = real(apart), p.dtype
        self._zero, self._one, self._two = real(0.0), real(1.0), real(2.0)
        self._most, self._remainder = real(0.75), real(0.25)

    def __call__(self, points: FloatArray, course: Course) -> tuple[Slide, Course]:
        """Of points (N + 1, p), the present one first; the course then is that up to it."""
        reached, fresh, after = self._forward(points, course)
        middle = np.zeros((self._count, self._axes), dtype=self._dtype)
        kept = np.zeros(self._count, dtype=self._dtype)
        price = np.ones(self._count, dtype=self._dtype)
        left = self._beyond(reached) if fresh[-1] else np.zeros_like(course.point)
        known = 0
        for j in range(len(points) - 1, 0, -1):
            before = reached[j] if self._square(reached[j]) > self._zero else left
            behind = left if self._square(left) > self._zero else before
            found = self._square(before) > self._zero
            known += int(found)
            if found and j <= self._count:
                middle[j - 1], turned = self._between(before, behind)
                kept[j - 1] = self._rest(turned * turned)
                price[j - 1] = self._price(middle[j - 1], turned * turned, kept[j - 1])
            if fresh[j]:
                left = reached[j]  # of the last point: by which it leaves the one before
        return Slide(middle * kept[:, None], price, middle, kept, known), after

    def _forward(self, points: FloatArray, course: Course) -> tuple[FloatArray, list[bool], Course]:
        reached = np.zeros_like(points)
        point, direction, fresh, after = course.point, course.direction, [], course
        for j, here in enumerate(points):
            way = here - point
            farthest = np.max(np.abs(way))
            fresh.append(bool(farthest > self._apart))
            if fresh[j]:
                direction, point = way * (self._one / farthest), here.copy()
            reached[j] = direction
            if j == 0:
                after = Course(point, direction)
        return reached, fresh, after

    def _beyond(self, reached: FloatArray) -> FloatArray:
        """The direction before the last one, mirrored at the last; zeros where it is not known."""
        last, before = reached[-1], reached[-2]
        share = (self._two * self._dot(last, before)) / self._square(last)
        beyond: FloatArray = last * share - before
        return beyond

    def _between(self, before: FloatArray, behind: FloatArray) -> tuple[FloatArray, np.floating]:
        """t / phi, and 1 - c^2: its square is 1 - phi."""
        cosine = self._dot(before, behind)
        squared = (cosine * cosine) / (self._square(before) * self._square(behind))
        middle = before + behind if cosine >= self._zero else before - behind
        return middle, self._rest(squared)

    def _price(self, middle: FloatArray, lost: np.floating, phi: np.floating) -> np.floating:
        """With 1 - phi^2 = (1 - phi) (1 + phi): next to one, 1 - beta/q phi^2 would be rounding."""
        dear = self._least + (self._share * lost) * (self._one + phi)
        price: np.floating = self._square(middle) * dear
        return price

    def _rest(self, share: np.floating) -> np.floating:
        """1 - share, in two steps that are right on every target: in one, the double subtraction of
        libgcc for ARM rounds 1 - x the wrong way for some x next to 2^-33."""
        rest: np.floating = (self._most - share) + self._remainder
        return rest

    def _square(self, x: FloatArray) -> np.floating:
        return self._dot(x, x)

    def _dot(self, x: FloatArray, y: FloatArray) -> np.floating:
        total: np.floating = x[0] * y[0]
        for i in range(1, self._axes):
            total = total + x[i] * y[i]
        return total
