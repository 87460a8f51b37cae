"""What is tried on every controller of a command governor's machine, besides its closed loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_design import AxisGovernorDesign, CommandGovernorDesign
from servogen.controllers.design import Reference
from servogen.controllers.motion_window import MotionWindow
from servogen.controllers.motion_window_design import MotionWindowDesign
from servogen.sil.command_governor_calls import (
    axis_governor_calls,
    command_governor_calls,
    waiting_axis_calls,
)
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call
from servogen.sil.motion_calls import motion_window_calls
from servogen.sil.scenarios import Scenario

# A random step of one axis is a program that often has no answer, all iterations of it in Python:
# some 0.1 s with 41 variables. Both together take 0.05 s, and the windows that a list of calls
# holds are of some thousand points, so that all scenarios of a precision are done in a minute.
# Programs of few variables take a fifth of that or less and are tried as often as anything else.
AXIS_SHARE, BOTH_SHARE, FEW_VARIABLES = 4, 2, 12


def governor_suite(
    design: CommandGovernorDesign,
    motions: tuple[MotionWindowDesign, ...],
    seed: int,
    count: int,
) -> Iterator[Scenario]:
    """Edges and random calls for every controller: ``count`` steps of a streamed motion, as many
    of each axis alone and twice as many of both where they have few variables, else a quarter
    and as many. The same seed gives the same scenarios."""
    few = design.axes[0].program.variables <= FEW_VARIABLES
    axis_share, both_share = (1, 1) if few else (AXIS_SHARE, BOTH_SHARE)
    for number, motion in enumerate(motions):
        rng = np.random.default_rng(seed + number)
        yield from _both(_motion(motion), list(motion_window_calls(motion, rng, count)))
    for number, axis in enumerate({axis.prefix: axis for axis in design.axes}.values()):
        rng = np.random.default_rng(seed + 10 + number)
        steps = max(count // axis_share, 1)
        yield from _both(_axis(axis), list(axis_governor_calls(axis, rng, steps)))
        waits = list(waiting_axis_calls(axis, rng))
        yield Scenario(f"{axis.prefix}: at the cap", _axis(axis), waits)
    rng = np.random.default_rng(seed + 20)
    # twice as many: a stage is seldom lost on its way, or at rest before a path it cannot follow
    calls = list(command_governor_calls(design, rng, max(2 * count // both_share, 1)))
    yield from _both(lambda: CommandGovernor(design), calls)


def _both(factory: Callable[[], Reference], calls: list[Call]) -> Iterator[Scenario]:
    declaration = factory().declaration
    yield Scenario(f"{declaration.prefix}: edges", factory, list(edge_calls(declaration)))
    yield Scenario(f"{declaration.prefix}: random", factory, calls)


def _axis(design: AxisGovernorDesign) -> Callable[[], Reference]:
    return lambda: AxisGovernor(design)


def _motion(design: MotionWindowDesign) -> Callable[[], Reference]:
    return lambda: MotionWindow(design)
