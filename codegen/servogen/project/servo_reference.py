"""The motion that a servo drive's project asks for (``[reference]``)."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from servogen.project.fields import Section
from servogen.project.limits import LEAST

# Of the current loop: five minutes at 62.5 us. More is a wrong unit, and is not kept in memory.
MOST_SAMPLES = 5_000_000

_Start = Annotated[float, Field(ge=-1e6, le=1e6, description="where the axis stands to begin with")]


class SineReference(Section):
    """start + amplitude sin(2 pi f t), from rest."""

    shape: Annotated[Literal["sine"], Field(description="of the reference")]
    start_deg: _Start = 0.0
    amplitude_deg: Annotated[float, Field(ge=LEAST, le=1e6, description="to either side")]
    frequency_hz: Annotated[float, Field(ge=LEAST, le=1e5, description="of the sine")]
    cycles: Annotated[int, Field(ge=1, le=1000, description="the last one is judged")] = 2

    @property
    def lasts_s(self) -> float:
        """Of the motion."""
        return self.cycles / self.frequency_hz

    @property
    def longest_by(self) -> str:
        """The key that makes it last."""
        return "frequency_hz" if self.frequency_hz < 1.0 else "cycles"


class TrapezoidReference(Section):
    """From rest to rest at a trapezoid of speed."""

    shape: Annotated[Literal["trapezoid"], Field(description="of the reference")]
    start_deg: _Start = 0.0
    stroke_deg: Annotated[float, Field(ge=LEAST, le=1e6, description="from start to end")]
    speed_deg_per_s: Annotated[float, Field(ge=LEAST, le=1e6, description="between the ramps")]
    acceleration_deg_per_s2: Annotated[float, Field(ge=LEAST, le=1e9, description="of the ramps")]

    @property
    def reached_deg_per_s(self) -> float:
        """The speed, which a short stroke does not reach."""
        return min(self.speed_deg_per_s, math.sqrt(self.stroke_deg * self.acceleration_deg_per_s2))

    @property
    def lasts_s(self) -> float:
        """Of the motion, from rest to rest."""
        reached = self.reached_deg_per_s
        return self.stroke_deg / reached + reached / self.acceleration_deg_per_s2

    @property
    def longest_by(self) -> str:
        """The key that makes it last."""
        ramps = self.reached_deg_per_s / self.acceleration_deg_per_s2
        slow = self.stroke_deg / self.reached_deg_per_s > 2.0 * ramps
        return "speed_deg_per_s" if slow else "acceleration_deg_per_s2"
