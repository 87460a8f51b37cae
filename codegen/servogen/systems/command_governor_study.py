"""The comparison on one machine and drawing: who is how fast, how quiet, at what work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.progress import Progress
from servogen.systems import two_stage
from servogen.systems.closed_loop import Run, Stalled
from servogen.systems.command_governor import GovernorMachine, governor_design, on_reference
from servogen.systems.command_governor_cascade import cascade_row
from servogen.systems.command_governor_loop import GovernedRun, Governor, run_governed
from servogen.systems.command_governor_rivals import PathGovernor, low_pass_row
from servogen.systems.command_governor_rows import GovernorRow, judge_governed, stopped_row

REFERENCES = {"minimal_motion": "minimal motion", "pattern": "pattern"}
EXTENDED, PATH, LOW_PASS = "extended governor", "path governor", "low pass"
# Of paper 1, by whether the MPC is behind it.
CASCADES = {"SPRG": False, "SPRG-MPC": True}


@dataclass(frozen=True)
class GovernorStudy:
    """Rows, and the runs of those that have one, by their names."""

    rows: tuple[GovernorRow, ...]
    runs: dict[str, GovernedRun]


def compare_governors(
    machine: GovernorMachine,
    extended: Callable[[GovernorMachine], GovernedRun],
    cascade: Callable[[two_stage.Machine, two_stage.Tuning], Run],
    progress: Progress,
) -> GovernorStudy:
    """Both governors on the minimal motion and on the pattern, then paper 1's, then the low pass.

    Args:
        extended: runs the extended governor on a machine; with what inside is its affair.
        cascade: the same for a design of the two-stage machine.
    """
    design = governor_design(machine)
    rows: list[GovernorRow] = []
    runs: dict[str, GovernedRun] = {}
    with progress.task("Comparing controllers", total=2 * len(REFERENCES) + 3) as task:
        for controller in (EXTENDED, PATH):
            for key, told in REFERENCES.items():
                name, own = f"{controller}, {told}", on_reference(machine, key)
                promised = controller == EXTENDED
                try:
                    runs[name] = extended(own) if promised else _path_governed(own, design)
                    rows.append(judge_governed(name, own, runs[name], promised))
                except Stalled as stalled:
                    rows.append(stopped_row(name, own, str(stalled), promised))
                task.advance()
        for name, planned in CASCADES.items():
            rows.append(cascade_row(name, machine, cascade, planned))
            task.advance()
        rows.append(low_pass_row(machine, LOW_PASS))
        task.advance()
    return GovernorStudy(tuple(rows), runs)


def run_machine(
    machine: GovernorMachine,
    design: CommandGovernorDesign,
    governor: Governor,
    periods: int | None = None,
    advance: Callable[[], None] | None = None,
) -> GovernedRun:
    """A governor along the machine's path and reference.

    Raises:
        Stalled: it stands still.
    """
    return run_governed(
        design, machine.slow, machine.points, machine.reference, governor, periods, advance
    )


def _path_governed(machine: GovernorMachine, design: CommandGovernorDesign) -> GovernedRun:
    return run_machine(machine, design, PathGovernor(machine, design))
