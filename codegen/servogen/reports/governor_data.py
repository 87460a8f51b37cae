"""What the report of a command governor is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from servogen.controllers.command_governor_declaration import declare_governor_parts
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import design_hash
from servogen.evidence.certificate import Certificate
from servogen.systems.command_governor import GovernorMachine
from servogen.systems.command_governor_loop import GovernedRun
from servogen.systems.command_governor_motion import motion_declarations
from servogen.systems.command_governor_rows import GovernorRow
from servogen.systems.command_governor_study import GovernorStudy


@dataclass(frozen=True)
class GovernorReportData:
    """Everything found about one machine. What is None was not run, and is shown so.

    Attributes:
        machine: the judged project; design: what was emitted.
        run: the closed loop; row: that run, judged; faults: what ``simulate`` found wrong.
        study: the comparison.
        sil, wcet, build, certificate: see ``Found``.
    """

    machine: GovernorMachine
    design: CommandGovernorDesign
    run: GovernedRun
    row: GovernorRow
    faults: tuple[str, ...] = ()
    study: GovernorStudy | None = None
    sil: Mapping[str, Any] | None = None
    wcet: Mapping[str, Any] | None = None
    build: Mapping[str, Any] | None = None
    certificate: Certificate | None = None

    @property
    def toml(self) -> str:
        """See ``Found``."""
        return self.machine.project.file.name

    @property
    def digest(self) -> str:
        """See ``Found``: of all that is emitted, the streamed motion too."""
        motions = motion_declarations(self.machine.project, self.design.precision)
        return design_hash((*motions, *declare_governor_parts(self.design)))
