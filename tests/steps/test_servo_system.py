"""The servo drive on the line: what its steps find, refuse and say."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from servo_example import changed, compared, example, simulated, system

from servogen.controllers.design import Status, Value
from servogen.emit.package import CPackage, emit_package
from servogen.errors import InputError
from servogen.explicit.errors import ExplicitError
from servogen.jsontext import json_text
from servogen.precision import FLOAT32, FLOAT64
from servogen.progress import Silent
from servogen.project.systems import load_any_project
from servogen.sets.errors import SetError
from servogen.sil.harness import Stepwise
from servogen.steps import contour, governor, two_stage
from servogen.steps.check import titles, titles_of
from servogen.steps.counted import budgets, emit_counted
from servogen.steps.prepare import prepare
from servogen.steps.servo_drive import ServoSystem
from servogen.steps.servo_run import ServoSimulation, simulate
from servogen.steps.servo_study import ServoStudy
from servogen.steps.system import Findings
from servogen.systems import servo_drive
from servogen.systems.servo_charts import whole_study
from servogen.wcet.targets import load_target

pytestmark = pytest.mark.xdist_group("servo_drive")  # the example is prepared once
PID = "headstock_pid"


def packages(own: ServoSystem) -> list[CPackage]:
    """What every check is given, without the counts in the heads."""
    return [emit_package("headstock", own.declarations(p)) for p in (FLOAT32, FLOAT64)]


@pytest.fixture(scope="module")
def run() -> ServoSimulation:
    return simulated()


@pytest.fixture(scope="module")
def studied() -> ServoStudy:
    return compared()


def test_the_project_s_type_chooses_the_system(tmp_path: Path) -> None:
    found = prepare(load_any_project(changed(tmp_path)), Silent())
    assert isinstance(found.system, ServoSystem)
    assert found.precision is FLOAT32
    precise = ('precision = "float32"', 'precision = "float64"')
    project = load_any_project(changed(tmp_path, precise, ("tms320c6678", "tms320vc33")))
    with pytest.raises(InputError, match=r"output.precision is \"float64\""):
        prepare(project, Silent())


def test_the_checks_of_a_system_are_its_own() -> None:
    own = titles_of(example())
    assert list(own)[:2] == ["regions", "tree"]
    assert not set(own) & set(two_stage.PROOFS)
    others = set(two_stage.PROOFS) | set(governor.PROOFS) | set(contour.PROOFS)
    assert set(titles()) == set(own) | others


def test_the_form_chosen_is_within_the_bounds_that_were_set() -> None:
    figures = example().figures
    forms = figures["forms"]
    assert isinstance(forms, list)
    chosen = next(form for form in forms if form["name"] == figures["lookup"])
    assert chosen["multiply_adds"] <= 40
    assert chosen["comparisons"] <= 12
    assert {form["laws"] for form in forms if form["name"].startswith("law tree")} == {11}
    json_text(figures)


def test_a_pid_that_replaces_the_mpc_has_budgets_of_its_own() -> None:
    package, counts = emit_counted("headstock", example().declarations(FLOAT32))
    found = budgets(package, counts, load_target("generic"), 0.2)
    told = {budget.label: set(budget.calls) for budget in found}
    assert told == {
        "0.5 ms": {"headstock_mpc_step"},
        f"0.5 ms with {PID}": {f"{PID}_step", f"{PID}_filter_step"},
        f"0.0625 ms with {PID}": {f"{PID}_filter_step"},
    }
    assert found[1].calls[f"{PID}_filter_step"] == 8
    assert found[0].budget_cycles == found[1].budget_cycles


def test_on_its_reference_the_mpc_is_judged_and_the_pid_reported(run: ServoSimulation) -> None:
    assert run.passed
    assert [(row.controller, row.task) for row in run.rows] == [
        ("MPC", "reference"),
        ("MPC", "pull on the load"),
        ("PID", "reference"),
        ("PID", "pull on the load"),
    ]
    mpc, pulled, pid, _ = run.rows
    assert mpc.largest_error_deg < 0.2 < pid.largest_error_deg
    assert pulled.largest_current_ma == 1000.0
    assert pulled.last_error_deg < 0.005
    enforced = {(row.controller, b.name): b.enforced for row in run.rows for b in row.bounds}
    assert enforced["MPC", "tracking error"]
    assert not enforced["PID", "tracking error"]
    data = json.loads(json_text(run.to_json()))
    assert data["schema"] == "servogen.simulate_servo/1"
    assert data["runs"][0]["largest_error_deg"] == mpc.largest_error_deg
    assert "largest error 0.14" in run.lines()[0]


def test_a_tracking_error_beyond_its_limit_fails(tmp_path: Path) -> None:
    own = system(tmp_path, ("error_limit_deg = 0.2", "error_limit_deg = 0.1"), ("270.0", "9.0"))
    found = simulate(own.servo, own.parts, None, Silent())
    assert not found.passed
    assert len(found.faults) == 1
    assert "tracking error at 500 us reached 0.1" in found.faults[0]
    assert any(line.endswith(found.faults[0]) for line in found.lines())


class Deaf:
    """A controller that gives no current and finds every input out of range."""

    def __init__(self, declaration: object) -> None:
        self.declaration = declaration

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        status = Status.OK if operation == "filter_step" else Status.OUT_OF_RANGE
        return status, {"current": 0.0, "wanted": 0.0}


def test_closed_loops_end_where_they_are_told_and_say_how() -> None:
    for loop in example().loops(FLOAT64):
        told: list[int] = []
        reference = Stepwise(loop.reference())
        end = loop.run(reference, 30, lambda told=told: told.append(1))
        assert (end.periods, end.complete, end.kept) == (30, False, True)
        assert len(told) == 30
        deaf = loop.run(Deaf(reference.declaration), 30, lambda: None)
        assert not deaf.kept


def test_the_tables_of_the_study_and_their_text(studied: ServoStudy) -> None:
    assert studied.passed
    data = json.loads(json_text(studied.to_json()))
    slow, fast = data["tables"]
    assert slow["first_order"][0] is None
    assert slow["first_order"][7] == pytest.approx(0.0159, rel=0.02)
    assert fast["zero_order"][7] == pytest.approx(0.505, rel=0.02)
    assert fast["pid"] == pytest.approx(0.825, rel=0.02)
    assert data["printed"] == {"mpc_deg": 0.0643, "pid_deg": 0.5021}
    assert all(data["statements"].values())
    assert data["disturbance"]["laws_met"] >= 3
    text = "\n".join(studied.lines())
    assert "0.0159" in text
    assert "2762 mA" in text
    assert "unlike the paper" not in text


def test_a_table_that_is_not_finite_fails(studied: ServoStudy) -> None:
    table = studied.found.tables[0]
    lost = table.first_order.copy()
    lost[3] = np.nan
    bad = replace(studied.found, tables=(replace(table, first_order=lost),))
    assert not ServoStudy(bad).passed
    assert "FAILED" in "\n".join(ServoStudy(bad).lines())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("prediction_horizon = 50", "prediction_horizon = 5"), "prediction"),
        (("weight_change = 1.0", "weight_change = [1, 2, 3]"), "weight_change"),
    ],
)
def test_a_comparison_that_cannot_be_made_says_why(tmp_path: Path, change, told: str) -> None:
    own = system(tmp_path, change)
    found = ServoStudy(whole_study(own.servo, Silent()))
    assert found.passed
    assert told in found.found.absent
    assert told in found.lines()[0]
    assert found.found.disturbance is not None
    json_text(found.to_json())


LIMITED = (
    ("turn_deg = 360", "turn_deg = 0"),
    ("position_range_deg = 36000.0", "position_range_deg = 400.0"),
    ("current_limit_ma = 1000.0", "current_limit_ma = 1000.0\ncurrent_step_limit_ma = 400.0"),
)


def test_too_many_regions_are_refused_in_one_sentence(tmp_path: Path) -> None:
    table = (
        "[controller.estimator]",
        "[controller.lookup]\nmax_regions = 20\n[controller.estimator]",
    )
    with pytest.raises(InputError) as caught:
        system(tmp_path, *LIMITED, table)
    assert "controller.lookup.max_regions is 20, expected room for more than 20" in str(
        caught.value
    )
    assert "control_horizon" in str(caught.value)


def test_a_box_with_more_patterns_than_regions_allowed_is_looked_up_by_clips(
    tmp_path: Path,
) -> None:
    table = (
        "[controller.estimator]",
        "[controller.lookup]\nmax_regions = 5\n[controller.estimator]",
    )
    own = system(tmp_path, table)
    assert own.choice.chosen.name == "recursive clips"
    regions, tree = own.proofs
    assert regions.absent
    claims = tree.prove(packages(own), Silent())
    assert any("tables are those of the proved clips" in claim.name for claim in claims)
    assert any(claim.kind == "sample" for claim in claims)
    assert all(claim.holds for claim in claims)


def test_one_input_ahead_is_a_clipped_law(tmp_path: Path) -> None:
    own = system(
        tmp_path,
        ("control_horizon = 3", "control_horizon = 1"),
        ("trajectory_horizon = 3", "trajectory_horizon = 1"),
        ('"first_order"', '"zero_order"'),
    )
    tree = own.choice.chosen.tree
    assert tree is not None
    assert tree.nodes == 1
    claims = [claim for proof in own.proofs for claim in proof.prove(packages(own), Silent())]
    assert [claim.name for claim in claims if not claim.holds] == []
    assert "Search tree" not in own.page(Findings(simulated(), {"passed": True}))


@pytest.mark.parametrize(
    "error",
    [
        SetError("constraints", None, "a linear program that solves"),
        ExplicitError("active set", "not found", "rows that its numbers tell apart"),
    ],
)
def test_numbers_that_settle_nothing_are_the_user_s_to_know(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def given_out(*_: object) -> None:
        raise error

    monkeypatch.setattr(servo_drive, "choose", given_out)
    with pytest.raises(InputError, match=r"controller.mpc is a program whose regions"):
        system(tmp_path)
