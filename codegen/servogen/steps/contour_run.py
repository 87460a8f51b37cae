"""``servogen simulate`` of a contour controller: the closed loop along the contour, judged."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.design import Reference
from servogen.emit.package import CPackage
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.contour_loop import ContourRun, run_contour
from servogen.systems.contour_machine import ContourMachine
from servogen.systems.contour_proofs import design_spectrum
from servogen.systems.contour_rows import ContourRow, judge_contour

SCHEMA = "servogen.simulate_contour/1"


@dataclass(frozen=True)
class ContourSimulation:
    """The run and its row; ``limit_m``: of the contour error. ``unstable``: the warning of the
    spectrum where a mode on some straight contour grows, else empty."""

    run: ContourRun
    row: ContourRow
    limit_m: float
    inside: str
    unstable: str = ""

    @property
    def faults(self) -> list[str]:
        """One sentence for each check that failed."""
        row, found = self.row, []
        largest = max(row.contour_max_m, row.start_m)
        if largest > self.limit_m:
            found.append(
                f"contour error {1e6 * largest:.3g} um, target.contour_error_limit_m allows "
                f"{1e6 * self.limit_m:.3g} um"
            )
        if row.limited:
            found.append(
                f"commands were cut to their limits in {row.limited} samples: a lower feed, a "
                "longer ramp or wider limits"
            )
        if row.refused:
            found.append(f"inputs were refused in {row.refused} samples")
        if found and self.unstable:
            found.append(f"the likely cause, controller.contour: {self.unstable}")
        return found

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        row = self.row
        shares = ", ".join(f"{share:.0%}" for share in row.command_share)
        lines = [
            f"simulate  {row.samples} samples with the {self.inside} inside and encoders: contour "
            f"error {_um(row.contour_rms_m)} um RMS, {_um(row.contour_max_m)} at most; tracking "
            f"{_um(row.tracking_rms_m)} um RMS, {_um(row.tracking_max_m)} at most",
            f"          start: contour error {_um(row.start_m)} um at most, no direction known in "
            f"{row.priming} samples; {_um(row.stop_m)} um from the end at rest; commands up to "
            f"{shares} of their limits",
        ]
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "inside": self.inside,
            "contour_error_limit_m": self.limit_m,
            **asdict(self.row),
        }


def simulate(
    machine: ContourMachine,
    design: ContourLqDesign,
    package: CPackage | None,
    progress: Progress,
) -> ContourSimulation:
    """The project's contour from rest to rest, positions as the encoders tell them.

    Args:
        package: the C inside; None: the reference of ``design``.
    """
    task = machine.task
    with (
        _controller(design, package) as controller,
        progress.task("Closed loop", total=task.samples) as shown,
    ):
        run = run_contour(
            design, controller, machine.axes, task.motion, task.samples, machine.encoder_m,
            task.moving, shown.advance,
        )  # fmt: skip
    row = judge_contour(machine.project.name, run, task, machine.limits)
    inside = "Python reference" if package is None else "compiled C"
    spectrum = design_spectrum(design)
    return ContourSimulation(
        run,
        row,
        machine.project.target.contour_error_limit_m,
        inside,
        spectrum.warning(design.preview) if spectrum.unstable(design.preview) else "",
    )


@contextmanager
def _controller(design: ContourLqDesign, package: CPackage | None) -> Iterator[Reference]:
    if package is None:
        yield ContourLq(design)
        return
    with built(package) as module:
        yield CompiledController(module, package.declarations[-1])


def _um(metres: float) -> str:
    return f"{1e6 * metres:.3g}"
