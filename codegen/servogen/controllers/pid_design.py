"""The cascaded PID that the MPC replaces (Figure 12, Table I, (16)), and its declaration.

A proportional position loop asks for a speed, a proportional-integral speed loop for a current,
once a sample; a notch filter then smooths that current at the rate of the current loop. As printed,
the notch has a dc gain of 1.33: the speed loop is that much stiffer than its gain says.
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
from servogen.controllers.wrapping import Wrapping, turn_constants
from servogen.precision import Precision

# Runs after which what a notch remembers has to be gone: five seconds at 20 kHz.
LONGEST_MEMORY = 100_000


@dataclass(frozen=True)
class Notch:
    """(b0 z^2 + b1 z + b2) / (z^2 + a1 z + a2), run in the transposed direct form.

    Raises:
        DesignError: a coefficient that is not finite, or poles not inside the unit circle.
    """

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float

    def __post_init__(self) -> None:
        if not np.all(np.isfinite([self.b0, self.b1, self.b2, self.a1, self.a2])):
            raise DesignError("notch", None, "finite coefficients")
        # Jury's test for two poles
        if not (abs(self.a2) < 1.0 and abs(self.a1) < 1.0 + self.a2):
            raise DesignError("notch", f"unstable (a1 {self.a1}, a2 {self.a2})", "stable poles")

    def most_kept(self) -> tuple[float, float]:
        """What the two memories can hold at the most for inputs of at most one: the sums of their
        impulse responses' magnitudes, and a hundredth for what rounding adds.

        Raises:
            DesignError: poles so near the unit circle that the sums do not end.
        """
        step = np.array([[-self.a1, 1.0], [-self.a2, 0.0]])
        response = np.array([self.b1 - self.a1 * self.b0, self.b2 - self.a2 * self.b0])
        total = np.abs(response)
        for _ in range(LONGEST_MEMORY):
            response = step @ response
            total += np.abs(response)
            if np.all(np.abs(response) <= 1e-12 * total):
                return float(1.01 * total[0]), float(1.01 * total[1])
        raise DesignError("notch", f"slow (a1 {self.a1}, a2 {self.a2})", "poles that decay sooner")

    @property
    def dc_gain(self) -> float:
        """What a constant comes out as."""
        return (self.b0 + self.b1 + self.b2) / (1.0 + self.a1 + self.a2)


@dataclass(frozen=True)
class PidDesign:
    """Attributes:
        position_gain_per_s: speed asked for per position error.
        velocity_gain: current per speed error (mA per deg/s). integral_time_s: of the speed loop.
        notch: or None where there is none.
        sample_time_s: of both outer loops; ``ratio`` runs of the filter in it.
        current_low, current_high: on what the speed loop asks for and on what leaves the filter.
        reach, turn: as for ``ServoMpcDesign``.

    Raises:
        DesignError: gains and times that are not positive, limits that zero is not between, or a
            ratio below one.
    """

    prefix: str
    precision: Precision
    position_gain_per_s: float
    velocity_gain: float
    integral_time_s: float
    notch: Notch | None
    sample_time_s: float
    ratio: int
    current_low: float
    current_high: float
    reach: float
    turn: float

    def __post_init__(self) -> None:
        for key in ("position_gain_per_s", "velocity_gain", "integral_time_s", "sample_time_s",
                    "reach"):  # fmt: skip
            value = getattr(self, key)
            if not (np.isfinite(value) and value > 0.0):
                raise DesignError(key, value, "a positive number")
        low, high = self.current_low, self.current_high
        if not (np.isfinite([low, high]).all() and low <= 0.0 <= high and low < high):
            expected = "finite limits with zero between them or at one of them"
            raise DesignError("current_low", [low, high], expected)
        if self.ratio < 1:
            raise DesignError("ratio", self.ratio, "at least one run of the filter in a sample")
        Wrapping(self.turn, self.reach, self.precision)


def declare_pid(design: PidDesign) -> Declaration:
    """Names, sizes and ports: ``step`` once a sample, ``filter_step`` RATIO times after it."""
    d = design
    low, high, reach = d.current_low, d.current_high, d.reach
    limit = max(-low, high)
    position = Port("position", "deg", "measured now", low=-reach, high=reach)
    reference = Port("reference", "deg", "wanted now", low=-reach, high=reach)
    asked = Port("wanted", "mA", "what the speed loop asks for", low=low, high=high)
    current = Port("current", "mA", "what the drive is given", low=low, high=high)
    notch = d.notch or Notch(1.0, 0.0, 0.0, 0.0, 0.0)
    # a memory that is never used gets room all the same: a bound of zero is none
    kept = [max(limit * most, limit * 1e-6) for most in notch.most_kept()]
    filters = (
        Constant("b0", notch.b0, "notch (16), on the current asked for"),
        Constant("b1", notch.b1, "on the one before"),
        Constant("b2", notch.b2, "on the one before that"),
        Constant("a1", notch.a1, "on the last output, taken off"),
        Constant("a2", notch.a2, "on the one before, taken off"),
        Constant("most_1", kept[0], "mA: the first memory stays within"),
        Constant("most_2", kept[1], "mA: the second"),
    )
    return Declaration(
        kind="servo_pid",
        prefix=d.prefix,
        summary="Cascaded PID of a servo axis with the notch filter of its current loop",
        precision=d.precision,
        sample_time_s=d.sample_time_s,
        dimensions=(Dimension("RATIO", d.ratio, "runs of the filter in a sample"),),
        constants=(
            Constant("position_gain", d.position_gain_per_s, "1/s"),
            Constant("velocity_gain", d.velocity_gain, "mA per deg/s"),
            Constant("integral_gain", d.velocity_gain * d.sample_time_s / d.integral_time_s,
                     "mA per deg/s and sample"),
            Constant("rate", 1.0 / d.sample_time_s, "1/s: samples"),
            Constant("limit_low", low, "mA"),
            Constant("limit_high", high, "mA"),
            *turn_constants(d.turn, "deg"),
            *(filters if d.notch else ()),
        ),
        tables=(),
        state=(
            StateField("last", "last usable measurement, deg"),
            StateField("integral", "of the speed error, mA"),
            StateField("wanted", "current asked for, held between samples, mA"),
            *(
                (
                    StateField("memory_1", "of the notch"),
                    StateField("memory_2", "of the notch"),
                )
                if d.notch
                else ()
            ),
            StateField("ready", "whether reset has been called", type="int32_t"),
        ),
        operations=(
            Operation("reset", "The axis stands at a position, without current.", (position,)),
            Operation("step", "One sample of the position and speed loops.",
                      (position, reference), (asked,), period_s=d.sample_time_s),
            Operation("filter_step", "One run of the filter on the current asked for last.",
                      (), (current,), period_s=d.sample_time_s / d.ratio),
        ),
        facts={"comes_round": bool(d.turn), "has_notch": d.notch is not None},
    )  # fmt: skip
