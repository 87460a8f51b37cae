"""Tables of the closed loop: constraints, design, statuses, Table I."""

from __future__ import annotations

from collections.abc import Sequence

from servogen.controllers.cascade_design import declare_parts
from servogen.reports.data import ReportData
from servogen.reports.numbers import NOTHING, fixed, number, percent
from servogen.reports.tables import (
    BAD,
    GOOD,
    MUTED,
    Cell,
    Table,
    figure_cell,
    key_table,
    passed_cell,
    text,
)
from servogen.systems.metrics import Bound
from servogen.systems.study import PAPER, PAPER_IDEAL_S, StudyRow

_PRETTY_UNITS = {"m/s^2": ("m/s²", 1.0), "m": ("mm", 1e3)}


def shown_in(unit: str) -> tuple[str, float]:
    """Unit of the page for a unit of the data, and the factor."""
    return _PRETTY_UNITS.get(unit, (unit, 1.0))


def constraint_table(bounds: Sequence[Bound]) -> Table:
    """Worst against limit, in the order of the judgement."""
    return Table(
        "Worst against limit",
        ("constraint", "where", "worst", "limit", "unit", "share", "over by", "verdict"),
        tuple(_constraint(bound) for bound in bounds),
        "The worse axis of both. Enforced constraints must hold; the others are reported.",
    )


def _constraint(bound: Bound) -> tuple[Cell, ...]:
    unit, factor = shown_in(bound.unit)
    over = bound.violation
    if bound.enforced:
        verdict = passed_cell(bound.passed, "kept", "broken")
    else:
        verdict = Cell("reported" if over == 0.0 else "reported, exceeded", MUTED)
    return (
        text(bound.name),
        text(bound.where),
        figure_cell(factor * bound.worst, 5),
        figure_cell(factor * bound.limit, 5),
        text(unit),
        Cell(percent(bound.worst / bound.limit), numeric=True),
        Cell(NOTHING, MUTED, numeric=True) if over == 0.0 else figure_cell(factor * over, 3),
        verdict,
    )


def study_table(rows: Sequence[StudyRow]) -> Table:
    """Table I: each controller, and below it the paper's figures."""
    cells: list[tuple[Cell, ...]] = []
    for row in rows:
        cells.append(_own_row(row))
        if row.name in PAPER:
            cells.append(_paper_row(row.name))
    return Table(
        "Table I",
        (
            "controller",
            "time [s]",
            "time / ideal",
            "max |a| x, y [m/s²]",
            "mean |a| x, y [m/s²]",
            "mean |v| x, y [cm/s]",
            "mean fast x, y [mm]",
            "work x, y [J/kg]",
            "contour error [µm]",
            "backups",
            "constraints",
        ),
        tuple(cells),
        "Maximum at slow samples, means over the run. Work is the integral of |v a|. The paper's "
        f"ideal time is {fixed(PAPER_IDEAL_S, 2)} s; its work is printed in W/kg.",
    )


def _pair(values: tuple[float, float], decimals: int, factor: float = 1.0, kind: str = "") -> Cell:
    x, y = (fixed(factor * value, decimals) for value in values)
    return Cell(f"{x}, {y}", kind, numeric=True)


def _own_row(row: StudyRow) -> tuple[Cell, ...]:
    p = row.performance
    if row.enforced:
        verdict = passed_cell(row.passed, "kept", "broken" if row.complete else "not finished")
    else:
        verdict = Cell("promises none", MUTED) if row.complete else Cell("not finished", BAD)
    return (
        text(row.name, "name"),
        Cell(fixed(p.time_s, 2), numeric=True),
        Cell(fixed(p.ratio, 4), numeric=True),
        _pair(p.max_acceleration, 2),
        _pair(p.mean_acceleration, 2),
        _pair(p.mean_velocity, 2, 100.0),
        _pair(p.mean_fast, 2, 1e3),
        _pair(p.work, 2),
        figure_cell(1e6 * row.contour_error_m, 3),
        figure_cell(row.backups),
        verdict,
    )


def _paper_row(name: str) -> tuple[Cell, ...]:
    time_s, max_a, mean_a, mean_v, fast, work = PAPER[name]
    missing = Cell(NOTHING, MUTED, numeric=True)
    return (
        text("paper", MUTED),
        Cell(fixed(time_s, 2), MUTED, numeric=True),
        Cell(fixed(time_s / PAPER_IDEAL_S, 3), MUTED, numeric=True),
        *(_pair(pair, 2, kind=MUTED) for pair in (max_a, mean_a, mean_v, fast, work)),
        missing,
        missing,
        Cell(NOTHING, MUTED),
    )


def design_tables(data: ReportData) -> list[Table]:
    """What was designed: sizes of the problem and of its tables."""
    design, machine = data.design, data.machine
    sizes: dict[str, object] = {
        "slow period T_s [ms]": 1e3 * machine.slow_period_s,
        "fast period T_f [ms]": 1e3 * machine.fast_period_s,
        "points per slow period M": machine.ratio,
        "points of the path": len(machine.timed.points) - 1,
        "horizon N": design.horizon or "none: the governor alone",
        "slow stage states per axis": design.governor.order,
    }
    for axis, own in (("x", machine.sets.x), ("y", machine.sets.y)):
        sizes[f"admissible set {axis}"] = (
            f"{own.k.size} rows, determined after {own.finite_step} samples, "
            f"{number(own.lp_count)} linear programs, tightening {number(own.tightening)}"
        )
    for mpc in {m.prefix: m for m in design.mpc or ()}.values():
        sizes[f"{mpc.prefix}: two-sided rows"] = mpc.rows
        sizes[f"{mpc.prefix}: iteration cap"] = mpc.solver.cap
    parts = declare_parts(design)
    tables = Table(
        "Controllers",
        ("part", "what it is", "tables [bytes]"),
        tuple((text(d.prefix, "name"), text(d.summary), figure_cell(d.table_bytes)) for d in parts),
        f"{number(sum(d.table_bytes for d in parts))} bytes of constant tables in "
        f"{design.governor.precision.name}.",
    )
    return [key_table("Design", sizes), tables]


def status_table(statuses: dict[str, int]) -> Table:
    """How often each status was met, per axis and slow period."""
    total = max(sum(statuses.values()), 1)
    rows = tuple(
        (
            text(name, GOOD if name == "OK" else ""),
            figure_cell(amount),
            Cell(percent(amount / total), numeric=True),
        )
        for name, amount in statuses.items()
    )
    return Table("Statuses", ("status", "axis steps", "share"), rows)
