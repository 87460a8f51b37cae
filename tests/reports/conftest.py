"""A small machine that has drawn its path, as the report takes it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from servogen.controllers.cascade import Cascade
from servogen.controllers.cascade_design import declare_parts
from servogen.controllers.design import design_hash
from servogen.evidence.certificate import Certificate, Entry
from servogen.evidence.finding import Origin
from servogen.project import load_project
from servogen.reports import ReportData
from servogen.systems.closed_loop import run_closed_loop
from servogen.systems.judgement import check_project
from servogen.systems.metrics import contour_error
from servogen.systems.study import judge
from servogen.systems.two_stage import Machine, design_cascade, project_tuning

TOML = """\
schema = 1
name = "corner"
system = "two_stage"

[machine.x.slow]
model = "servo"
bandwidth_rad_per_s = 45.0
damping = 0.7
position_limit_m = 0.4
velocity_limit_m_per_s = 0.7
acceleration_limit_m_per_s2 = 14.71

[machine.x.fast]
model = "servo"
bandwidth_rad_per_s = 2250.0
damping = 0.7
range_m = 0.01
velocity_limit_m_per_s = 0.6
acceleration_limit_m_per_s2 = 49.05

[sampling]
fast_sample_time_s = 0.001
slow_sample_time_s = 0.03

[controller.mpc]
horizon = 3

[path]
file = "corner.dxf"
feed_m_per_s = 0.5
corner_time_s = 0.001
"""
DXF = """\
0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES
0 LINE 8 0 10 0.0 20 0.0 11 300.0 21 0.0
0 LINE 8 0 10 300.0 20 0.0 11 300.0 21 100.0
0 LINE 8 0 10 300.0 20 100.0 11 0.0 21 0.0
0 ENDSEC 0 EOF
"""


@pytest.fixture(scope="session")
def bare(tmp_path_factory: pytest.TempPathFactory) -> ReportData:
    """Only the closed loop was run."""
    folder: Path = tmp_path_factory.mktemp("corner")
    (folder / "corner.dxf").write_text("\n".join(DXF.split()) + "\n")
    (folder / "servogen.toml").write_text(TOML)
    project = load_project(folder / "servogen.toml")
    judged = check_project(project)
    machine = Machine(project, judged.plants, judged.sets, judged.timed)
    design = design_cascade(machine, project_tuning(project))
    run = run_closed_loop(machine, Cascade(design))
    return ReportData(
        machine=machine,
        run=run,
        row=judge("corner", run),
        contour_error=contour_error(run),
        design=design,
    )


@pytest.fixture(scope="session")
def full(bare: ReportData) -> ReportData:
    """Everything was run."""
    budget = {
        "calls": {"corner_plan": 1, "corner_fast_step": 30},
        "target": "tms320c6678",
        "budget_cycles": 6e6,
        "fixed_cycles": 81234.0,
        "cycles_per_iteration": 4321.0,
        "cap": 500,
        "total_cycles": 2241734.0,
        "utilisation": 0.3736,
        "largest_cap": 1369,
        "fits": True,
        "culprit": None,
    }
    counts = {"add": 1234567, "mul": 7654, "div": 3, "cmp": 11, "load": 21, "store": 31, "call": 5}
    scenario: dict[str, Any] = {
        "controller": "corner_mpc",
        "name": "edges",
        "precision": "float64",
        "passed": True,
        "calls": 413,
        "decisions": 826,
        "largest_difference": 0.0,
        "statuses": {"OK": 400, "NOT_FINITE": 13},
        "difference": None,
    }
    entry = Entry("pil", "Processor in the loop", "passed", "91 answers equal", "check pil",
                  {"qemu": "7.2.22"}, "2026-01-02")  # fmt: skip
    one = {"steps": 9, "none_needed": 4, "median": 1.0, "p99": 17.0, "most": 17, "most_solved": 6,
           "backup": 1, "infeasible": 2, "histogram": {"0": 4, "3": 3, "17": 2}}  # fmt: skip
    cold = {"exact": True, "finished": True, "bound": 19, "attained": 19, "pieces": 8381}
    warm = {"exact": False, "finished": False, "bound": 21, "attained": 21, "pieces": 17973}
    iterations = Entry(
        "iterations", "Worst case of the iterations", "measured", "not certified", "check",
        figures={
            "cap": 500,
            "programs": {"corner_mpc": {"certified": None, "cold": cold, "warm": warm}},
            "measured": {"closed loop": one},
        },
    )  # fmt: skip
    return replace(
        bare,
        certificate=Certificate(
            "corner",
            "0",
            "d" * 64,
            "float64",
            {"float64": "e" * 64},
            Origin("f" * 64, "2026-01-02"),
            (entry, iterations),
        ),
        study=[replace(bare.row, name="MPC-20-B"), replace(bare.row, name="LFS", enforced=False)],
        sil={
            "schema": "servogen.sil/1",
            "passed": True,
            "bound": 0.0,
            "scenarios": [scenario, scenario | {"precision": "float32", "calls": 587}],
            "closed_loops": [{"precision": "float64", "periods": 77, "passed": True}],
        },
        wcet={
            "schema": "servogen.wcet/2",
            "passed": True,
            "share": 0.2,
            "budgets": {"30 ms": budget},
            "precision": "float64",
            "entry_points": {
                "corner_step": {
                    "fixed": counts,
                    "per_iteration": {"CORNER_MPC_ITERATION_CAP": counts},
                    "caps": {"CORNER_MPC_ITERATION_CAP": 500},
                    "total": counts,
                    "stack_bytes": 999,
                }
            },
            "table_bytes": {"corner_mpc_columns": 13122},
        },
        build={
            "schema": "servogen.build/1",
            "passed": True,
            "design_hash": design_hash(declare_parts(bare.design)),
            "files": {"corner.c": 4711},
        },
    )
