"""Tables of a servo drive: forms of the lookup, tracking errors, tasks, design."""

from __future__ import annotations

import numpy as np

from servogen.explicit.choose import Form
from servogen.project.limits import Limits, as_written
from servogen.reports.numbers import NOTHING, fixed, number, percent
from servogen.reports.servo_data import ServoReportData
from servogen.reports.style import PATH_COLOUR, X_COLOUR, Y_COLOUR, Figure, layout, limit, line
from servogen.reports.tables import (
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
from servogen.systems.servo_charts import Study
from servogen.systems.servo_study import HORIZONS, PRINTED_MPC, PRINTED_PID, TrackingTable, within
from servogen.systems.servo_task import TaskRow


def forms_table(data: ServoReportData) -> Table:
    """Every form that was looked at, the chosen one marked."""
    chosen = data.choice.chosen
    return Table(
        "Forms of the lookup",
        ("form", "what it is", "laws", "multiply-adds", "additions", "comparisons", "sign changes",
         "in all", "table numbers", "verdict"),
        tuple(_form(form, form is chosen) for form in data.choice.forms),
        f"Operations of one lookup in the worst case, the estimator aside. Chosen: "
        f"{data.choice.reason}.",
    )  # fmt: skip


def _form(form: Form, chosen: bool) -> tuple[Cell, ...]:
    none = Cell(NOTHING, MUTED, numeric=True)
    laws = none if form.solution is None else figure_cell(form.solution.laws.count)
    if form.count is None:
        counts: tuple[Cell, ...] = (none,) * 6
        verdict = Cell("cannot be had or cannot win", MUTED)
    else:
        c = form.count
        counts = tuple(
            figure_cell(v)
            for v in (
                c.multiply_adds, c.additions, c.comparisons, c.sign_changes, c.work, c.numbers
            )
        )  # fmt: skip
        verdict = Cell("chosen", GOOD) if chosen else Cell("dearer", MUTED)
    return (text(form.name, "name"), text(form.note), laws, *counts, verdict)


def tracking_tables(study: Study) -> list[Table]:
    """Figures 7 and 8 as numbers, and the largest errors beside those that the paper prints."""
    rows = [cells for table in study.tables for cells in _tracking(table)]
    tracking = Table(
        "Tracking error",
        ("case", "hold", *(f"H_t = {h}" for h in HORIZONS), "PID"),
        tuple(rows),
        "Sum of the magnitudes of the error over the last cycle, H_t = H_u, as a share of "
        f"set-point tracking (H_t = 1); {within(table.case for table in study.tables)}.",
    )
    cells = tuple(
        (
            text(f"{row.case.frequency_hz:g} Hz, within {number(row.case.limit_ma)} mA", "name"),
            figure_cell(row.needed_ma, 4),
            figure_cell(row.mpc[0]),
            figure_cell(row.mpc[1]),
            figure_cell(row.pid[0]) if row.pid else text(NOTHING, MUTED),
            figure_cell(row.pid[1]) if row.pid else text(NOTHING, MUTED),
        )
        for row in study.errors
    )
    missing = Cell(NOTHING, MUTED, numeric=True)
    printed = (
        text("printed: 10 Hz, within 1000 mA", MUTED), missing,
        figure_cell(PRINTED_MPC, kind=MUTED), missing, figure_cell(PRINTED_PID, kind=MUTED),
        missing,
    )  # fmt: skip
    largest = Table(
        "Largest error beside the paper's",
        ("case", "current needed [mA]", "MPC, whole run [deg]", "MPC, last cycle [deg]",
         "PID, whole run [deg]", "PID, last cycle [deg]"),
        (*cells, printed),
        study.reason,
    )  # fmt: skip
    return [tracking, largest]


def _tracking(table: TrackingTable) -> list[tuple[Cell, ...]]:
    case = f"{table.case.frequency_hz:g} Hz, {number(table.case.limit_ma / 1000.0)} A"
    pid = Cell(NOTHING, MUTED, numeric=True) if table.pid is None else figure_cell(table.pid, 3)
    return [
        (text(case, "name"), text(name), *(_share(value) for value in values.tolist()), pid)
        for name, values in (("zero order", table.zero_order), ("first order", table.first_order))
    ]


def _share(value: float) -> Cell:
    known = bool(np.isfinite(value))
    return Cell(fixed(value, 4), numeric=True) if known else Cell(NOTHING, MUTED, numeric=True)


def horizon_figure(study: Study) -> Figure:
    """Figures 7 and 8 in kind."""
    traces = []
    for panel, table in enumerate(study.tables, start=1):
        shown = {"showlegend": panel == 1, "mode": "lines+markers"}
        traces += [
            line("zero-order hold", HORIZONS, table.zero_order, Y_COLOUR, 1.6, panel,
                 legendgroup="zero", **shown),
            line("first-order hold", HORIZONS[1:], table.first_order[1:], X_COLOUR, 1.6, panel,
                 legendgroup="first", **shown),
        ]  # fmt: skip
        if table.pid is not None:
            level = limit("PID", (HORIZONS[0], HORIZONS[-1]), table.pid, panel, panel == 1)
            traces.append(level | {"line": {"color": PATH_COLOUR, "dash": "dash"}})
    titles = [f"at {table.case.frequency_hz:g} Hz [1]" for table in study.tables]
    shape = layout("H_t = H_u [1]", titles)
    for key in ("yaxis", "yaxis2"):
        shape[key] |= {"type": "log"}
    return Figure(
        "horizons",
        "Error against the trajectory horizon",
        "Figures 7 and 8 of the paper in kind: summed error of the last cycle, set-point tracking "
        f"being 1; {within(table.case for table in study.tables)}.",
        traces,
        shape,
        height=560,
    )


def task_tables(data: ServoReportData) -> list[Table]:
    """The runs of every task, and their constraints."""
    runs = tuple(
        (
            text(f"{row.controller}, {row.task}", "name"),
            figure_cell(row.samples),
            figure_cell(row.largest_error_deg),
            figure_cell(row.mean_error_deg),
            figure_cell(row.last_error_deg, 3),
            figure_cell(row.largest_current_ma),
            text(", ".join(f"{name} {count}" for name, count in row.statuses.items())),
            passed_cell(row.passed),
        )
        for row in data.rows
    )
    columns = ("run", "samples", "largest error [deg]", "mean error [deg]", "error at end [deg]",
               "largest current [mA]", "statuses", "verdict")  # fmt: skip
    bounds = tuple(_bound(row, bound) for row in data.rows for bound in row.bounds)
    return [
        Table("Runs on the machine", columns, runs),
        Table(
            "Worst against limit",
            ("run", "constraint", "where", "worst", "limit", "unit", "share", "verdict"),
            bounds,
            "Enforced constraints must hold; the others are reported.",
        ),
    ]


def _bound(row: TaskRow, bound: Bound) -> tuple[Cell, ...]:
    if bound.enforced:
        verdict = passed_cell(bound.passed, "kept", "broken")
    else:
        over = bound.violation > 0.0
        verdict = Cell("reported, exceeded" if over else "reported", MUTED)
    return (
        text(f"{row.controller}, {row.task}", "name"),
        text(bound.name),
        text(bound.where),
        figure_cell(bound.worst, 5),
        figure_cell(bound.limit, 5),
        text(bound.unit),
        Cell(NOTHING if np.isnan(bound.share) else percent(bound.share), numeric=True),
        verdict,
    )


def _limits(limits: Limits) -> object:
    written = as_written(limits)
    return f"{limits[0]:g} to {limits[1]:g}" if isinstance(written, list) else written


def design_tables(data: ServoReportData) -> list[Table]:
    """What was designed: horizons, regions, filter, sizes of tables."""
    mpc, project = data.parts.mpc, data.servo.project
    horizons = mpc.problem.horizons
    sizes: dict[str, object] = {
        "sample time T [µs]": 1e6 * project.sampling.sample_time_s,
        "current loop [µs]": 1e6 * project.sampling.current_sample_time_s,
        "states n": mpc.problem.plant.order,
        "horizons H_p, H_t, H_u": f"{horizons.prediction}, {horizons.trajectory}, "
        f"{horizons.control}",
        "reference extension": project.controller.mpc.reference_extension.replace("_", " ")
        + " hold",
        "parameters of the program": mpc.problem.layout.size,
        "current limit [mA]": _limits(project.controller.mpc.current_limit_ma),
        "slowest pole of the filter": mpc.filter.decay,
        "one turn [deg]": mpc.turn or "none: the axis has ends",
    }
    declarations = data.parts.declarations()
    rows = tuple(
        (text(d.prefix, "name"), text(d.summary), figure_cell(d.table_bytes)) for d in declarations
    )
    total = sum(d.table_bytes for d in declarations)
    note = f"{number(total)} bytes of constant tables in {mpc.precision.name}."
    return [
        key_table("Design", sizes),
        Table("Controllers", ("part", "what it is", "tables [bytes]"), rows, note),
    ]
