"""What is asked of everyone, and how a solver is brought to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from qp.counted import Measured

# Violation accepted by everyone: rows are scaled by their limits. Ten times less than what is asked
# of the answers.
TOLERANCE = 1e-9
# Asked of z, by its range over a sequence.
ACCURACY = 1e-8


def reaching(measure: Callable[[float], Measured], asked: tuple[float, ...]) -> Measured:
    """With the first of the tolerances that gives the accuracy; where none does, or the solver
    itself says that it did not solve all, with the last one tried."""
    for tolerance in asked:
        found = measure(tolerance)
        if np.max(found.error) <= ACCURACY or not np.all(found.solved):
            break
    return replace(found, note=f"tolerance {tolerance:g}")
