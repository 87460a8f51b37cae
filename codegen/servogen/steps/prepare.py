"""From a project to the system and the C that every step starts from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Generic

from servogen.emit.package import CPackage
from servogen.precision import PRECISIONS, Precision
from servogen.progress import Progress
from servogen.project import Project
from servogen.project.contour_load import ContourProject
from servogen.project.governor_load import GovernorProject
from servogen.project.servo_load import ServoProject
from servogen.project.systems import AnyProject
from servogen.steps import contour, governor, servo_drive, two_stage
from servogen.steps.counted import emit_counted
from servogen.steps.system import Simulated, Studied, System
from servogen.steps.target import check_target
from servogen.wcet.package import PackageCount


@dataclass(frozen=True)
class Prepared(Generic[Simulated, Studied]):
    """A judged project; its C is emitted and counted once per precision."""

    system: System[Simulated, Studied]
    _emitted: dict[Precision, tuple[CPackage, PackageCount]] = field(
        default_factory=dict, repr=False, compare=False
    )

    @property
    def project(self) -> AnyProject:
        return self.system.project

    @property
    def precision(self) -> Precision:
        """What is shipped."""
        return PRECISIONS[self.project.output.precision]

    @property
    def package(self) -> CPackage:
        return self.package_in(self.precision)

    def package_in(self, precision: Precision) -> CPackage:
        """What is emitted in a precision, with its counts in the heads."""
        return self._emit(precision)[0]

    def counts_in(self, precision: Precision) -> PackageCount:
        """The worst case of what is emitted in a precision."""
        return self._emit(precision)[1]

    def _emit(self, precision: Precision) -> tuple[CPackage, PackageCount]:
        if precision not in self._emitted:
            declarations = self.system.declarations(precision)
            self._emitted[precision] = emit_counted(self.project.name, declarations)
        return self._emitted[precision]


def prepare(project: AnyProject, progress: Progress) -> Prepared[Any, Any]:
    """The system of a project, with its design.

    Raises:
        InputError: whatever is wrong with the project.
        CheckFailed: ``iteration_cap = "target"`` and not one iteration fits.
    """
    check_target(project)
    match project:
        case Project():
            return Prepared(two_stage.prepare_two_stage(project, progress))
        case ServoProject():
            return Prepared(servo_drive.prepare_servo(project, progress))
        case GovernorProject():
            return Prepared(governor.prepare_governor(project, progress))
        case ContourProject():
            return Prepared(contour.prepare_contour(project, progress))


def proof_titles() -> dict[str, str]:
    """The proofs of every system, name -> title, in the order of the certificate."""
    return {**two_stage.PROOFS, **servo_drive.PROOFS, **governor.PROOFS, **contour.PROOFS}
