"""The page of a contour controller."""

from __future__ import annotations

from servogen.controllers.contour_stability import theorem_conditions
from servogen.controllers.contour_weights import Terminal
from servogen.reports.checks import Check, build_checks, step_checks
from servogen.reports.contour_data import ContourReportData
from servogen.reports.contour_figures import run_figures
from servogen.reports.contour_study_parts import spectrum_figure, study_parts
from servogen.reports.count_tables import wcet_parts
from servogen.reports.evidence_tables import evidence_parts
from servogen.reports.numbers import number, percent
from servogen.reports.page import Page, render
from servogen.reports.step_tables import build_parts, sil_parts
from servogen.reports.tables import BAD, GOOD, MUTED, Cell, Section, Table, key_table, text
from servogen.reports.tiles import KeyFigure, cycles_tile
from servogen.systems.contour_proofs import design_spectrum
from servogen.systems.contour_study import study_faults


def make_contour_report(data: ContourReportData) -> str:
    """See ``page.render``; the same data give the same bytes."""
    return render(
        Page(
            name=data.machine.project.name,
            digest=data.digest,
            summary=_summary(data),
            tiles=_tiles(data),
            checks=contour_checks(data),
            sections=_sections(data),
        )
    )


def _summary(data: ContourReportData) -> str:
    table, row = data.machine.project.controller.contour, data.row
    axes = {2: "Two", 3: "Three"}[len(data.machine.axes)]
    return (
        f"{axes} axes of “{data.machine.project.name}” under receding-horizon LQ contour control, "
        f"N_p = {table.preview}, alpha = {table.tracking_weight:g}, beta = "
        f"{table.contour_weight:g}. With encoders the tool is {number(1e6 * row.contour_rms_m, 3)} "
        f"µm RMS off the contour and {number(1e6 * row.tracking_rms_m, 3)} µm from the point that "
        "is due."
    )


def _tiles(data: ContourReportData) -> list[KeyFigure]:
    row = data.row
    return [
        KeyFigure(
            "Contour error",
            f"{number(1e6 * row.contour_rms_m, 3)} µm",
            f"RMS; {number(1e6 * row.contour_max_m, 3)} µm at most at its feed"
            if row.start_m > 0.0
            else f"RMS; {number(1e6 * row.contour_max_m, 3)} µm at most",
        ),
        KeyFigure(
            "Tracking error",
            f"{number(1e6 * row.tracking_rms_m, 3)} µm",
            f"RMS; {number(1e6 * row.tracking_max_m, 3)} µm at most",
        ),
        KeyFigure("Commands", percent(max(row.command_share)), "of their limits at most"),
        cycles_tile(data),
        KeyFigure("Design", data.digest[:8], f"{data.design.precision.name}, sha-256"),
    ]


def contour_checks(data: ContourReportData) -> list[Check]:
    """In the order of the page."""
    told = "; ".join(data.faults) or (
        f"{number(1e6 * max(data.row.contour_max_m, data.row.start_m), 3)} µm off the contour at "
        "most, start and end included; no command cut"
    )
    return [
        Check("Closed loop", not data.faults, told),
        *step_checks(data),
        _study_check(data),
        *build_checks(data),
    ]


def _study_check(data: ContourReportData) -> Check:
    if data.study is None:
        return Check("Comparison", None, "not run", f"servogen study {data.toml}")
    faults = study_faults(data.study)
    told = "; ".join(faults) or f"{len(data.study.rows)} controllers"
    return Check("Comparison", not faults, told)


def _sections(data: ContourReportData) -> list[Section]:
    return [
        Section("contour", "Contour", (*run_figures(data), run_table(data))),
        Section("stability", "Stability", (spectrum_figure(data), theorem_table(data))),
        Section("study", "Comparison", tuple(study_parts(data))),
        Section("sil", "Equivalence", tuple(sil_parts(data))),
        Section("wcet", "Counts and cycles", tuple(wcet_parts(data))),
        Section("evidence", "Evidence", tuple(evidence_parts(data))),
        Section("build", "Build", tuple(build_parts(data))),
    ]


def run_table(data: ContourReportData) -> Table:
    """What a run says besides its curves."""
    row, task = data.row, data.machine.task
    return key_table(
        "The run",
        {
            "samples": row.samples,
            "samples that count": task.last - task.first,
            "contour error RMS, largest [µm]": [1e6 * row.contour_rms_m, 1e6 * row.contour_max_m],
            "tracking error RMS, largest [µm]": [
                1e6 * row.tracking_rms_m,
                1e6 * row.tracking_max_m,
            ],
            "contour error before that, largest [µm]": 1e6 * row.start_m,
            "distance from the end, at rest [µm]": 1e6 * row.stop_m,
            "samples without a direction": row.priming,
            "samples with a command cut": row.limited,
        },
        "Positions as the encoders tell them; the axes begin and end at rest.",
    )


def theorem_table(data: ContourReportData) -> Table:
    """Theorem 1, hypothesis by hypothesis."""
    plants = [axis.model.plant for axis in data.design.axes]
    found = theorem_conditions(plants, data.design.weights, data.design.terminal)
    free = data.design.terminal is Terminal.OUTPUT
    rows = []
    for condition in found:
        kind, told = (GOOD, "holds") if condition.holds else (BAD, "does not hold")
        if free and not condition.holds and condition.name.startswith("H at the end"):
            kind, told = MUTED, "not asked for"
        rows.append((text(condition.name), Cell(told, kind), text(condition.found)))
    spectrum, preview = design_spectrum(data.design), data.design.preview
    note = (
        f"Not told here: {spectrum.warning(preview)}."
        if spectrum.unstable(preview)
        else "Where all hold, the closed loop is stable on straight contours of every direction "
        "with every preview. On curves the spectrum of the time frozen proves nothing."
    )
    return Table("Theorem 1", ("hypothesis", "verdict", "found"), tuple(rows), note)
