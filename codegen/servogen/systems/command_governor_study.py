"""The comparison on one machine and drawing: who is how fast, how quiet, at what work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.progress import Progress, Task
from servogen.systems import two_stage
from servogen.systems.closed_loop import Run, Stalled
from servogen.systems.command_governor import GovernorMachine, governor_design, on_reference
from servogen.systems.command_governor_cascade import cascade_row
from servogen.systems.command_governor_loop import Governor
from servogen.systems.command_governor_rivals import PathGovernor, low_pass_row
from servogen.systems.command_governor_rows import GovernorRow, judge_governed, stopped_row
from servogen.systems.command_governor_sweeps import (
    REFERENCES,
    Inside,
    Setting,
    Sweep,
    Trial,
    run_machine,
    run_setting,
    sweeps,
)

__all__ = ["REFERENCES", "GovernorStudy", "compare_governors", "run_machine"]

EXTENDED, PATH, LOW_PASS = "extended governor", "SPRG", "low pass"
# Of paper 1, by whether the MPC is behind it.
CASCADES = {"two-stage SPRG": False, "two-stage SPRG-MPC": True}
# Cutoffs of the low pass as shares of the project's.
CUTOFFS = (1.0, 0.25)

RunCascade = Callable[[two_stage.Machine, two_stage.Tuning], Run]


@dataclass(frozen=True)
class GovernorStudy:
    """Controllers compared, and what the extended governor's options do.

    Attributes:
        ideal_s: what a machine of one fast stage would take. velocity_bound_s: what the minimal
            motion takes at the greatest velocity where that is slower, without any acceleration.
    """

    rows: tuple[GovernorRow, ...]
    sweeps: tuple[Sweep, ...]
    ideal_s: float
    velocity_bound_s: float


def compare_governors(
    machine: GovernorMachine, inside: Inside, cascade: RunCascade, progress: Progress
) -> GovernorStudy:
    """Both governors on the minimal motion and on the pattern, then paper 1's, then the low pass;
    then the extended governor's options.

    Args:
        inside: gives what runs a design of the extended governor, its reference or its C.
        cascade: runs a design of the two-stage machine.
    """
    asked = sweeps(machine)
    total = 2 * (2 + len(CASCADES)) + len(CUTOFFS) + sum(len(s) for _, _, s in asked)
    with progress.task("Comparing controllers", total=total) as task:
        base = run_setting(Setting(EXTENDED), machine, inside)
        task.advance(2)
        rows = [*base.rows, *_rivals(machine, cascade, task)]
        found = tuple(
            Sweep(title, note, tuple(_trials(settings, machine, base, inside, task)))
            for title, note, settings in asked
        )
    return GovernorStudy(tuple(rows), found, machine.ideal_s, velocity_bound_s(machine))


def _rivals(machine: GovernorMachine, cascade: RunCascade, task: Task) -> list[GovernorRow]:
    rows = []
    design = governor_design(machine)
    for key, told in REFERENCES.items():
        rows.append(_path_row(f"{PATH}, {told}", on_reference(machine, key), design))
        task.advance()
    for name, planned in CASCADES.items():
        for key, told in REFERENCES.items():
            own = on_reference(machine, key)
            rows.append(cascade_row(f"{name}, {told}", own, cascade, planned))
            task.advance()
    cutoff = machine.project.controller.low_pass.cutoff_hz
    for share in CUTOFFS:
        own_hz = share * cutoff
        rows.append(low_pass_row(machine, f"{LOW_PASS}, {own_hz:g} Hz", own_hz))
        task.advance()
    return rows


def _trials(
    settings: tuple[Setting, ...],
    machine: GovernorMachine,
    base: Trial,
    inside: Inside,
    task: Task,
) -> list[Trial]:
    """Those that are the project itself were run already."""
    found = []
    for setting in settings:
        if setting.is_project:
            found.append(replace(base, label=setting.label))
        else:
            found.append(run_setting(setting, machine, inside))
        task.advance()
    return found


def velocity_bound_s(machine: GovernorMachine) -> float:
    """The minimal motion point by point, each T_f or as long as the slower axis needs for it."""
    limits = np.array([target.limits.velocity_m_per_s for target in machine.sets])
    needed = np.max(np.abs(np.diff(machine.motion, axis=0)) / limits, axis=1)
    return float(np.sum(np.maximum(needed, machine.period_s / machine.ratio)))


def _path_row(name: str, own: GovernorMachine, design: CommandGovernorDesign) -> GovernorRow:
    governor: Governor = PathGovernor(own, design)
    try:
        return judge_governed(name, own, run_machine(own, design, governor), promised=False)
    except Stalled as stalled:
        return stopped_row(name, own, str(stalled), promised=False)
