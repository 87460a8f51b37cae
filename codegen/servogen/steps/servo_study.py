"""``servogen study`` of a servo drive: the paper's tracking errors and what it prints of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.progress import Progress
from servogen.systems.servo_charts import Study, whole_study
from servogen.systems.servo_drive import ServoDrive
from servogen.systems.servo_study import (
    HORIZONS,
    PRINTED_MPC,
    PRINTED_PID,
    LargestError,
    TrackingTable,
    statements,
)

SCHEMA = "servogen.study_servo/1"


@dataclass(frozen=True)
class ServoStudy:
    """The comparison; it fails where a controller does not even stay finite."""

    found: Study

    @property
    def faults(self) -> list[str]:
        """One sentence for each table with an error that is none."""
        return self.found.faults

    @property
    def passed(self) -> bool:
        return not self.faults

    def lines(self) -> list[str]:
        if self.found.absent:
            return [f"study     the paper's comparison cannot be made: {self.found.absent}"]
        head = "".join(f"{h:>8d}" for h in HORIZONS)
        lines = [f"study     summed error, last cycle, H_t = 1 is 1; H_t = {head}     PID"]
        for table in self.found.tables:
            case = f"{table.case.frequency_hz:g} Hz, {table.case.limit_ma / 1000.0:g} A"
            pid = "    none" if table.pid is None else f"{table.pid:8.3f}"
            for name, row in (("ZOH", table.zero_order), ("FOH", table.first_order)):
                cells = "".join("       -" if np.isnan(v) else f"{v:8.4f}" for v in row)
                lines.append(f"          {case:<22s} {name:<21s} {cells}{pid}")
                pid = ""
        for one in self.found.errors:
            told = "" if one.pid is None else f", PID {one.pid[0]:.4g}"
            lines.append(
                f"          largest error at {one.case.frequency_hz:g} Hz within "
                f"{one.case.limit_ma:g} mA: MPC {one.mpc[0]:.4g} deg{told}; needs "
                f"{one.needed_ma:.0f} mA"
            )
        lines.append(f"          printed: MPC {PRINTED_MPC:g}, PID {PRINTED_PID:g}")
        lines.append(f"          {self.found.reason}")
        for told, holds in statements(self.found.tables):
            lines.append(
                f"          {'as the paper says' if holds else 'unlike the paper'}: {told}"
            )
        return [*lines, *(f"          FAILED: {fault}" for fault in self.faults)]

    def to_json(self) -> dict[str, object]:
        pulled = self.found.disturbance
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "faults": self.faults,
            "absent": self.found.absent,
            "horizons": list(HORIZONS),
            "tables": [_table(table) for table in self.found.tables],
            "largest_errors": [_error(row) for row in self.found.errors],
            "printed": {"mpc_deg": PRINTED_MPC, "pid_deg": PRINTED_PID},
            "reason": self.found.reason,
            "statements": dict(statements(self.found.tables)),
            "plan_gap_ma": {name: fall.gap for name, fall in self.found.waterfalls},
            "disturbance": None
            if pulled is None
            else {
                "torque_n_m": pulled.torque,
                "largest_error_deg": float(np.max(np.abs(pulled.run.error))),
                "last_error_deg": float(abs(pulled.run.error[-1])),
                "laws_met": int(np.unique(pulled.law).size),
            },
        }


def _table(table: TrackingTable) -> dict[str, object]:
    return {
        "frequency_hz": table.case.frequency_hz,
        "current_limit_ma": table.case.limit_ma,
        "zero_order": table.zero_order.tolist(),
        "first_order": table.first_order.tolist(),
        "pid": table.pid,
        "set_point_error_deg": table.reference_deg,
    }


def _error(row: LargestError) -> dict[str, object]:
    return {
        "frequency_hz": row.case.frequency_hz,
        "current_limit_ma": row.case.limit_ma,
        "needed_ma": row.needed_ma,
        "reachable": row.reachable,
        "mpc_deg": list(row.mpc),
        "pid_deg": None if row.pid is None else list(row.pid),
    }


def study(servo: ServoDrive, progress: Progress) -> ServoStudy:
    """Run the comparison."""
    return ServoStudy(whole_study(servo, progress))
