"""The contour controller on the line: what its steps find, refuse and say."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from contour_example import (
    CIRCLE,
    DRAWN,
    EXAMPLE,
    OUTPUT,
    SPACE,
    TABLE,
    compared,
    contour_system,
    simulated,
    small_system,
)

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.design import Status
from servogen.emit.package import emit_package
from servogen.errors import InputError
from servogen.jsontext import json_text
from servogen.precision import FLOAT32, FLOAT64
from servogen.progress import Silent
from servogen.project.contour_load import load_contour_project
from servogen.sil.harness import Stepwise
from servogen.steps.check import titles, titles_of
from servogen.steps.contour import ContourSystem
from servogen.steps.contour_study import QUICK, ContourStudyResult, by_c
from servogen.steps.prepare import prepare
from servogen.systems.contour_loop import run_contour
from servogen.systems.contour_proofs import contour_claims
from servogen.systems.contour_study import (
    ENCODER,
    FILTER_LEAD,
    HELD,
    PLAIN,
    PLAIN_ALL,
    PREVIEWED,
    PROJECT,
    Course,
)

# One worker: the example is compared once.
pytestmark = pytest.mark.xdist_group("contour example")


def test_the_project_s_type_chooses_the_system() -> None:
    found = prepare(small_system().project, Silent())
    assert isinstance(found.system, ContourSystem)
    assert found.precision is FLOAT32
    own = titles_of(found.system)
    assert "contour_stability" in own
    assert "terminal" not in own
    assert set(own) < set(titles())


def test_the_closed_loop_starts_goes_round_and_stops() -> None:
    """From rest, by the encoders' counts of 0.8 um, to rest: case IV of the paper's table."""
    done, task = simulated(), small_system().machine.task
    assert done.passed, done.faults
    assert done.row.samples == task.samples == len(done.run.output)
    # the facts: 11.15 and 0.60 um of one turn with the whole state known, 2 and 9 % for an encoder
    assert done.row.tracking_rms_m == pytest.approx(11.15e-6, rel=0.02)
    assert done.row.contour_rms_m == pytest.approx(0.60e-6, rel=0.09)
    assert 0.01e-6 < done.row.stop_m < 0.8e-6  # what is less than a count is not seen
    assert done.row.start_m < 1.5e-6
    still = done.run.output[task.end + 100 :]
    assert np.max(np.ptp(still, axis=0)) < 0.1e-6
    assert np.all(done.run.status == Status.OK)


def test_a_closed_loop_is_judged() -> None:
    done = simulated()
    tight = replace(done, limit_m=1e-6)
    assert [f.split(" um,")[0] for f in tight.faults] == [
        f"contour error {1e6 * done.row.contour_max_m:.3g}"
    ]
    cut = replace(done, row=replace(done.row, limited=3, refused=2))
    assert len(cut.faults) == 2
    assert cut.lines()[-1].endswith("FAILED: inputs were refused in 2 samples")
    assert json.loads(json_text(done.to_json()))["contour_max_m"] == done.row.contour_max_m


def test_compiled_c_runs_as_the_reference_does() -> None:
    system = small_system()
    package = emit_package("centre", system.declarations(FLOAT32))
    done = system.simulate(package, Silent())
    assert done.inside == "compiled C"
    np.testing.assert_array_equal(done.run.command, simulated().run.command)


def test_the_quick_build_of_a_study_runs_as_the_reference_does() -> None:
    system, task = small_system(), small_system().machine.task
    with by_c(system.design) as controller:
        run = run_contour(
            system.design, controller, system.machine.axes, task.motion, 300,
            system.machine.encoder_m, task.moving,
        )  # fmt: skip
    np.testing.assert_array_equal(run.command, simulated().run.command[:300])
    assert "-O0" in QUICK


def test_a_loop_of_the_harness_is_the_same_loop() -> None:
    system = small_system()
    loop = system.loops(FLOAT32)[0]
    seen: list[int] = []
    ended = loop.run(Stepwise(loop.reference()), 20, lambda: seen.append(1))
    assert (ended.periods, ended.complete, len(seen)) == (20, False, 20)
    assert ended.kept


def test_case_iv_has_its_theorem_and_the_emitted_numbers_keep_it() -> None:
    for precision in (FLOAT32, FLOAT64):
        claims = contour_claims(small_system().in_precision(precision))
        assert len(claims) == 7
        assert all(claim.holds for claim in claims)
    assert small_system().notes == ()
    tables = small_system().design.axes[0].tables
    broken = replace(tables, first=-tables.first)
    axes = (replace(small_system().design.axes[0], tables=broken), small_system().design.axes[1])
    names = [
        c.name for c in contour_claims(replace(small_system().design, axes=axes)) if not c.holds
    ]
    assert names == [
        "the same by the emitted numbers",
        "emitted numbers have the recursion's largest modulus",
    ]


def test_an_end_weight_without_guarantee_is_told_of_by_its_angle() -> None:
    system = contour_system(OUTPUT, ("preview = 10 ", "preview = 1 "))
    assert len(system.notes) == 1
    assert "near the unit circle on a straight contour at" in system.notes[0]
    assert "degrees: modulus 0.99957" in system.notes[0]
    claims = contour_claims(system.design)
    assert not any("H at the end" in claim.name for claim in claims)
    assert contour_system(OUTPUT).notes == ()


def test_weights_and_points_that_a_precision_does_not_carry_are_one_sentence() -> None:
    heavy = ("tracking_weight = 0.25", "tracking_weight = 1e-5")
    with pytest.raises(
        InputError, match=r"controller\.contour\.contour_weight is 15.0, .*; float64"
    ):
        contour_system(heavy)
    assert contour_system(heavy, TABLE).design.table is not None  # solved for at design time
    slow = ("feed_m_per_s = 0.05  ", "feed_m_per_s = 0.0002  ")
    with pytest.raises(InputError, match=r"output\.precision is .*float32.*points apart"):
        contour_system(slow)


def test_an_unstable_loop_is_the_cause_that_is_told() -> None:
    own, done = small_system(), simulated()
    bad = replace(done, limit_m=1e-9)
    assert len(bad.faults) == 1
    told = replace(bad, unstable="the closed loop is outside").faults
    assert told[1] == "the likely cause, controller.contour: the closed loop is outside"
    assert replace(done, unstable="the closed loop is outside").faults == []
    heavy = own.simulate(None, Silent())
    assert heavy.unstable == ""


def test_the_manifest_tells_a_caller_of_follow_what_its_hidden_states_are() -> None:
    """Of a state that follows the contour, they are what leaves the position where it is due."""
    own = small_system()
    files = emit_package("m", own.declarations(FLOAT64)).files
    maps = json.loads(files["manifest.json"])["controllers"][0]["maps"]
    assert list(maps) == ["hidden_x", "hidden_y"]
    for axis, told in zip(own.design.axes, maps.values(), strict=True):
        x = np.linspace(1e-6, 2e-6, axis.model.order)
        hidden = np.array(told["values"]) @ x
        whole = np.concatenate([[axis.model.plant.c @ x], hidden])
        np.testing.assert_allclose(axis.model.to_state @ whole, x, rtol=1e-9, atol=1e-18)


def test_gains_per_angle_are_a_form_of_the_project() -> None:
    system = contour_system(TABLE)
    assert system.design.table is not None
    assert system.design.table.entries == 64
    done = system.simulate(None, Silent())
    assert done.passed, done.faults
    assert done.row.contour_rms_m < 0.6e-6
    assert all(claim.holds for claim in contour_claims(system.design))
    assert system.figures["directions_tabulated"] == 64


def test_a_part_program_with_a_corner_is_followed_to_its_end() -> None:
    system = contour_system((CIRCLE, DRAWN))
    points = system.machine.task.motion.points
    feed = np.linalg.norm(np.diff(points, axis=0), axis=1) / 0.0005
    # in the arc's middle it brakes towards its end; its pieces do not slow it down
    arc = feed[np.argmin(np.abs(points - (0.5e-3 + 0.5e-3 * 0.5**0.5)).sum(axis=1))]
    assert arc == pytest.approx(np.sqrt(2.0 * np.pi / 8.0 * 1e-3), rel=0.05)
    done = system.simulate(None, Silent())
    assert done.passed, done.faults
    assert done.run.output[-1] == pytest.approx((0.5e-3, 1e-3), abs=0.8e-6)
    assert done.row.samples - system.machine.task.end == 200


def test_three_axes_trace_a_helix() -> None:
    system = contour_system(SPACE, (CIRCLE, f"{CIRCLE}rise_m = 0.0005\n"))
    assert [d.prefix for d in system.declarations(FLOAT32)] == ["centre"]
    assert system.machine.task.motion.points[-1] == pytest.approx((1e-3, 0.0, 1e-3), abs=1e-9)
    done = system.simulate(None, Silent())
    assert done.passed, done.faults
    assert done.run.command.shape[1] == 3
    assert done.row.contour_rms_m < 1e-6


def test_a_butterfly_of_a_turn_is_reached_and_left_at_rest() -> None:
    curve = '[contour]\nkind = "butterfly"\nsize_m = 0.0005\nfeed_m_per_s = 0.05\n'
    task = contour_system((CIRCLE, curve)).machine.task
    size = np.linalg.norm(task.motion.points, axis=1).max()
    assert size == pytest.approx(0.0005, rel=1e-3)
    step = np.linalg.norm(np.diff(task.motion.points, axis=0), axis=1)
    counted = step[task.first : task.last - 1]
    assert counted.max() < 25e-6 * (1.0 + 1e-6)  # chords, shorter where it bends
    assert np.median(counted) == pytest.approx(25e-6, rel=0.02)
    assert step[:3].max() < 2e-6
    assert np.all(step[task.end :] == 0.0)


def test_the_paper_s_table_and_sweeps_come_out() -> None:
    """On the project's circle, whole state known: facts of the table to 2 %."""
    found = compared().found
    assert found.scale == pytest.approx(1.0, abs=1e-9)
    table = {"I": (1.87, 1.27), "II": (16.18, 0.34), "III": (3.38, 2.90), "IV": (11.15, 0.60)}
    for name, expected in table.items():
        row = next(r for r in found.rows if r.name.startswith(f"case {name}:"))
        errors = (1e6 * row.tracking_rms_m, 1e6 * row.contour_rms_m)
        assert errors == pytest.approx(expected, rel=0.02)
    previews, _, weights, _ = found.sweeps
    tracking = [1e6 * row.tracking_rms_m for row in previews.rows]
    assert tracking == pytest.approx([949.0, 26.0, 3.0], rel=0.02)
    contour = [1e6 * row.contour_rms_m for row in weights.rows]
    assert contour == pytest.approx([5.86, 1.19, 0.34], rel=0.02)


def test_the_filters_have_settled_before_a_run_by_encoders_counts() -> None:
    """Slow drives under heavy weights: the start at the feed takes more than the commands have."""
    project = load_contour_project(EXAMPLE.with_name("lagging.toml"))
    system = prepare(project, Silent()).system
    assert isinstance(system, ContourSystem)
    with Silent().task("") as task:
        course = Course(system.machine, by_c, task, FILTER_LEAD)
        row = course.run(ENCODER, system.design, encoders=True)
    assert row.limited == 0
    assert max(row.command_share) < 0.2
    assert row.contour_rms_m == pytest.approx(0.16e-6, rel=0.1)


def test_a_contour_near_the_velocity_of_an_axis_is_told() -> None:
    assert small_system().notes == ()
    system = contour_system(("command_limit = 20.0 ", "command_limit = 2.6 "))
    (note,) = system.notes
    assert note.startswith("machine.x.command_limit: the contour asks x for 85% of the velocity")


def test_contour_weight_shows_in_trouble() -> None:
    """An axis that stands still is waited for; drives with too little are not outrun."""
    still, still_plain, weak, weak_plain = compared().found.troubles
    assert still.name == f"x stands still for 15 ms: {PROJECT}"
    assert weak_plain.name == f"drives give 90% of the velocity needed: {PLAIN_ALL}"
    assert still.contour_max_m < 0.6 * still_plain.contour_max_m
    assert still.tracking_max_m > 15e-3 * 0.05  # 15 ms at the feed
    assert 3.0 * weak.contour_rms_m < weak_plain.contour_rms_m
    assert len(json.loads(json_text(compared().to_json()))["troubles"]) == 4


def test_the_baseline_is_case_iii() -> None:
    """Both without a contour error, H_s at the end and the same weights; standing still is not."""
    found = compared().found
    third = next(r for r in found.rows if r.name.startswith("case III"))
    baseline, held = found.row(PREVIEWED), found.row(HELD)
    assert baseline
    assert held
    assert baseline.tracking_rms_m == pytest.approx(third.tracking_rms_m, rel=1e-6)
    assert baseline.contour_rms_m == pytest.approx(third.contour_rms_m, rel=1e-6)
    assert held.tracking_rms_m > 1.05 * third.tracking_rms_m


def test_a_study_says_what_failed() -> None:
    done = compared()
    assert done.passed, done.faults
    rows = {row.name: row for row in done.found.rows}
    assert {f"{PROJECT}, float32", f"{PROJECT}, float64", ENCODER, PLAIN} < set(rows)
    single = rows[f"{PROJECT}, float32"]
    worse = replace(single, contour_rms_m=single.contour_rms_m + 0.02e-6)
    changed = tuple(worse if row is single else row for row in done.found.rows)
    failed = ContourStudyResult(replace(done.found, rows=changed))
    assert failed.faults == ["float32 changes the contour error by 0.02 um RMS"]
    stable = done.found.spectra[1]
    wild = replace(stable, modulus=stable.modulus + 0.2)
    failed = ContourStudyResult(replace(done.found, spectra=(done.found.spectra[0], wild)))
    assert "H_s(Q_max)" in failed.faults[0]
    told = json.loads(json_text(done.to_json()))
    assert [len(sweep["rows"]) for sweep in told["sweeps"]] == [3, 2, 3, 3]
    assert len(done.lines()) == 2 + len(rows) + 2 * 3 + 4 * 4 + 2


def test_the_reference_is_the_emitted_controller_s() -> None:
    design = small_system().design
    assert ContourLq(design).declaration.prefix == "centre"
    assert [s.name for s in small_system().scenarios(FLOAT32, 1, 5)] == [
        "centre: edges",
        "centre: arriving",
        "centre: random",
    ]
