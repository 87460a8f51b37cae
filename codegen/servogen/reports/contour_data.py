"""What the report of a contour controller is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from servogen.controllers.contour_lq_declaration import declare_contour_lq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.design import design_hash
from servogen.evidence.certificate import Certificate
from servogen.systems.contour_loop import ContourRun
from servogen.systems.contour_machine import ContourMachine
from servogen.systems.contour_rows import ContourErrors, ContourRow, errors_of
from servogen.systems.contour_study import ContourStudy


@dataclass(frozen=True)
class ContourReportData:
    """Everything found about one machine. What is None was not run, and is shown so.

    Attributes:
        machine: the judged project; design: what was emitted.
        run: the closed loop; row: that run, judged; faults: what ``simulate`` found wrong.
        notes: what a user should know. study: the comparison.
        sil, wcet, build, certificate: see ``Found``.
    """

    machine: ContourMachine
    design: ContourLqDesign
    run: ContourRun
    row: ContourRow
    faults: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    study: ContourStudy | None = None
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
        """See ``Found``."""
        return design_hash((declare_contour_lq(self.design),))

    @cached_property
    def errors(self) -> ContourErrors:
        """Of every sample of the run."""
        return errors_of(self.run, self.machine.task)
