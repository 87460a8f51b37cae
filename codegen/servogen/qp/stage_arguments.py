"""What the rows of a plant are made of: every fault is one sentence."""

from __future__ import annotations

import numpy as np

from servogen.precision import FloatArray
from servogen.qp.arguments import matrix, whole
from servogen.qp.errors import ProgramError

# Of a horizon: beyond it the tables are no microcontroller's.
MOST_STEPS = 10_000


def stage_arguments(
    stage: object, terminal: object, steps: object, limited: object, dtype: object, inputs: int,
    outer: object, bounds: object,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, np.dtype[np.floating]]:  # fmt: skip
    """Those of ``stage_rows``: stage, terminal, outer, bounds and the type, all of one plant."""
    real = next(
        (np.dtype(own) for own in ("float32", "float64") if dtype in (own, np.dtype(own))), None
    )
    if real is None:
        raise ProgramError("dtype", repr(dtype), "float32 or float64")
    whole("steps", steps, 1, MOST_STEPS)
    ahead = matrix("stage", stage)
    whole("inputs", inputs, 1, ahead.shape[1] - 1)
    n = ahead.shape[1] - inputs
    if ahead.shape[0] < n:
        said = f"of shape {ahead.shape}"
        raise ProgramError("stage", said, f"a row for each of its {n} states: {inputs} inputs")
    whole("limited", limited, 0, n)
    last = matrix("terminal", terminal, empty=True)
    if last.shape[1] != n:
        raise ProgramError("terminal", f"of {last.shape[1]} columns", f"{n}, the states")
    after = np.zeros((0, n + inputs)) if outer is None else matrix("outer", outer, empty=True)
    if after.shape[1] != n + inputs:
        raise ProgramError("outer", f"of {after.shape[1]} columns", f"{n + inputs}, as stage")
    if bounds is None:
        return ahead, last, after, np.zeros(0), real
    factors = matrix("bounds", [bounds])[0] if np.size(bounds) else np.zeros(0)  # type: ignore[arg-type]
    if factors.size > inputs:
        raise ProgramError("bounds", f"of {factors.size} inputs", f"at most {inputs} of a step")
    if not np.all(factors):
        i = int(np.flatnonzero(factors == 0.0)[0])
        raise ProgramError(f"bounds[{i}]", "zero", "a factor of an input")
    return ahead, last, after, factors, real
