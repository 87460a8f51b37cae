"""Limits that differ below and above zero, through the line; and which check is whose."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from servo_example import changed, system

from servogen.explicit.lookup import TreeLookup
from servogen.progress import Silent
from servogen.project.systems import load_any_project
from servogen.sil.harness import Stepwise
from servogen.steps.equivalence import LoopCheck, SilResult, equivalence
from servogen.steps.prepare import Prepared, prepare
from servogen.steps.servo_run import simulate
from servogen.steps.system import LoopEnd
from servogen.systems.metrics import Bound

pytestmark = pytest.mark.xdist_group("servo_drive")
SIDES = (
    ("current_limit_ma = 1000.0", "current_limit_ma = [-800, 1200]"),
    ("stroke_deg = 270.0", "start_deg = 3.0\nstroke_deg = 4.0"),
)


@pytest.fixture(scope="module")
def lopsided(tmp_path_factory: pytest.TempPathFactory) -> Prepared:
    """More current one way."""
    return prepare(load_any_project(changed(tmp_path_factory.mktemp("sides"), *SIDES)), Silent())


def test_a_drive_with_more_current_one_way_is_built_proved_and_equal(lopsided: Prepared) -> None:
    own = lopsided.system
    low, high = own.parts.lookup.low, own.parts.lookup.high
    assert (low.tolist(), high.tolist()) == ([-800.0], [1200.0])
    form = own.parts.lookup.form
    assert isinstance(form, TreeLookup)
    assert form.tree.mirror < 0  # none: zero is not in the middle
    assert np.any(form.offsets)
    text = lopsided.package.files["headstock_pid_tables.h"]
    assert "-800" in text
    assert "1200" in text
    found = equivalence(lopsided, 30, Silent())
    assert found.passed, found.lines()


def test_a_drive_with_more_current_one_way_uses_both_sides_of_it(lopsided: Prepared) -> None:
    own = lopsided.system
    found = simulate(own.servo, own.parts, None, Silent())
    assert found.passed, found.faults
    assert {row.largest_current_ma for row in found.rows if "pull" in row.task} == {1200.0}
    for row, run in found.runs:
        assert run.reference[0] == 3.0
        highest, lowest = row.bounds[:2]
        assert (highest.name, highest.limit) == ("highest current", 1200.0)
        assert (lowest.name, lowest.limit, lowest.below) == ("lowest current", -800.0, True)
        assert lowest.worst == float(np.min(run.current)) >= -800.0
    pulls = [row for row in found.rows if "pull" in row.task]
    assert all(row.bounds[1].worst == -800.0 and row.bounds[1].share == 1.0 for row in pulls)


def test_what_falls_below_a_lower_limit_is_told_with_its_key() -> None:
    key = "controller.mpc.current_limit_ma"
    kept = Bound("lowest current", "mA", -799.0, -800.0, "62.5 us", True, below=True, key=key)
    over = replace(kept, worst=-801.0)
    assert (kept.passed, over.passed, over.violation) == (True, False, 1.0)
    assert over.fault == f"lowest current at 62.5 us reached -801 of -800 mA ({key})"
    assert np.isnan(replace(kept, limit=2.0).share)


def test_tracking_is_for_simulate_to_judge_and_agreement_for_sil(tmp_path: Path) -> None:
    tight = ("tracking_error_limit_deg = 0.2", "tracking_error_limit_deg = 0.01")
    prepared = prepare(load_any_project(changed(tmp_path, SIDES[1], tight)), Silent())
    own = prepared.system
    missed = own.simulate(None, Silent())
    assert not missed.passed
    (said,) = missed.faults
    assert said.startswith("MPC, reference: tracking error at 500 us reached 0.1")
    assert said.endswith(" of 0.01 deg (target.tracking_error_limit_deg)")
    loop = own.loops(own.precision)[0]
    ended = loop.run(Stepwise(own.parts.controller()), 60, lambda: None)
    assert ended == LoopEnd(60, False, ())


def test_sil_says_which_limit_a_loop_broke(tmp_path: Path) -> None:
    own = system(tmp_path, SIDES[1])
    loop = own.loops(own.precision)[0]
    broken = LoopCheck("float32", loop, LoopEnd(9, False, ("current reached 2 of 1 mA (k)",)), True)
    found = SilResult([], [broken])
    assert not found.passed
    assert (
        "9 samples, not finished, constraints BROKEN: current reached 2 of 1 mA (k), FAILED"
        in (found.lines()[-1])
    )
    assert json.loads(json.dumps(found.to_json()))["closed_loops"][0]["faults"] == [
        "current reached 2 of 1 mA (k)"
    ]
