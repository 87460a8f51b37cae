"""``servogen study`` of a contour controller: the paper's table and sweeps on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_declaration import declare_contour_lq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.design import Reference
from servogen.emit.package import emit_package
from servogen.progress import Progress
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.contour_machine import ContourMachine
from servogen.systems.contour_rows import ContourRow
from servogen.systems.contour_study import (
    ContourStudy,
    ContourSweep,
    compare_contours,
    study_faults,
)

SCHEMA = "servogen.study_contour/1"
# Of a contour with fewer samples Python is done before the compiler is; the bits are the same.
SHORT = 1500
# A design is run once: what optimising it takes is more than it gives back. The bits are the same.
QUICK = ("-O0",)
WIDTH = 52


@dataclass(frozen=True)
class ContourStudyResult:
    """The comparison; it fails where single precision changes an error, or a law with a guarantee
    is not stable."""

    found: ContourStudy

    @property
    def faults(self) -> list[str]:
        """One sentence for each."""
        return study_faults(self.found)

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        lines = [f"study     {'':{WIDTH}}  tracking um        contour um      commands"]
        lines.append(f"          {'':{WIDTH}}    RMS  largest    RMS  largest  of limit")
        lines += [f"          {row.name:{WIDTH}} {_told(row)}" for row in self.found.rows]
        lines += _troubled(self.found.troubles)
        for sweep in self.found.sweeps:
            lines += _swept(sweep)
        for spectrum in self.found.spectra:
            modulus, preview, _ = spectrum.worst()
            lines.append(
                f"          straight contours, {spectrum.terminal.value}: largest modulus "
                f"{modulus:.4f}, at N_p = {preview}"
            )
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "weight_scale": self.found.scale,
            "rows": [asdict(row) for row in self.found.rows],
            "troubles": [asdict(row) for row in self.found.troubles],
            "sweeps": [
                {
                    "title": sweep.title,
                    "key": sweep.key,
                    "values": list(sweep.values),
                    "rows": [asdict(row) for row in sweep.rows],
                }
                for sweep in self.found.sweeps
            ],
            "spectra": [
                {
                    "terminal": spectrum.terminal.value,
                    "largest_modulus_by_preview": spectrum.modulus.max(axis=1).tolist(),
                }
                for spectrum in self.found.spectra
            ],
        }


def _told(row: ContourRow) -> str:
    parts = (row.tracking_rms_m, row.tracking_max_m, row.contour_rms_m, row.contour_max_m)
    told = "  ".join(f"{1e6 * part:7.3f}" for part in parts)
    cut = f", cut in {row.limited}" if row.limited else ""
    return f"{told}  {max(row.command_share):5.0%}{cut}"


def _troubled(rows: tuple[ContourRow, ...]) -> list[str]:
    """Under a heading for each trouble."""
    lines: list[str] = []
    for row in rows:
        trouble, _, name = row.name.partition(": ")
        heading = f"          {trouble}:"
        lines += [] if heading in lines else [heading]
        lines.append(f"            {name:{WIDTH - 2}} {_told(row)}")
    return lines


def _swept(sweep: ContourSweep) -> list[str]:
    values = " ".join(f"{value:8.3g}" for value in sweep.values)
    tracking = " ".join(f"{1e6 * row.tracking_rms_m:8.3f}" for row in sweep.rows)
    contour = " ".join(f"{1e6 * row.contour_rms_m:8.3f}" for row in sweep.rows)
    return [
        f"          {sweep.title}: {sweep.key}, tracking and contour error um RMS",
        f"            {values}",
        f"            {tracking}",
        f"            {contour}",
    ]


def study(machine: ContourMachine, progress: Progress) -> ContourStudyResult:
    """Run the comparison, along a long contour with the C of every controller."""
    inside = by_reference if machine.task.samples < SHORT else by_c
    return ContourStudyResult(compare_contours(machine, inside, progress))


@contextmanager
def by_reference(design: ContourLqDesign) -> Iterator[Reference]:
    """The Python reference."""
    yield ContourLq(design)


@contextmanager
def by_c(design: ContourLqDesign) -> Iterator[Reference]:
    """The same, emitted and compiled."""
    package = emit_package(design.prefix, (declare_contour_lq(design),))
    with built(package, extra_flags=QUICK) as module:
        yield CompiledController(module, package.declarations[-1])
