"""The controllers of the two-stage machine on a command governor's machine, for comparison.

They know position limits about zero and fast stages with a model: the axes are moved so that their
middle is zero, and the fast stage is a servo loop so many times faster than the slow one as in the
bundled two-stage machine. What is judged is where the fast stage is told to be; here it is there.

They know one reference, r: the tool is there, the stage is driven there, and their admissible set
holds |p - r| within the range. A slow reference c^ apart from the pattern c is nothing they can be
given: the set has no c to hold the stroke to. What implies it can be had, |p - c^| within half the
stroke of a minimal motion with |c^ - c| within the other half, and that is what is run as theirs on
the minimal motion. With the project's reserve as the range, a millimetre, the stage may never lag
by more than that.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from servogen.controllers.design import Status
from servogen.errors import InputError
from servogen.paths.minimal_motion import pattern_motion
from servogen.plants.statespace import StateSpace
from servogen.project.governor_machine import GovernedAxis
from servogen.project.load import Project
from servogen.project.machine import Axis, FastServo, Machine, SlowStateSpace
from servogen.project.schema import Controller, Governor, Target
from servogen.systems import two_stage
from servogen.systems.closed_loop import Run, Stalled
from servogen.systems.command_governor import GovernorMachine
from servogen.systems.command_governor_loop import Excess
from servogen.systems.command_governor_rows import (
    ROUNDING,
    GovernorRow,
    slow_motion,
    stopped_row,
    worst_excess,
)
from servogen.systems.judgement import check_path, check_plants, check_sets

# Of the stroke, that the minimal motion keeps clear for the stage to lag behind it.
LAG_SHARE = 0.5
# As the bundled two-stage machine's fast stages are.
FASTER, DAMPING = 50.0, 0.7


def as_two_stage(machine: GovernorMachine) -> two_stage.Machine:
    """The same machine and drawing, moved to the middle of the axes.

    Raises:
        InputError: what the two-stage machine asks for and this one has not.
    """
    own = machine.project
    axes = [
        _axis(axis, slow) for (_, axis), slow in zip(own.machine.axes, machine.slow, strict=True)
    ]
    tightening = own.controller.governor.steady_state_tightening
    project = Project(
        file=own.file,
        name=own.name,
        system="two_stage",
        machine=Machine(x=axes[0], y=axes[0] if machine.alike else axes[1]),
        sampling=own.sampling,
        controller=Controller(governor=Governor(steady_state_tightening=tightening)),
        path=own.path,
        output=own.output,
        target=Target(name=own.target.name, share=own.target.share),
    )
    plants = check_plants(project)
    sets = check_sets(project, plants)
    timed = replace(machine.timed, points=machine.points - _centre(machine))
    check_path(project, timed, sets)
    return two_stage.Machine(project, plants, sets, timed)


def cascade_row(
    name: str,
    machine: GovernorMachine,
    run_cascade: Callable[[two_stage.Machine, two_stage.Tuning], Run],
    planned: bool,
) -> GovernorRow:
    """The scheduled-path reference governor, with its MPC or alone, on this machine's reference.

    Args:
        run_cascade: runs a design around the plant; whether with the C inside is its affair.
        planned: with the MPC behind the governor.
    """
    try:
        least = machine.project.controller.motion.reference == "minimal_motion"
        moved = as_two_stage(_lagging(machine) if least else machine)
        tuning = two_stage.project_tuning(moved.project)
        run = run_cascade(moved, tuning if planned else replace(tuning, horizon=0))
    except (InputError, Stalled) as error:
        return stopped_row(name, machine, str(error), promised=False)
    return _judged(name, machine, run)


def _judged(name: str, machine: GovernorMachine, run: Run) -> GovernorRow:
    """What holds for the other rows; its limits are kept at the slow samples."""
    centre = _centre(machine)
    fine, slow = run.slow_fine.copy(), run.slow.copy()
    fine[:, :, 0] += centre
    slow[:, :, 0] += centre
    numbers = np.arange(len(machine.points), dtype=np.float64)
    tool = np.stack([np.interp(run.along, numbers, own) for own in machine.points.T], axis=1)
    kept: Excess = worst_excess(machine, slow, tool[:: machine.ratio])
    return GovernorRow(
        name=name,
        time_s=run.time_s,
        ideal_s=machine.ideal_s,
        periods=run.periods,
        complete=run.complete,
        motion=slow_motion(fine, machine.period_s / machine.ratio),
        iterations=(float(np.mean(run.iterations)), int(run.iterations.max(initial=0))),
        backups=int(np.count_nonzero(run.status_axis == Status.BACKUP)),
        infeasible=int(np.count_nonzero(run.status_axis == Status.INFEASIBLE)),
        instants=kept,
        between=worst_excess(machine, fine, tool),
        promised=False,
        tolerance=ROUNDING[machine.precision.name],
    )


def _lagging(machine: GovernorMachine) -> GovernorMachine:
    """The minimal motion as if it were the pattern, within ``LAG_SHARE`` of the stroke."""
    own = machine.project
    strokes = [axis.fast.range_m for _, axis in own.machine.axes]
    x, y = (
        axis.model_copy(update={"fast": axis.fast.model_copy(update={"range_m": LAG_SHARE * s})})
        for (_, axis), s in zip(own.machine.axes, strokes, strict=True)
    )
    kept = [(1.0 - LAG_SHARE) * stroke for stroke in strokes]
    motion = pattern_motion(machine.points, kept, 0.0)
    project = replace(own, machine=own.machine.model_copy(update={"x": x, "y": y}))
    return replace(machine, project=project, timed=replace(machine.timed, points=motion))


def _centre(machine: GovernorMachine) -> np.ndarray:
    return np.array([target.centre_m for target in machine.sets])


def _axis(axis: GovernedAxis, slow: StateSpace) -> Axis:
    low, high = axis.slow.position_limit_m
    return Axis(
        slow=SlowStateSpace(
            model="state_space",
            a=tuple(tuple(row) for row in slow.a.tolist()),
            b=tuple(slow.b.tolist()),
            c=tuple(slow.c.tolist()),
            position_limit_m=0.5 * (high - low),
            velocity_limit_m_per_s=axis.slow.velocity_limit_m_per_s,
            acceleration_limit_m_per_s2=axis.slow.acceleration_limit_m_per_s2,
        ),
        fast=FastServo(
            model="servo",
            bandwidth_rad_per_s=FASTER * slow.bandwidth_3db,
            damping=DAMPING,
            range_m=axis.fast.range_m,
            velocity_limit_m_per_s=axis.fast.velocity_limit_m_per_s,
            acceleration_limit_m_per_s2=axis.fast.acceleration_limit_m_per_s2,
        ),
    )
