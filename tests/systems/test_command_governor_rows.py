"""Rows and rivals of the comparison, against simulations of their own."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.signal

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from governor_example import compared, simulated, small_system

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Status, Value
from servogen.controllers.governor_design import AXES
from servogen.plants.statespace import discretise
from servogen.progress import Silent
from servogen.systems import command_governor_study
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor import GovernorMachine, governor_design, on_reference
from servogen.systems.command_governor_cascade import as_two_stage, cascade_row
from servogen.systems.command_governor_loop import Governor
from servogen.systems.command_governor_rivals import PathGovernor, low_pass_row
from servogen.systems.command_governor_rows import (
    instant_states,
    judge_governed,
    kept_excess,
    slow_motion,
    worst_excess,
)
from servogen.systems.command_governor_study import compare_governors, run_machine
from servogen.systems.command_governor_sweeps import Shortsighted, sweeps

# One worker: the small machine is compared once.
pytestmark = pytest.mark.xdist_group("governor example")


def machine() -> GovernorMachine:
    return small_system().machine


def test_instants_that_are_samples_are_those_of_the_run() -> None:
    """50 fast samples in a period: five instants fall on every tenth of them."""
    run = simulated().run
    found = instant_states(machine().slow, run, 5)
    np.testing.assert_allclose(found, run.slow_fine[::10], rtol=0, atol=1e-12)


def test_instants_between_the_samples_are_the_stage_s_own() -> None:
    """Thirds of a period, against one long simulation of the stage at that rate."""
    run, own = simulated().run, machine()
    found = instant_states(own.slow, run, 3)
    step = discretise(own.slow[0], own.period_s / 3)
    state = run.slow_fine[0, 0].copy()
    for k, command in enumerate(np.repeat(run.command[:, 0], 3)):
        np.testing.assert_allclose(found[k, 0], state, rtol=0, atol=1e-10)
        state = step.a @ state + step.b * command


def test_the_excess_is_that_of_the_worst_axis_and_instant() -> None:
    own = machine()
    states, tool = np.zeros((4, 2, 3)), np.full((4, 2), 0.125)
    states[:, :, 0] = 0.125
    states[2, 1] = [0.2, -0.11, 2.0]
    found = worst_excess(own, states, tool)
    assert found.position == pytest.approx(0.075 / 0.125 - 1.0)
    assert found.velocity == pytest.approx(0.1)
    assert found.acceleration == pytest.approx(-0.8)
    assert found.stroke == pytest.approx(2.0)


def test_the_stroke_is_judged_where_it_is_kept() -> None:
    """A tool that is away at the instants inside a period only."""
    run, own = simulated().run, machine()
    away = run.tool.copy()
    away[16::50] += 1.0
    strayed = replace(run, tool=away)
    assert kept_excess(own, strayed).stroke == kept_excess(own, run).stroke
    governor = own.project.controller.governor.model_copy(update={"sub_step_stroke": True})
    controller = own.project.controller.model_copy(update={"governor": governor})
    everywhere = replace(own, project=replace(own.project, controller=controller))
    assert kept_excess(everywhere, strayed).stroke > 10.0


def test_the_path_governor_takes_the_farthest_point_that_it_may() -> None:
    """Against all candidates, one by one, from states along a run."""
    own = on_reference(machine(), "pattern")
    design = governor_design(own)
    governor = PathGovernor(own, design)
    taken = []

    class Watched:
        declaration = governor.declaration

        def call(self, operation, inputs=None):  # type: ignore[no-untyped-def]
            last, command = governor._last.copy(), governor._command.copy()
            status, out = governor.call(operation, inputs)
            if operation == "step":
                taken.append((out["points_taken"], _farthest(own, inputs, last, command)))
            return status, out

    run = run_machine(own, design, Watched(), 25)
    assert [mine for mine, _ in taken] == [best for _, best in taken]
    assert len({mine for mine, _ in taken}) > 5
    row = judge_governed("path", own, run, promised=False)
    assert max(row.instants.position, row.instants.velocity, row.instants.acceleration) <= 1e-9
    assert row.instants.stroke <= 1e-9


def _farthest(own: GovernorMachine, inputs: dict, last: np.ndarray, command: np.ndarray) -> int:
    names = ("position", "velocity", "acceleration")
    best = 0
    for count in range(1, min(int(inputs["n_points"]), own.ratio) + 1):
        good = True
        for i, axis in enumerate(AXES):
            state = np.array([inputs[f"{axis}_{name}"] for name in names])
            points = np.append(last[i], inputs[f"points_{axis}"][:count])
            rho = inputs[f"slow_{axis}"][count - 1]
            plant = discretise(own.slow[i], own.period_s)
            after = plant.a[0] @ state + plant.b[0] * rho
            good &= own.plain_sets[i].contains(state, np.zeros(0), rho, 1e-12)
            good &= bool(np.all(np.abs(points - state[0]) <= 0.025))
            good &= bool(np.all(np.abs(points - after) <= 0.025))
        best = count if good else best
    return best


def test_the_low_pass_is_what_scipy_says_at_the_feed_it_found() -> None:
    own = machine()
    row = low_pass_row(own, "low pass")
    assert row.complete
    assert not row.promised
    assert max(row.between.position, row.between.velocity, row.between.stroke) <= 0.0
    # one of the limits is what ends it
    assert max(row.between.velocity, row.between.stroke) > -0.05
    taken = (len(own.points) - 1) / row.periods
    ends = np.minimum((np.arange(1, row.periods + 1) * taken).astype(int), len(own.points) - 1)
    keep = np.exp(-2.0 * np.pi * own.project.controller.low_pass.cutoff_hz * own.period_s)
    command, commands = own.points[0, 0], []
    for point in own.points[ends, 0]:
        command = keep * command + (1.0 - keep) * point
        commands.append(command)
    stage = own.slow[0]
    fine = np.repeat(commands, 20)
    time = np.arange(fine.size) * own.period_s / 20
    # scipy has no held input: it is stepped a hair after every change
    shift = scipy.signal.StateSpace(stage.a, stage.b[:, None], np.eye(3), np.zeros((3, 1)))
    _, _, states = scipy.signal.lsim(
        shift, fine - own.points[0, 0], time, X0=np.zeros(3), interp=False
    )
    assert np.max(np.abs(states[:, 1])) == pytest.approx(row.motion.largest_velocity[0], rel=0.02)


@contextmanager
def stalling(design: CommandGovernorDesign) -> Iterator[Governor]:
    """A governor that the loop gives up on."""

    class Stalling(CommandGovernor):
        def call(
            self, operation: str, inputs: Mapping[str, Value] | None = None
        ) -> tuple[Status, dict[str, Value]]:
            if operation == "step":
                raise Stalled("after 9 slow periods only 3 of 5 points")
            return super().call(operation, inputs)

    yield Stalling(design)


def test_a_controller_that_stalls_is_a_row_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object):  # type: ignore[no-untyped-def]
        raise Stalled("after 9 slow periods only 3 of 5 points")

    monkeypatch.setattr(command_governor_study, "sweeps", lambda _: sweeps(machine())[3:])
    found = compare_governors(machine(), stalling, never, Silent())
    first = found.rows[0]
    assert not first.complete
    assert first.faults == ["the path was not finished: after 9 slow periods only 3 of 5 points"]
    names = [row.name for row in found.rows]
    assert names[4:6] == ["two-stage SPRG, minimal motion", "two-stage SPRG, pattern"]
    assert not found.rows[7].complete
    assert found.rows[7].faults == []
    assert found.rows[3].complete
    (swept,) = found.sweeps
    assert [trial.rows[0].complete for trial in swept.trials] == [False, False]


def test_what_the_options_do() -> None:
    """Of a small machine: the same as a project that has them, each by what it is there for."""
    found = {sweep.title: sweep.trials for sweep in compared().found.sweeps}
    between = {trial.label: trial.rows for trial in found["Between the samples"]}
    one, two, three, five = (between[f"N = {n}"] for n in (1, 2, 3, 5))
    for reference in (0, 1):
        over = [rows[reference].between.velocity for rows in (one, two, three, five)]
        assert over[0] > max(over[1:3])
        assert min(over[1:3]) > over[3] > 0.0
    assert [*three] == [*compared().found.rows[:2]]
    margin = between["N = 3, these and a margin of 0.25 mm"]
    assert all(row.instants.stroke <= -0.01 + 1e-9 for row in margin)
    assert all(row.between.stroke < 0.0 for row in margin)
    assert all(row.complete for rows in between.values() for row in rows)
    least = [trial.rows[0] for trial in found["Stroke reserve"]]
    assert [row.time_s for row in least] == sorted((r.time_s for r in least), reverse=True)
    assert least[-1].time_s < least[0].time_s
    after, at = (trial.rows[0] for trial in found["Index of (21)"])
    assert after.time_s < at.time_s


def test_a_shortened_sight_is_that_of_a_design_with_that_window() -> None:
    own = machine()
    design = governor_design(own)
    short = replace(design, window=3 * own.ratio)
    seen = run_machine(own, design, Shortsighted(CommandGovernor(design), short.window), 30)
    made = run_machine(own, short, CommandGovernor(short), 30)
    np.testing.assert_array_equal(seen.command, made.command)
    np.testing.assert_array_equal(seen.taken, made.taken)
    whole = run_machine(own, design, CommandGovernor(design), 30)
    assert not np.array_equal(whole.command, made.command)


def test_a_faster_stage_is_the_same_one_in_less_time() -> None:
    own = machine()
    quick = None
    for setting in sweeps(own)[0][2]:
        if setting.label == "stage 4 times as fast, N = 3":
            assert setting.build is not None
            quick = setting.build()
    assert quick is not None
    slow, fast = (discretise(m.slow[0], t) for m, t in ((own, 0.08), (quick, 0.02)))
    state = np.zeros(3), np.zeros(3)
    for _ in range(12):
        state = slow.a @ state[0] + slow.b, fast.a @ state[1] + fast.b
        np.testing.assert_allclose(state[1], state[0] * [1, 4, 16], rtol=1e-9, atol=1e-12)
    assert quick.sets[0].limits == own.sets[0].limits
    np.testing.assert_allclose(quick.slow[0].poles, -80.0, rtol=1e-3)


def test_two_stage_controllers_on_the_minimal_motion_stay_within_the_stroke() -> None:
    """They are told half of it, and the motion leaves the other half: what is judged is the
    pattern's point, not theirs."""
    rows = {row.name: row for row in compared().found.rows}
    row = rows["two-stage SPRG, minimal motion"]
    assert row.complete
    # more than the half that they were told of
    assert -0.45 < row.instants.stroke <= 1e-9
    assert row.motion.distance_m[0] < rows["two-stage SPRG, pattern"].motion.distance_m[0]


def test_paper_1_s_machine_is_the_same_one_moved_to_the_middle() -> None:
    own = machine()
    moved = as_two_stage(own)
    np.testing.assert_allclose(moved.timed.points + 0.125, own.points, rtol=0, atol=1e-15)
    assert moved.plants.y is moved.plants.x
    assert moved.limits[0] == own.sets[0].limits
    np.testing.assert_allclose(moved.slow[0].a, own.slow[0].a, rtol=1e-9)
    assert moved.fast[0].bandwidth_3db > 20.0 * own.slow[0].bandwidth_3db


def test_what_paper_1_s_machine_refuses_is_a_row_that_says_so() -> None:
    """From rest a command of a metre leaves the admissible set: Theorem 1 has no hypothesis."""
    own = machine()
    jump = own.points.copy()
    jump[600:] -= 0.04
    torn = replace(own, timed=replace(own.timed, points=jump))
    row = cascade_row("SPRG", torn, lambda *_: pytest.fail("refused before"), planned=False)
    assert "Theorem 1" in row.stopped
    assert row.passed
    assert not row.complete


def test_work_and_distance_are_integrals() -> None:
    """A sine of 3 mm at 2 rad/s, once: the integral of |sin cos| over it is 1."""
    time = np.linspace(0.0, np.pi, 20001)
    wave = np.stack([0.003 * np.sin(2 * time), 0.006 * np.cos(2 * time), -0.012 * np.sin(2 * time)])
    found = slow_motion(np.stack([wave.T, np.zeros_like(wave.T)], axis=1), time[1])
    assert found.distance_m == (pytest.approx(0.012, rel=1e-6), 0.0)
    assert found.work_j_per_kg[0] == pytest.approx(0.006 * 0.012, rel=1e-3)
    assert found.largest_velocity[0] == pytest.approx(0.006)
    assert found.largest_acceleration[0] == pytest.approx(0.012, rel=1e-6)
