"""The minimal motion as a streaming machine makes it: block after block, while it is machined."""

from __future__ import annotations

import numpy as np

from servogen.controllers.design import Status, Value
from servogen.precision import FloatArray
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor_loop import Governor

_GOES_ON = (Status.OK, Status.PRIMING, Status.FINISHED)


class StreamedReference:
    """Where the slow stages are sent, by the motion controllers of both axes, references or C.

    Each is given the next block of the path whenever more is asked for than is known. Before the
    first period these are as many calls as fill what a plan sees; after that a block is all that a
    period can take, so one call is enough for each.

    Attributes:
        steps: calls of each controller, one entry for every period.
    """

    def __init__(self, motions: tuple[Governor, Governor], points: FloatArray) -> None:
        """Begin ``points`` (J, 2), m, from rest at its first."""
        self._motions, self._points = motions, points
        self._block = motions[0].declaration.operation("step").inputs[0].size
        self._motion = np.empty_like(points)
        self._given, self._known = 0, 0
        self.steps: list[int] = []
        for i, motion in enumerate(motions):
            motion.call("reset", {"start": points[0, i]})

    def __call__(self, first: int, count: int) -> FloatArray:
        """(count, 2) m of the points from ``first`` on.

        Raises:
            Stalled: a controller refuses the path.
        """
        steps = 0
        while self._known < first + count:
            self._next()
            steps += 1
        self.steps.append(steps)
        return self._motion[first : first + count]

    def _next(self) -> None:
        given = self._points[self._given : self._given + self._block]
        self._given += len(given)
        ended = int(self._given == len(self._points))
        made = 0
        for i, motion in enumerate(self._motions):
            block = np.zeros(self._block)
            block[: len(given)] = given[:, i]
            inputs: dict[str, Value] = {"points": block, "n_points": len(given), "ended": ended}
            status, out = motion.call("step", inputs)
            made = int(np.asarray(out["n_references"]))
            if status not in _GOES_ON or ended > made:
                name = motion.declaration.prefix
                raise Stalled(f"{name} says {status.name} at point {self._given - 1}")
            part = np.asarray(out["reference"])[:made]
            self._motion[self._known : self._known + made, i] = part
        self._known += made
