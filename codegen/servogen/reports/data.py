"""What the report is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from servogen.controllers.cascade_design import CascadeDesign, declare_parts
from servogen.controllers.design import design_hash
from servogen.evidence.certificate import Certificate
from servogen.precision import FloatArray
from servogen.systems.closed_loop import Run
from servogen.systems.study import StudyRow
from servogen.systems.two_stage import Machine


class Found(Protocol):
    """What the parts of the page that all systems share are made of; None was not run."""

    @property
    def toml(self) -> str:
        """The project file's name without its folder: a report says nothing of the machine it was
        made on."""

    @property
    def digest(self) -> str:
        """Names the design that the report is about."""

    @property
    def sil(self) -> Mapping[str, Any] | None:
        """JSON of the verb."""

    @property
    def wcet(self) -> Mapping[str, Any] | None:
        """JSON of the verb."""

    @property
    def build(self) -> Mapping[str, Any] | None:
        """JSON of the verb."""

    @property
    def certificate(self) -> Certificate | None:
        """What was shown about this build, and what was not."""


@dataclass(frozen=True)
class ReportData:
    """Everything found about one two-stage machine. What is None was not run, and is shown so.

    Attributes:
        machine: the judged project.
        run: the closed loop, K slow periods of M samples.
        row: that run, judged.
        contour_error: (K M,) m.
        design: what was emitted.
        study: the rows of Table I.
        sil, wcet, build: the JSON of these verbs.
        certificate: what was shown about this build, and what was not.
        backup_share_limit: share of the axis steps on which the backup may be used.
    """

    machine: Machine
    run: Run
    row: StudyRow
    contour_error: FloatArray
    design: CascadeDesign
    study: Sequence[StudyRow] | None = None
    sil: Mapping[str, Any] | None = None
    wcet: Mapping[str, Any] | None = None
    build: Mapping[str, Any] | None = None
    certificate: Certificate | None = None
    backup_share_limit: float = 0.01

    @property
    def toml(self) -> str:
        """See ``Found``."""
        return self.machine.project.file.name

    @property
    def digest(self) -> str:
        """See ``Found``."""
        return design_hash(declare_parts(self.design))

    @property
    def contour_limit_m(self) -> float:
        return self.machine.project.target.contour_error_limit_m

    @property
    def backup_share(self) -> float:
        return self.row.backups / max(2 * self.row.periods, 1)
