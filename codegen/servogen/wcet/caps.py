"""A bound, linear in the number of iterations, on a loop whose iterations are not all alike."""

from __future__ import annotations

from collections.abc import Sequence


def affine_bound(turns: Sequence[list[int]]) -> tuple[list[int], list[int]]:
    """Smallest integer slope, and offset, whose line covers the cost of the first l iterations.

    A solver does some work only every p-th iteration. Each class grows by its mean over a
    period, rounded up; what the line then misses goes to the fixed part. If no period shows, or
    only one iteration is given because all are alike, the slope is the costliest iteration.

    Args:
        turns: cost of each iteration, class by class.

    Returns:
        Fixed part and part per iteration, class by class; fixed + l * part is at least the sum
        of the first l iterations for every l up to ``len(turns)``, and for other caps as long as
        the period goes on.
    """
    classes = len(turns[0])
    worst = [max(turn[c] for turn in turns) for c in range(classes)]
    period = _period(turns)
    if period == 0:
        return [0] * classes, worst
    inner = turns[1 : 1 + period]
    slope = [-(-sum(turn[c] for turn in inner) // period) for c in range(classes)]
    fixed = [0] * classes
    sums = [0] * classes
    # A whole period after the first iteration shows the largest excess over the line.
    for number, turn in enumerate(turns[: 1 + period], start=1):
        for c in range(classes):
            sums[c] += turn[c]
            fixed[c] = max(fixed[c], sums[c] - number * slope[c])
    last, expected = turns[-1], inner[(len(turns) - 2) % period]
    if last != expected:  # work done when k + 1 == cap may meet any phase of another cap
        fixed = [f + max(0, n - s) for f, n, s in zip(fixed, last, slope, strict=True)]
    return fixed, slope


def cycle_bound(turns: Sequence[list[int]], cycle: int) -> tuple[list[int], list[int]]:
    """As ``affine_bound``, of turns whose last ``cycle`` ones repeat for ever.

    Returns:
        Fixed part and part per iteration, valid for any number of iterations.
    """
    classes = len(turns[0])
    slope = [-(-sum(turn[c] for turn in turns[-cycle:]) // cycle) for c in range(classes)]
    fixed, sums = [0] * classes, [0] * classes
    for number, turn in enumerate(turns, start=1):
        for c in range(classes):
            sums[c] += turn[c]
            fixed[c] = max(fixed[c], sums[c] - number * slope[c])
    return fixed, slope


def _period(turns: Sequence[list[int]]) -> int:
    """Smallest period of the iterations between the first and the last; 0 if none is seen twice."""
    inner = turns[1:-1]
    for period in range(1, len(inner) // 2 + 1):
        if all(a == b for a, b in zip(inner, inner[period:], strict=False)):
            return period
    return 0
