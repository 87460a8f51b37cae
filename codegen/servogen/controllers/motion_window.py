"""Minimal motion of a streamed path, step by step; see ``motion_window_design``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servogen.controllers.arithmetic import Scalar, check_port, scalar_type
from servogen.controllers.design import Status, Value
from servogen.controllers.motion_window_design import MotionWindowDesign, declare_motion_window
from servogen.paths.taut_string import heights_along, taut_string


class MotionWindow:
    """Reference of the emitted C, bit for bit.

    Statuses of ``step``: PRIMING until WINDOW points wait, OK, FINISHED with the last references;
    INFEASIBLE where the start is out of the first point's reach, OVERFLOW for points after the end
    of the path; NOT_FINITE, OUT_OF_RANGE, NOT_READY. With one of the last five nothing is taken, no
    reference goes out and the last one is held; the next call with proper inputs goes on from
    there.
    """

    def __init__(self, design: MotionWindowDesign) -> None:
        self.design = design
        self.declaration = declare_motion_window(design)
        self._real = real = scalar_type(design.precision)
        self._reach, self._limit = real(design.reach_m), real(design.limit_m)
        self.ready = False
        self._begin(real(0.0))

    def _begin(self, start: Scalar) -> None:
        self.last = self.newest = start
        self.lower: list[Scalar] = []
        self.upper: list[Scalar] = []
        self.taken, self.over = 0, False

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = inputs or {}
        match operation:
            case "reset":
                return self._reset(given), {}
            case "step":
                return self._step(given)
        raise KeyError(operation)

    def _judge(self, operation: str, given: Mapping[str, Value]) -> Status:
        ports = self.declaration.operation(operation).inputs
        return max(check_port(port, given[port.name], self.design.precision) for port in ports)

    def _reset(self, given: Mapping[str, Value]) -> Status:
        status = self._judge("reset", given)
        self.ready = status is Status.OK
        self._begin(self._real(np.asarray(given["start"]) if self.ready else 0.0))
        return status

    def _step(self, given: Mapping[str, Value]) -> tuple[Status, dict[str, Value]]:
        status = self._judge("step", given) if self.ready else Status.NOT_READY
        references: list[Scalar] = []
        decided = 0
        if status is Status.OK:
            n_points = int(np.asarray(given["n_points"]))
            points = [self._real(w) for w in np.asarray(given["points"])[:n_points]]
            status = self._admits(points)
        if status is Status.OK:
            self._take(points)
            if int(np.asarray(given["ended"])) == 1:
                self._finish()
            references, decided = self._give()
            waiting = len(self.lower)
            if self.over:
                status = Status.FINISHED if waiting == 0 else Status.OK
            elif waiting < self.design.window:
                status = Status.PRIMING
        held = [*references, *[self.last] * (self.design.block - len(references))]
        return status, {
            "reference": np.array(held, dtype=self.design.precision.dtype),
            "n_references": len(references),
            "n_decided": decided,
        }

    def _tube(self, point: Scalar) -> tuple[Scalar, Scalar]:
        """Within the limit, where the string is anyway but for rounding."""
        low, high = point - self._reach, point + self._reach
        low = low if low > -self._limit else -self._limit
        return low, high if high < self._limit else self._limit

    def _admits(self, points: list[Scalar]) -> Status:
        if not points:
            return Status.OK
        if self.over:
            return Status.OVERFLOW
        low, high = self._tube(points[0])
        near = self.taken > 0 or bool(low <= self.last <= high)
        return Status.OK if near else Status.INFEASIBLE

    def _take(self, points: list[Scalar]) -> None:
        for point in points:
            low, high = self._tube(point) if self.taken else (self.last, self.last)
            self.lower.append(low)
            self.upper.append(high)
            self.newest, self.taken = point, min(self.taken + 1, 2)

    def _finish(self) -> None:
        """No more points come; the reference of a path's only point stays the start."""
        if not (self.over or self.design.free_end) and self.taken == 2:
            self.lower[-1] = self.upper[-1] = self.newest
        self.over = True

    def _give(self) -> tuple[list[Scalar], int]:
        """The references that are due, and how many of them are settled."""
        waiting = len(self.lower)
        due = waiting if self.over else max(waiting - self.design.window, 0)
        needed = min(due, self.design.block)
        if needed == 0:
            return [], 0
        knots = taut_string(self.lower, self.upper, self.last, needed)
        references = heights_along(knots, self.lower, self.upper, needed, self._real)
        self.last = references[-1]
        settled = knots.places[knots.decided - 1] + 1
        if self.lower[0] >= self.upper[0]:  # as the first point's are
            settled = max(settled, 1)
        del self.lower[:needed], self.upper[:needed]
        return references, needed if self.over else min(settled, needed)
