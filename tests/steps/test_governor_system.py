"""The command governor on the line: what its steps find, refuse and say."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from governor_example import SVG, compared, simulated, small_project, small_system

from servogen.controllers.design import Status, Value
from servogen.errors import CheckFailed, InputError
from servogen.jsontext import json_text
from servogen.plants.statespace import StateSpace
from servogen.precision import FLOAT32, FLOAT64
from servogen.progress import Silent
from servogen.sets.errors import SetError
from servogen.sil.harness import Stepwise
from servogen.steps.check import titles, titles_of
from servogen.steps.count import count
from servogen.steps.governor import GovernorSystem, prepare_governor
from servogen.steps.governor_run import BACKUP_SHARE
from servogen.steps.governor_study import GovernorStudyResult
from servogen.steps.prepare import prepare
from servogen.systems.command_governor_faults import part_fault
from servogen.systems.command_governor_study import CASCADES, EXTENDED, LOW_PASS, PATH, REFERENCES
from servogen.systems.command_governor_sweeps import Trial, sweeps

# One worker: the small machine is compared once.
pytestmark = pytest.mark.xdist_group("governor example")


def test_the_project_s_type_chooses_the_system(tmp_path: Path) -> None:
    found = prepare(small_project(tmp_path, ('"float64"', '"float32"')), Silent())
    assert isinstance(found.system, GovernorSystem)
    assert found.precision is FLOAT32
    unknown = small_project(tmp_path, ('"tms320c6678"', '"abacus"'))
    with pytest.raises(InputError, match=r"target\.name is abacus"):
        prepare(unknown, Silent())


def test_the_checks_of_a_system_are_its_own() -> None:
    own = titles_of(small_system())
    assert "extended_sets" in own
    assert "terminal" not in own
    assert set(own) < set(titles())


def test_alike_axes_are_one_in_the_design_and_others_are_two(tmp_path: Path) -> None:
    names = [d.prefix for d in small_system().declarations(FLOAT64)]
    assert names == ["etcher_axis", "etcher"]
    own = '[machine.y.slow]\nmodel = "servo"\nbandwidth_rad_per_s = 30\ndamping = 0.9\n'
    own += "position_limit_m = [0, 0.2]\nvelocity_limit_m_per_s = 0.12\n"
    own += "acceleration_limit_m_per_s2 = 8\n[machine.y.fast]\nrange_m = 0.02\n"
    own += "velocity_limit_m_per_s = 0.8\nacceleration_limit_m_per_s2 = 200\n"
    system = prepare_governor(
        small_project(tmp_path, ('[machine.y]\nsame_as = "x"\n', own)), Silent()
    )
    assert not system.machine.alike
    names = [d.prefix for d in system.declarations(FLOAT64)]
    assert names == ["etcher_x", "etcher_y", "etcher"]
    done = system.simulate(None, Silent())
    assert done.passed
    assert len(system.proofs[0].prove((), Silent())) == 4


def test_axes_of_different_order_are_refused(tmp_path: Path) -> None:
    own = '[machine.y.slow]\nmodel = "transfer_function"\nnumerator = [160000]\n'
    own += "denominator = [1, 80, 2400, 32000, 160000]\nposition_limit_m = [0, 0.25]\n"
    own += "velocity_limit_m_per_s = 0.1\nacceleration_limit_m_per_s2 = 10\n"
    own += "[machine.y.fast]\nrange_m = 0.025\nvelocity_limit_m_per_s = 0.8\n"
    own += "acceleration_limit_m_per_s2 = 200\n"
    project = small_project(tmp_path, ('[machine.y]\nsame_as = "x"\n', own))
    with pytest.raises(InputError, match=r"machine\.y\.slow is .*of order 4.*, expected the order"):
        prepare_governor(project, Silent())


def test_the_whole_path_is_machined_within_its_limits() -> None:
    found = simulated()
    assert found.passed
    row = found.row
    assert row.complete
    assert row.ideal_s < row.time_s < 4.0 * row.ideal_s
    assert 0.99 < 1.0 + row.instants.velocity <= 1.0 + 1e-9
    assert row.between.velocity > row.instants.velocity
    data = json.loads(json_text(found.to_json()))
    assert data["schema"] == "servogen.simulate_governor/1"
    assert data["points"] == len(small_system().machine.points) - 1
    assert data["excess_at_instants"]["stroke"] <= 0.0
    assert "Python reference inside" in found.lines()[0]
    assert not any("FAILED" in line for line in found.lines())


def test_what_is_broken_fails_and_is_told() -> None:
    found = simulated()
    over = replace(found.row, instants=replace(found.row.instants, stroke=0.02))
    told = replace(found, row=over).faults
    assert told == ["stroke over its limit by 0.02 of it at an instant it is kept"]
    many = replace(found.row, backups=found.row.periods)
    assert f"at most {BACKUP_SHARE:.0%}" in replace(found, row=many).lines()[-1]
    lost = replace(found.row, complete=False, infeasible=3)
    assert len(replace(found, row=lost).faults) == 2
    assert replace(over, promised=False).passed


def test_backups_are_counted_and_too_many_are_a_failed_check(tmp_path: Path) -> None:
    """Few iterations, even one: still within every limit and finished, but not what was asked."""
    pattern = ('"minimal_motion"', '"pattern"')
    few = small_project(tmp_path, ("iteration_cap = 150", "iteration_cap = 7"), pattern)
    system = prepare_governor(few, Silent())
    found = system.simulate(None, Silent())
    assert found.row.backups > 0
    assert not found.passed
    assert found.row.faults == []
    one = GovernorSystem(replace(system.machine, cap=1))
    least = one.simulate(None, Silent())
    assert least.row.complete
    assert least.row.backups > found.row.backups
    assert least.row.faults == []


def test_the_comparison_has_every_controller_on_both_references() -> None:
    found = compared()
    assert found.passed
    names = [row.name for row in found.found.rows]
    assert names == [
        *(f"{own}, {told}" for own in (EXTENDED, PATH, *CASCADES) for told in REFERENCES.values()),
        f"{LOW_PASS}, 2 Hz", f"{LOW_PASS}, 0.5 Hz",
    ]  # fmt: skip
    rows = dict(zip(names, found.found.rows, strict=True))
    own = rows[f"{EXTENDED}, minimal motion"]
    assert own == replace(simulated().row, name=own.name)
    quiet, quick = own, rows[f"{EXTENDED}, pattern"]
    assert sum(quiet.motion.distance_m) < sum(quick.motion.distance_m)
    assert rows[f"{LOW_PASS}, 2 Hz"].time_s > 2.0 * own.time_s
    for told in REFERENCES.values():
        alone, planned = (rows[f"{name}, {told}"] for name in CASCADES)
        assert planned.iterations[0] > 0.0 == alone.iterations[0]
        for row in (alone, planned):
            assert row.complete
            assert max(row.instants.velocity, row.instants.stroke) <= 1e-9
    data = json.loads(json_text(found.to_json()))
    assert data["rows"][9]["time_s"] == rows[f"{LOW_PASS}, 0.5 Hz"].time_s
    assert data["velocity_bound_s"] <= own.time_s
    told_rows = [line for line in found.lines() if any(name in line for name in names)]
    assert len(told_rows) == 10
    settings = sum(len(sweep["trials"]) for sweep in data["sweeps"])
    assert len(found.lines()) == 3 + 10 + 4 + settings


def test_a_broken_promise_fails_the_comparison_and_a_rival_s_does_not() -> None:
    found = compared().found
    broken = tuple(replace(row, instants=replace(row.instants, velocity=0.1)) for row in found.rows)
    failed = GovernorStudyResult(replace(found, rows=broken, sweeps=()))
    assert not failed.passed
    assert [fault.split(":")[0] for fault in failed.faults] == [row.name for row in broken[:2]]
    assert "FAILED" in failed.lines()[-1]


def test_what_was_never_active_and_what_is_beyond_its_limit_is_said() -> None:
    done = simulated()
    between = replace(done.row.between, velocity=0.0268, stroke=-0.01)
    lines = replace(done, row=replace(done.row, iterations=(0.0, 0), between=between)).lines()
    assert "no constraint was ever active" in lines[-1]
    assert "2.68 % beyond its limit at a fast sample" in lines[3]
    assert ", 99 % at a fast sample" in lines[5]
    assert not any("never active" in line for line in done.lines())


def test_reserves_that_leave_no_tube_are_not_tried() -> None:
    machine = small_system().machine
    own = machine.project.controller
    governor = own.governor.model_copy(update={"stroke_margin_m": 0.0225})
    controller = own.model_copy(update={"governor": governor})
    tight = replace(machine, project=replace(machine.project, controller=controller))
    tried = [[s.label for s in sweeps(m)[2][2]] for m in (machine, tight)]
    assert tried == [["1 mm", "2 mm", "4 mm", "8 mm"], ["1 mm", "2 mm"]]


def test_strokes_that_differ_are_told_in_shares() -> None:
    row = replace(simulated().row, between=replace(simulated().row.between, stroke=0.01))
    assert Trial("a", 0.025, (row,)).over_stroke(row) == "+0.250 mm"
    assert Trial("a", None, (row,)).over_stroke(row) == "+1.00 %"


def test_the_sets_are_proved() -> None:
    (proof,) = small_system().proofs
    claims = proof.prove((), Silent())
    assert [claim.name for claim in claims] == [
        "x: P-tilde is invariant", "x: P-tilde keeps every limit",
    ]  # fmt: skip
    assert all(claim.holds and claim.cases > 5 for claim in claims)


def test_closed_loops_end_where_they_are_told_and_say_how() -> None:
    (loop,) = small_system().loops(FLOAT64)
    told: list[int] = []
    end = loop.run(Stepwise(loop.reference()), 10, lambda: told.append(1))
    assert (end.periods, end.complete, end.kept, len(told)) == (10, False, True, 10)
    (single,) = small_system().loops(FLOAT32)
    end = single.run(Stepwise(single.reference()), None, lambda: None)
    assert (end.complete, end.kept) == (True, True)

    class Wild(Stepwise):
        def call(
            self, operation: str, inputs: Mapping[str, Value] | None = None
        ) -> tuple[Status, dict[str, Value]]:
            status, out = super().call(operation, inputs)
            return status, {k: v + 0.02 if "command" in k else v for k, v in out.items()}

    assert not loop.run(Wild(loop.reference()), 10, lambda: None).kept

    class Still(Stepwise):
        def call(
            self, operation: str, inputs: Mapping[str, Value] | None = None
        ) -> tuple[Status, dict[str, Value]]:
            status, out = super().call(operation, inputs)
            return status, {**out, "points_taken": 0}

    with pytest.raises(CheckFailed, match=r"float64 stalled: after \d+ slow periods only 0 of"):
        loop.run(Still(loop.reference()), None, lambda: None)


def test_every_controller_is_tried_at_its_edges() -> None:
    found = list(small_system().scenarios(FLOAT32, 1, 40))
    assert [scenario.name for scenario in found] == [
        "etcher_axis: edges", "etcher_axis: random", "etcher_axis: at the cap", "etcher: edges",
        "etcher: random",
    ]  # fmt: skip
    for scenario in found:
        reference = scenario.reference()
        assert scenario.name.split(":")[0] == reference.declaration.prefix
        assert len(scenario.calls) > 10
        ended = {reference.call(call.operation, call.inputs)[0] for call in scenario.calls}
        assert {Status.OK, Status.NOT_FINITE, Status.OUT_OF_RANGE} & ended, scenario.name
    again = list(small_system().scenarios(FLOAT32, 1, 40))
    assert [len(scenario.calls) for scenario in again] == [len(s.calls) for s in found]


def test_the_target_decides_the_cap(tmp_path: Path) -> None:
    target = ("iteration_cap = 150    ", 'iteration_cap = "target"')
    half = prepare(small_project(tmp_path, target), Silent())
    fit = count(half, None).fit
    (budget,) = fit.budgets
    assert (budget.label, set(budget.calls)) == ("35.6 ms", {"etcher_predict", "etcher_step"})
    assert budget.fits
    assert budget.largest_cap == half.system.figures["iteration_cap"] == half.system.machine.cap
    assert budget.total_cycles + budget.cycles_per_iteration > budget.budget_cycles
    none = small_project(tmp_path, target, ("share = 0.5", "share = 0.001"))
    with pytest.raises(
        CheckFailed,
        match=r"not one iteration fits the target: .* over budget.* larger target\.share",
    ):
        prepare(none, Silent())


def test_a_target_without_room_for_a_plan_to_get_on_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("servogen.steps.governor.allowed_cap", lambda *_: 2)
    tight = small_project(tmp_path, ("iteration_cap = 150    ", 'iteration_cap = "target"'))
    with pytest.raises(
        CheckFailed, match=r"room for \d of the \d iterations.* larger target\.share, fewer"
    ):
        prepare_governor(tight, Silent())


def test_the_points_ahead_are_those_of_the_file(tmp_path: Path) -> None:
    assert small_system().figures["points_ahead"] == 300
    everything = ("points_ahead = 300  ", 'points_ahead = "all"')
    system = prepare_governor(small_project(tmp_path, everything), Silent())
    assert system.figures["points_ahead"] == 9 * 50 + 1
    done = system.simulate(None, Silent())
    assert done.row.complete
    assert done.row.time_s <= simulated().row.time_s


def test_weights_that_float32_cannot_do_with_are_noted(tmp_path: Path) -> None:
    single = ('"float64"', '"float32"')
    (note,) = prepare_governor(small_project(tmp_path, single), Silent()).notes
    assert note.startswith("controller.governor.weight_reference = 0.01 is small for float32")
    large = ("weight_reference = 0.01", "weight_reference = 10.0")
    assert prepare_governor(small_project(tmp_path, single, large), Silent()).notes == ()
    assert small_system().notes == ()


def test_more_points_ahead_than_a_plan_can_use_and_an_axis_in_millimetres_are_noted() -> None:
    machine = small_system().machine
    own = machine.project
    governor = own.controller.governor.model_copy(update={"points_ahead": 452})
    controller = own.controller.model_copy(update={"governor": governor})
    x = own.machine.x.slow.model_copy(update={"position_limit_m": (0.0, 250.0)})
    axis = own.machine.x.model_copy(update={"slow": x})
    axes = own.machine.model_copy(update={"x": axis, "y": axis})
    project = replace(own, controller=controller, machine=axes)
    assert GovernorSystem(replace(machine, project=project)).notes == (
        "controller.governor.points_ahead = 452 is more than a plan can use: it is given 451, "
        "(horizon + 1) M + 1",
        "machine.x.slow.position_limit_m spans 250 m: lengths are in metres",
    )


@pytest.mark.parametrize("key", ["tightening", "horizon"])
def test_a_slow_pole_is_what_its_own_set_fails_by(key: str) -> None:
    machine = small_system().machine
    error = SetError(key, 0.005, "one with which 300 instants determine the set")
    slow = StateSpace(machine.slow[0].a * 0.05, machine.slow[0].b, machine.slow[0].c)
    told = str(part_fault(machine.project, "y", slow, error))
    assert "machine.y.slow.pole_rad_per_s is 20.0, expected a stage that is at rest 3.56 s" in told
    quick = str(part_fault(machine.project, "y", machine.slow[1], error))
    assert "pole" not in quick


def test_a_path_that_cannot_be_followed_is_told_with_its_place() -> None:
    """Of a machine whose drawing was not checked."""
    machine = small_system().machine
    apart = machine.points.copy()
    apart[60:, 0] += 0.06
    timed = replace(machine.timed, points=apart)
    one = replace(small_system(), machine=replace(machine, timed=timed, motion=apart))
    told = r"stalled: UNREACHABLE: both stages stand, and point 60 at \(.* m\), ellipse #one is out"
    with pytest.raises(CheckFailed, match=told):
        one.simulate(None, Silent())


def test_the_figures_of_the_build_are_json() -> None:
    figures = json.loads(json_text(small_system().figures))
    assert figures["axes"]["x"]["variables"] == 9
    assert figures["axes"]["x"]["non_redundant"] < figures["axes"]["x"]["inequalities"]


OUTSIDE = SVG.replace('cx="110" cy="-100"', 'cx="110" cy="-232.5"')
STARTS_OUTSIDE = SVG.replace('cx="40" cy="-60"', 'cx="229.6" cy="-60"')


@pytest.mark.parametrize(
    ("drawing", "reference", "told"),
    [
        (OUTSIDE, "pattern", r"two\.svg: point \d+ at \(0\.\d+ m, 0\.249\d m\), circle #two .*"
         r"a reference 0\.124375 m or less from the middle of y, inside the axis"),
        (STARTS_OUTSIDE, "pattern", r"two\.svg: point 0 at \(0\.2496 m, .*a start 0\.124375 m"),
        (SVG.replace('"110"', '"300"'), "minimal_motion", r"point \d+ at .*middle of x"),
    ],
)  # fmt: skip
def test_a_drawing_that_is_not_admitted_is_refused_at_its_place(
    tmp_path: Path, drawing: str, reference: str, told: str
) -> None:
    choose = ('reference = "minimal_motion"', f'reference = "{reference}"')
    with pytest.raises(InputError, match=told):
        prepare_governor(small_project(tmp_path, choose, drawing=drawing), Silent())


def test_a_pattern_beyond_the_axis_may_have_a_motion_that_is_not(tmp_path: Path) -> None:
    """The fast stage reaches what the slow one may not."""
    system = prepare_governor(small_project(tmp_path, drawing=OUTSIDE), Silent())
    assert system.machine.points[:, 1].max() > 0.25
    assert system.machine.motion[:, 1].max() < 0.249375
    assert system.simulate(None, Silent()).passed


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("stroke_reserve_m = 0.001", "stroke_reserve_m = 1e-6"),
         r"stroke_reserve_m is 1e-06, expected more than 4\.9e-05 m, .* "
         r"controller\.governor\.steady_state_tightening = 0\.005"),
        (("pole_rad_per_s = 20.0", "pole_rad_per_s = 1e-300"),
         r"machine\.x\.slow\.pole_rad_per_s is 1e-300, expected a stage with"),
        (("traverse_feed_m_per_s = 0.8", "traverse_feed_m_per_s = 1e-300"),
         r"path\.feed_m_per_s is such that the path takes inf s, expected feeds"),
        (("tangential_acceleration_m_per_s2 = 100.0", "tangential_acceleration_m_per_s2 = 1e-300"),
         r"the path takes 1\.\d\de\+150 s, expected feeds and units that give at most"),
        (('model = "equal_poles"           ', 'model = "transfer_function"\nnumerator = [1]\n'
          "denominator = [1, 3, -3, 1]  "), r"machine\.x\.slow\."),
        (("acceleration_limit_m_per_s2 = 10.0", "acceleration_limit_m_per_s2 = 1e-12"),
         r"machine\.x\.slow\.acceleration_limit_m_per_s2 is 1e-12, expected a limit with which"),
        (("acceleration_limit_m_per_s2 = 10.0", "acceleration_limit_m_per_s2 = 1e-3"),
         r"acceleration_limit_m_per_s2 is 0\.001, expected .* more than 2\.5e-05 m "
         r".*stroke_reserve_m away, not 1e-05 m; a larger controller\.governor\.weight_reference"),
        (("velocity_limit_m_per_s = 0.1", "velocity_limit_m_per_s = 1e-4"),
         r"machine\.x\.slow\.velocity_limit_m_per_s is 0\.0001, expected a limit with which"),
        (("pole_rad_per_s = 20.0", "pole_rad_per_s = 1e6"),
         r"pole_rad_per_s is 1000000\.0, expected a stage with a sampled dc gain"),
        (("position_limit_m = [0.0, 0.25]", "position_limit_m = [0.0, 250.0]"),
         r"\(0\.0600 m, 0\.0600 m\), ellipse #one \(y upwards, an SVG's own is -y\) is out of .*"
         r"start 124\.375 m or less from the middle of x, by machine\.x\.slow\.position_limit_m "
         r"and controller\.governor\.steady_state_tightening \(machine\.x\.slow\.position_limit_m "
         r"spans 250 m: lengths are in metres\)"),
    ],
)  # fmt: skip
def test_what_a_design_refuses_is_told_with_its_key(
    tmp_path: Path, change: tuple[str, str], told: str
) -> None:
    with pytest.raises(InputError, match=told) as caught:
        prepare_governor(small_project(tmp_path, change), Silent())
    assert "\n" not in str(caught.value)


def test_a_stage_that_settles_within_a_period_is_judged_too(tmp_path: Path) -> None:
    """Nothing of the stroke is left for what a plan's end leaves open."""
    quick = ("pole_rad_per_s = 20.0", "pole_rad_per_s = 50000.0")
    system = prepare_governor(small_project(tmp_path, quick), Silent())
    assert system.design.axes[0].program.settle_m == 0.0


def test_the_margin_keeps_the_stroke_between_the_samples(tmp_path: Path) -> None:
    changes = (
        ("stroke_margin_m = 0.0", "stroke_margin_m = 0.0005"),
        ("sub_step_stroke = false", "sub_step_stroke = true"),
        ('reference = "minimal_motion"', 'reference = "pattern"'),
    )
    done = prepare_governor(small_project(tmp_path, *changes), Silent()).simulate(None, Silent())
    assert done.passed
    assert done.row.instants.stroke <= -0.0005 / 0.025 + 1e-9
    assert done.row.between.stroke <= 0.0
    assert np.isfinite(done.row.between.velocity)
