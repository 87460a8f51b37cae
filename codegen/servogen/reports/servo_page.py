"""The page of a servo drive."""

from __future__ import annotations

import math

from servogen.reports.checks import Check, build_checks, step_checks
from servogen.reports.count_tables import wcet_parts
from servogen.reports.evidence_tables import evidence_parts
from servogen.reports.numbers import count, number, percent
from servogen.reports.page import Page, render
from servogen.reports.servo_data import ServoReportData
from servogen.reports.servo_regions_figure import regions_figure, tree_figure
from servogen.reports.servo_tables import (
    design_tables,
    forms_table,
    horizon_figure,
    task_tables,
    tracking_tables,
)
from servogen.reports.servo_time_figures import (
    law_figure,
    task_figures,
    tracking_figure,
    waterfall_figure,
)
from servogen.reports.step_tables import build_parts, sil_parts
from servogen.reports.tables import Missing, Section
from servogen.reports.tiles import KeyFigure, cycles_tile
from servogen.systems.servo_study import statements
from servogen.systems.servo_task import CURRENT_KEY, TaskRow


def make_servo_report(data: ServoReportData) -> str:
    """See ``page.render``; the same data give the same bytes."""
    return render(
        Page(
            name=data.servo.project.name,
            digest=data.digest,
            summary=_summary(data),
            tiles=_tiles(data),
            checks=servo_checks(data),
            sections=_sections(data),
        )
    )


def _first(data: ServoReportData, controller: str) -> TaskRow | None:
    """The first task under a controller."""
    return next((row for row in data.rows if row.controller == controller), None)


def _summary(data: ServoReportData) -> str:
    project = data.servo.project
    horizons = data.parts.mpc.problem.horizons
    mpc, pid = _first(data, "MPC"), _first(data, "PID")
    parts = [
        f"Servo drive “{project.name}” under trajectory-tracking explicit MPC, "
        f"H_p = {horizons.prediction}, H_t = {horizons.trajectory}, H_u = {horizons.control}, "
        f"looked up as {data.choice.chosen.name}."
    ]
    if mpc is not None:
        beside = (
            "" if pid is None else f"; the PID beside it {number(pid.largest_error_deg)} degrees"
        )
        parts.append(
            f"On its reference the axis is at most {number(mpc.largest_error_deg)} degrees off"
            f"{beside}."
        )
    return " ".join(parts)


def _tiles(data: ServoReportData) -> list[KeyFigure]:
    mpc, chosen = _first(data, "MPC"), data.choice.chosen
    tiles = []
    if mpc is not None:
        shares = [b.share for b in mpc.bounds if b.key == CURRENT_KEY]
        used = max(share for share in shares if not math.isnan(share))
        tiles += [
            KeyFigure("Largest error", f"{number(mpc.largest_error_deg, 3)}°", mpc.task),
            KeyFigure(
                "Current",
                f"{number(mpc.largest_current_ma, 3)} mA",
                f"{percent(used)} of the limit",
            ),
        ]
    if chosen.count is not None:
        tiles.append(
            KeyFigure(
                "Lookup",
                number(chosen.count.work),
                f"{number(chosen.count.multiply_adds)} multiply-adds, "
                f"{number(chosen.count.comparisons)} comparisons",
            )
        )
    if chosen.tree is not None:
        tiles.append(KeyFigure("Tree", f"{chosen.tree.nodes} nodes", f"depth {chosen.tree.depth}"))
    precision = data.parts.mpc.precision.name
    return [
        *tiles,
        cycles_tile(data),
        KeyFigure("Design", data.digest[:8], f"{precision}, sha-256"),
    ]


def servo_checks(data: ServoReportData) -> list[Check]:
    """In the order of the page."""
    found = [
        Check(
            f"{row.controller}: {row.task}",
            row.passed,
            "; ".join(row.faults) or f"largest error {number(row.largest_error_deg)} degrees",
        )
        for row in data.rows
    ]
    return [*found, *step_checks(data), _study_check(data), *build_checks(data)]


def _study_check(data: ServoReportData) -> Check:
    name = "Study of horizons"
    if data.study is None:
        return Check(name, None, "not run", f"servogen study {data.toml}")
    if data.study.absent:
        return Check(name, None, f"cannot be made here: {data.study.absent}")
    if data.study.faults:
        return Check(name, False, "; ".join(data.study.faults))
    told = statements(data.study.tables)
    other = [text for text, holds in told if not holds]
    detail = f"{count(len(told), 'statement')} of the paper hold"
    return Check(name, True, f"unlike the paper: {'; '.join(other)}" if other else detail)


def _sections(data: ServoReportData) -> list[Section]:
    drawn = [part for part in (regions_figure(data), tree_figure(data)) if part is not None]
    return [
        Section("tasks", "Motion", (*task_figures(data), *task_tables(data))),
        Section("lookup", "Lookup", (*drawn, forms_table(data))),
        Section("study", "Study", tuple(_study(data))),
        Section("sil", "Equivalence", tuple(sil_parts(data))),
        Section("wcet", "Counts and cycles", tuple(wcet_parts(data))),
        Section("evidence", "Evidence", tuple(evidence_parts(data))),
        Section("build", "Build", (*design_tables(data), *build_parts(data, _OWN))),
    ]


# What the JSON of ``build`` says of the design, which the page has tables of its own for.
_OWN = ("forms",)


def _study(data: ServoReportData) -> list[object]:
    study = data.study
    if study is None:
        what = "The trajectory horizons have not been compared"
        return [Missing(what, f"servogen study {data.toml}")]
    parts: list[object] = []
    if study.tables:
        parts += [horizon_figure(study), *tracking_tables(study)]
    if study.tracks is not None:
        parts.append(tracking_figure(*study.tracks))
    if study.waterfalls:
        parts.append(waterfall_figure(study.waterfalls, data.servo.drive.sample_time_s))
    if study.disturbance is not None:
        parts.append(law_figure(study.disturbance))
    if study.absent:
        parts.append(
            Missing(f"The paper's comparison cannot be made: {study.absent}", "edit the project")
        )
    return parts
