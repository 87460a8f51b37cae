"""What the report of a servo drive is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from servogen.controllers.design import design_hash
from servogen.controllers.servo_parts import ServoParts
from servogen.evidence.certificate import Certificate
from servogen.explicit.choose import Choice
from servogen.systems.servo_charts import Study
from servogen.systems.servo_drive import ServoDrive
from servogen.systems.servo_loop import DriveRun
from servogen.systems.servo_task import TaskRow


@dataclass(frozen=True)
class ServoReportData:
    """Everything found about one servo drive. What is None was not run, and is shown so.

    Attributes:
        servo: the judged project; parts: what was emitted; choice: the forms of its lookup.
        runs: the tasks, judged, under each controller.
        study: the paper's comparison.
        sil, wcet, build, certificate: see ``Found``.
    """

    servo: ServoDrive
    parts: ServoParts
    choice: Choice
    runs: tuple[tuple[TaskRow, DriveRun], ...]
    study: Study | None = None
    sil: Mapping[str, Any] | None = None
    wcet: Mapping[str, Any] | None = None
    build: Mapping[str, Any] | None = None
    certificate: Certificate | None = None

    @property
    def toml(self) -> str:
        """See ``Found``."""
        return self.servo.project.file.name

    @property
    def digest(self) -> str:
        """See ``Found``."""
        return design_hash(self.parts.declarations())

    @property
    def rows(self) -> list[TaskRow]:
        return [row for row, _ in self.runs]
