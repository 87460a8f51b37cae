"""A good project of a small machine, as text, and what commands and steps return."""

from __future__ import annotations

from dataclasses import dataclass, field

SMALL_TOML = """\
schema = 1
name = "small"
system = "two_stage"

[machine.x.slow]
model = "servo"
bandwidth_rad_per_s = 45.0
damping = 0.7
position_limit_m = 0.4
velocity_limit_m_per_s = 0.7
acceleration_limit_m_per_s2 = 14.71

[machine.x.fast]
model = "servo"
bandwidth_rad_per_s = 2250.0
damping = 0.7
range_m = 0.035
velocity_limit_m_per_s = 0.6
acceleration_limit_m_per_s2 = 49.05

[sampling]
fast_sample_time_s = 0.001
slow_sample_time_s = 0.03

[controller.mpc]
horizon = 3

[path]
file = "line.dxf"
feed_m_per_s = 0.2

[output]
precision = "float64"
"""


def dxf(*entities: str) -> str:
    """A minimal DXF drawing in millimetres; an entity is "LINE 8 0 10 0.0 ..."."""
    header = "0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70 4 0 ENDSEC"
    body = " ".join(f"0 {entity}" for entity in entities)
    text = f"{header} 0 SECTION 2 ENTITIES {body} 0 ENDSEC 0 EOF"
    return "\n".join(text.split()) + "\n"


def line(x0: float, y0: float, x1: float, y1: float) -> str:
    """A LINE entity, mm."""
    return f"LINE 8 0 10 {x0} 20 {y0} 11 {x1} 21 {y1}"


@dataclass
class Outcome:
    """How a command ended."""

    status: int
    out: str
    err: str


@dataclass
class FakeResult:
    """A step's result with what a test wants in it."""

    passed: bool = True
    told: list[str] = field(default_factory=lambda: ["all well"])
    data: dict[str, object] = field(default_factory=lambda: {"schema": "servogen.fake/1"})

    def lines(self) -> list[str]:
        return self.told

    def to_json(self) -> dict[str, object]:
        return self.data
