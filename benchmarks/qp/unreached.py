"""What the benchmark of QP back ends is known not to reach, and why: the page's own list."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Unreached:
    """``at_most``: of a promise that is broken, found and rounded up: one that does worse is broken
    as any other; None where nothing was promised."""

    at_most: float | None
    why: str


_UNITS = (
    "rows of a plant are measured by their limits, and the most violated one enters; in the metric "
    "of H^-1 an input's row is five times as long as a velocity's, so that inputs enter first and "
    "leave again: twice the iterations of column rows, which are measured alike"
)
_MASSES = (
    "half of the largest set's rows or more hold in the median program, and running a plant of 12 "
    "states and 3 inputs over 10 steps saves little of a product with its rows"
)

# By sequence, and median or maximum of the instructions, or bytes.
UNREACHED = {
    ("qpmpc_pendulum_12", "median"): Unreached(
        None,
        "all 12 variables are at their bounds in the median program: the set is kept, and what is "
        "left are products with H^-1 and its factor, in which unit rows have no structure to use",
    ),
    ("double_integrator_30", "maximum"): Unreached(None, _UNITS),
    ("boxes_double_integrator_30", "maximum"): Unreached(None, _UNITS),
    ("masses_10", "median"): Unreached(None, _MASSES),
    ("boxes_masses_10", "median"): Unreached(None, _MASSES),
}
