"""Minimal motion (19)-(20) of a path that is streamed: its design, and its declaration.

The path comes in blocks, on one axis; the reference of a point goes out when WINDOW points after it
are known. Every call pulls a string taut, from the last reference that went out, through the tube
around all points that wait, with a level end, and hands out its beginning.

How far ahead it must see. A reference is settled, whatever comes, once the funnel's apex has passed
it; ``paths.minimal_motion.look_ahead`` says for a path how many points that takes at the most. A
window at least as long gives the motion of the whole path; ``n_decided`` tells how many of the
references that go out no further point could have changed.

What a shorter window keeps. The tube, always: the string begins inside and ends level inside, and
the next point has no bound to keep but its own. And the least distance of (20): from a point x the
least that is left to cover is a constant and the distance of x from an interval, which only
shrinks, each within the last, as more of the path is known; so what a window asks for is on the way
to what the whole path asks for. An end that is fixed and not in sight costs at most the width of
the tube twice: once for where the motion was led, once for the way back.

What it loses is what makes the taut string one of many: it stands still until something in sight
asks it to move, closer to the envelope and for longer, and makes up for it in steeper pieces.

One block is one funnel: at most four changes for each of the WINDOW + BLOCK points. That costs the
least a point where blocks are long, and a call has the same worst case as a call that keeps the
funnel of the last one, because in either a whole chain may go at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Operation,
    Port,
    StateField,
)
from servogen.controllers.errors import DesignError
from servogen.controllers.governor_design import ZERO_BEYOND
from servogen.precision import Precision

# A point enters and leaves each of two chains once.
TURNS_PER_POINT = 4
# Places are exact in the scalar type up to here, and turns fit an int32_t.
MOST_POINTS = {"float32": 2**24 - 1, "float64": 2**31 // TURNS_PER_POINT - 1}


@dataclass(frozen=True)
class MotionWindowDesign:
    """Attributes:
        window: points after it that are known when a point's reference goes out.
        block: points taken and references given in a call, at the most.
        reach_m: half width of the tube: the fast stage's stroke less a margin, delta - epsilon.
        limit_m: points, start and references are within this of zero.
        free_end: the motion ends level; if not, on the last point of the path, as the paper's.
        sample_time_s: a step is called once in this time.

    Raises:
        DesignError: no point in the window or in a block, more points than places can tell apart,
            a reach or a limit that is not a positive number.
    """

    prefix: str
    precision: Precision
    window: int
    block: int
    reach_m: float
    limit_m: float
    sample_time_s: float
    free_end: bool = False

    def __post_init__(self) -> None:
        for key in ("window", "block"):
            if getattr(self, key) < 1:
                raise DesignError(key, getattr(self, key), "one point or more")
        if self.room > MOST_POINTS[self.precision.name]:
            expected = f"at most {MOST_POINTS[self.precision.name]} points, the block's included"
            raise DesignError("window", self.room, expected)
        for key in ("reach_m", "limit_m", "sample_time_s"):
            value = getattr(self, key)
            # its square is a number, so that a product of a difference and a place is one
            most = float(np.sqrt(self.precision.max))
            if not 0.0 < value < most:
                raise DesignError(key, value, f"a number above 0 and below {most:g}")

    @property
    def room(self) -> int:
        """Points that can wait."""
        return self.window + self.block


def declare_motion_window(design: MotionWindowDesign) -> Declaration:
    """Names, sizes and ports: ``reset`` with the first reference, then ``step`` with block after
    block, and, with ``ended``, until it says FINISHED."""
    limit, block = design.limit_m, design.block
    return Declaration(
        kind="motion_window",
        prefix=design.prefix,
        summary="Minimal motion (19)-(20) of a streamed path, one axis",
        precision=design.precision,
        sample_time_s=design.sample_time_s,
        dimensions=(
            Dimension("WINDOW", design.window, "points known ahead of a reference"),
            Dimension("BLOCK", block, "points of a call at the most"),
            Dimension("ROOM", design.room, "points that can wait"),
            Dimension("KNOTS", block + 1, "of the string in a block, with its beginning"),
            Dimension("TURNS", TURNS_PER_POINT, "changes of a funnel for each of them at the most"),
        ),
        constants=(
            Constant("reach", design.reach_m, "m: half width of the tube"),
            Constant("limit", limit, "m: path points and references"),
        ),
        tables=(),
        state=(
            StateField("last", "the last reference that went out, m"),
            StateField("newest", "the last point taken, m"),
            StateField("lower", "bounds of the points that wait, m", "ROOM"),
            StateField("upper", "bounds of the points that wait, m", "ROOM"),
            StateField("heights", "workspace: the string at its knots, m", "KNOTS"),
            StateField("places", "workspace: where its knots are", "KNOTS", type="int32_t"),
            StateField("low", "workspace: the funnel's lower chain", "ROOM", type="int32_t"),
            StateField("high", "workspace: the funnel's upper chain", "ROOM", type="int32_t"),
            StateField("count", "points that wait", type="int32_t"),
            StateField("taken", "points taken, 2 if more", type="int32_t"),
            StateField("over", "whether the path has ended", type="int32_t"),
            StateField("ready", "whether reset has been called", type="int32_t"),
        ),
        operations=(
            Operation(
                "reset",
                "A path begins; nothing waits.",
                (Port("start", "m", "reference of its first point", low=-limit, high=limit),),
            ),
            Operation(
                "step",
                "Take the next points, give the references that are due.",
                (
                    Port("points", "m", f"the next points of the path; {ZERO_BEYOND}", size=block,
                         low=-limit, high=limit),
                    Port("n_points", "1", "valid points", integer=True, low=0, high=block),
                    Port("ended", "1", "1: no more points come after these", integer=True, low=0,
                         high=1),
                ),
                (
                    Port("reference", "m", "minimal motion of the oldest points that wait, then "
                         "the last one held", size=block, low=-limit, high=limit),
                    Port("n_references", "1", "so many points are done", integer=True, low=0,
                         high=block),
                    Port("n_decided", "1", "so many of these no further point could have changed",
                         integer=True, low=0, high=block),
                ),
                period_s=design.sample_time_s,
            ),
        ),
        facts={"free_end": design.free_end},
    )  # fmt: skip
