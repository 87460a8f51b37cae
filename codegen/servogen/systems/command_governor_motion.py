"""Where a command governor's slow stages are sent: the minimal motion of the whole drawing, or of
what the machine itself knows of it when its points are streamed."""

from __future__ import annotations

import numpy as np

from servogen.controllers.design import Declaration
from servogen.controllers.motion_window_design import MotionWindowDesign, declare_motion_window
from servogen.controllers.mpc_design import POSITION_FACTOR
from servogen.paths.minimal_motion import pattern_motion
from servogen.paths.taut_compiled import has_compiler, taut_string_compiled
from servogen.paths.taut_string import heights_along, taut_string
from servogen.precision import FLOAT64, FloatArray, Precision
from servogen.project.governor_load import GovernorProject


def motion_designs(
    project: GovernorProject, precision: Precision
) -> tuple[MotionWindowDesign, ...]:
    """The streamed motion of x and of y, M points in a call at the most; none where the file asks
    for none. Axes that are alike have one each too: both run in every period."""
    motion, ratio = project.controller.motion, project.sampling.ratio
    if not motion.streamed_window:
        return ()
    return tuple(
        MotionWindowDesign(
            prefix=f"{project.name}_motion_{name}",
            precision=precision,
            window=motion.streamed_window,
            block=ratio,
            reach_m=stroke - motion.stroke_reserve_m,
            limit_m=POSITION_FACTOR * max(abs(end) for end in axis.slow.position_limit_m),
            sample_time_s=project.sampling.slow_sample_time_s,
        )
        for (name, axis), stroke in zip(project.machine.axes, _strokes(project), strict=True)
    )


def motion_declarations(project: GovernorProject, precision: Precision) -> tuple[Declaration, ...]:
    """What of it is emitted."""
    return tuple(declare_motion_window(design) for design in motion_designs(project, precision))


def slow_motion_of(project: GovernorProject, points: FloatArray) -> FloatArray:
    """(J, 2) m, (19)-(20) of the pattern (J, 2): as streamed, if asked for, in float64."""
    designs = motion_designs(project, FLOAT64)
    if designs:
        axes = [streamed_motion(points[:, i], design) for i, design in enumerate(designs)]
        return np.stack(axes, axis=1)
    reserve = project.controller.motion.stroke_reserve_m
    return pattern_motion(points, _strokes(project), reserve)


def streamed_motion(points: FloatArray, design: MotionWindowDesign) -> FloatArray:
    """(n,) what the C gives, in float64, for a path (n,) that comes in whole blocks.

    As ``controllers.motion_window`` does it, with the compiled string where there is a compiler:
    the same bits in a fiftieth of the time.
    """
    low = np.maximum(points - design.reach_m, -design.limit_m)
    high = np.minimum(points + design.reach_m, design.limit_m)
    low[0] = high[0] = points[0]
    motion = np.empty_like(points)
    last, done, taken = float(points[0]), 0, 0
    while done < points.size:
        taken = min(taken + design.block, points.size)
        ended = taken == points.size
        if ended:
            low[-1] = high[-1] = points[-1]
        due = taken - done if ended else taken - done - design.window
        needed = min(due, design.block)
        if needed > 0:
            motion[done : done + needed] = _begun(low[done:taken], high[done:taken], last, needed)
            done += needed
            last = float(motion[done - 1])
    return motion


def _begun(low: FloatArray, high: FloatArray, start: float, needed: int) -> FloatArray:
    """The first points of the string (needed,)."""
    if has_compiler():
        whole: FloatArray = taut_string_compiled(low, high, start)[0]
        return whole[:needed]
    lower, upper = low.tolist(), high.tolist()
    knots = taut_string(lower, upper, start, needed)
    return np.array(heights_along(knots, lower, upper, needed))


def _strokes(project: GovernorProject) -> list[float]:
    margin = project.controller.governor.stroke_margin_m
    return [axis.fast.range_m - margin for _, axis in project.machine.axes]
