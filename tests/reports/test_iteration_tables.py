"""Iterations on the page: certified and measured told apart."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from servogen.reports import ReportData
from servogen.reports.checks import build_checks
from servogen.reports.iteration_tables import iteration_parts
from servogen.reports.numbers import number, percent
from servogen.reports.tables import Missing, Table


def tables(data: ReportData) -> dict[str, Table]:
    return {part.title: part for part in iteration_parts(data) if isinstance(part, Table)}


def texts(table: Table) -> list[list[str]]:
    return [[cell.text for cell in row] for row in table.rows]


def with_programs(data: ReportData, programs: dict[str, Any]) -> ReportData:
    assert data.certificate is not None
    first, own = data.certificate.entries
    own = replace(own, figures={**own.figures, "programs": programs})
    return replace(data, certificate=replace(data.certificate, entries=(first, own)))


def test_what_is_not_finished_is_not_certified(full: ReportData) -> None:
    found = tables(full)
    assert texts(found["Iterations certified"]) == [
        ["corner_mpc", "from a cold start", "exact", "19", "19", number(8381)],
        [
            "corner_mpc",
            "after any other call",
            "not certified: not finished",
            "21",
            "21",
            number(17973),
        ],
    ]
    measured = texts(found["Iterations measured, with the C inside"])
    assert measured == [["closed loop", "9", "4", "1", "17", "17", "6", "1", "2"]]
    assert "Worst case at the certified number of iterations" not in found
    line = next(c for c in build_checks(full) if c.name == "Evidence about the C")
    assert line.detail == "1 checks; measured, not proved: iterations"


def test_a_bound_that_was_not_held_is_not_certified(full: ReportData) -> None:
    broken = {"exact": False, "finished": True, "bound": 6, "attained": 6, "refuted": 7}
    apart = {"exact": False, "finished": True, "bound": 6, "attained": 5, "refuted": 0}
    programs = {"corner_mpc": {"certified": None, "cold": broken, "warm": apart}}
    found = tables(with_programs(full, programs))
    assert [row[2:5] for row in texts(found["Iterations certified"])] == [
        ["not certified: 7 were taken", "6", "6"],
        ["not certified: not attained", "6", "5"],
    ]
    rounds = {**broken, "refuted": 0, "rounding_may_cost_more": True}
    found = tables(with_programs(full, {"corner_mpc": {"certified": None, "warm": rounds}}))
    said = [row[2] for row in texts(found["Iterations certified"])]
    assert "not certified: rows may round to more than accept" in said


def test_the_histogram_has_every_step_once(full: ReportData) -> None:
    rows = texts(tables(full)["Steps by iterations"])
    assert rows == [
        ["0", percent(4 / 9)], ["1", ""], ["2", ""], ["3 to 4", percent(3 / 9)],
        ["5 to 8", ""], ["9 to 16", ""], ["17 to 32", percent(2 / 9)],
    ]  # fmt: skip


def test_the_work_at_the_certified_number_stands_beside_that_at_the_cap(full: ReportData) -> None:
    exact = {"exact": True, "finished": True, "bound": 21, "attained": 21, "pieces": 20000}
    done = {"corner_mpc": {"certified": 21, "cold": exact, "warm": exact}}
    found = tables(with_programs(full, done))
    work = texts(found["Worst case at the certified number of iterations"])
    assert work == [["30 ms", number(2241734), number(2241734 - 479 * 4321)]]
    above = {"exact": True, "finished": True, "bound": 501, "attained": 501, "pieces": 20000}
    found = tables(with_programs(full, {"corner_mpc": {"certified": 501, "warm": above}}))
    assert "exact, above the cap" in [row[2] for row in texts(found["Iterations certified"])]
    assert "Worst case at the certified number of iterations" not in found


def test_a_check_that_was_not_run_is_asked_for(full: ReportData, bare: ReportData) -> None:
    assert not iteration_parts(bare)
    assert full.certificate is not None
    entries = tuple(replace(e, state="not run", figures={}) for e in full.certificate.entries)
    asked = iteration_parts(replace(full, certificate=replace(full.certificate, entries=entries)))
    assert asked == [
        Missing("The iterations have not been looked at", "servogen check iterations servogen.toml")
    ]
