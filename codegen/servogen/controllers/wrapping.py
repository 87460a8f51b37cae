"""Angles that come round: the shortest signed difference of two positions on a rotary axis."""

from __future__ import annotations

from servogen.controllers.arithmetic import Scalar, scalar_type
from servogen.controllers.design import Constant
from servogen.controllers.errors import DesignError
from servogen.precision import Precision

# A whole number of turns times a whole number of units is exact in float32 below 2^24, so taking
# turns off a difference rounds nothing; both factors stay below 2^12.
LARGEST_COUNT = 4096


def turn_constants(turn: float, unit: str) -> tuple[Constant, ...]:
    """What the C of an axis that comes round needs; nothing for one that does not."""
    if not turn:
        return ()
    return (
        Constant("turn", turn, f"{unit}: one turn"),
        Constant("half_turn", 0.5 * turn, "half of it"),
        Constant("turn_inverse", 1.0 / turn, "1 / turn"),
    )


class Wrapping:
    """Differences modulo ``turn``, in (-turn/2, turn/2]; of exactly half a turn, the positive way.

    Args:
        turn: units of position in one turn (360 degrees), a whole number; 0 where the axis does not
            come round and a difference is what it is.
        reach: largest magnitude of a position.

    Raises:
        DesignError: a turn that is no whole number up to ``LARGEST_COUNT``, or so many turns.
    """

    def __init__(self, turn: float, reach: float, precision: Precision) -> None:
        if turn != int(turn) or not 0 <= turn <= LARGEST_COUNT:
            raise DesignError("turn", turn, f"a whole number from 0 to {LARGEST_COUNT}")
        if turn and 2.0 * reach / turn + 1.0 > LARGEST_COUNT:
            raise DesignError("reach", reach, f"at most {(LARGEST_COUNT - 1) * turn / 2:g}")
        real = scalar_type(precision)
        self._real = real
        self._turn, self._half = real(turn), real(0.5 * turn)
        self._inverse = real(1.0 / turn) if turn else real(0.0)

    @property
    def comes_round(self) -> bool:
        """Whether there are turns to take off."""
        return bool(self._turn > 0)

    def shortest(self, difference: Scalar) -> Scalar:
        """The way from one position to the other, given their plain difference.

        The nearest number of turns may be one off by rounding where half a turn is left over; the
        two comparisons mend that.
        """
        if not self.comes_round:
            return difference
        turns = difference * self._inverse
        nearest = turns + self._real(-0.5 if turns < 0 else 0.5)
        way = difference - self._real(int(nearest)) * self._turn
        if way > self._half:
            way = way - self._turn
        if way <= -self._half:
            way = way + self._turn
        # it is there already: said for the proof, as in sg_shortest
        return min(max(way, -self._half), self._half)
