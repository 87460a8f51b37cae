"""What the benchmark of QP back ends is known not to reach, and why: the page's own list."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Unreached:
    """``at_most``: found, rounded up; a promise that does worse is broken as any other."""

    at_most: float
    why: str


_BOUNDS = (
    "bounds alone: no one stores a row, and the N^2 numbers of ours, a triangle of H^-1 and the "
    "factor's, are half of DAQP's; the vectors beside them weigh most where N is small"
)

# By sequence, and median or maximum of the instructions, or bytes.
UNREACHED = {
    ("servo_drive_10", "bytes"): Unreached(0.56, _BOUNDS),
    ("qpmpc_pendulum_12", "bytes"): Unreached(0.56, _BOUNDS),
}
