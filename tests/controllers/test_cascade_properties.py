"""Theorem 2 and Corollary 1 as properties of closed loops: with no optimisation at all, or with a
single iteration, the loop keeps every constraint and finishes the path."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from core_designs import LIMITS, OTHER_LIMITS, Variant, design, slow_stage
from core_loop import run, zigzag

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Status
from servogen.plants.statespace import discretise

CAPPED = {
    "cap 1": Variant(cap=1),
    "cap 2": Variant(cap=2, letter="L"),
    "float32": Variant(cap=1, precision="float32"),
    "N = 1": Variant(horizon=1, cap=1, letter="L"),
    "N = 2": Variant(horizon=2, cap=1, letter="L"),
    "N = 3": Variant(horizon=3, cap=1, letter="L"),
    "axes differ": Variant(horizon=5, cap=1, differing=True),
    "fourth order": Variant(horizon=5, cap=1, order=4),
    "plain PQP": Variant(horizon=5, cap=1, period=0),
}
PATH = zigzag()


def points_of(record, path: np.ndarray) -> list[np.ndarray]:
    """The points (q(mu) .. q(mu + eta)) of every interval."""
    ends = np.cumsum([0] + [int(o["interval_points"]) for o in record.outputs])
    return [path[a : b + 1] for a, b in itertools.pairwise(ends)]


def check_constraints(record, v: Variant, path: np.ndarray, tolerance: float) -> None:
    """Limits at the slow samples; the range at both ends of every interval, all of its points."""
    limits = (LIMITS, OTHER_LIMITS if v.differing else LIMITS)
    intervals = points_of(record, path)
    for i, lim in enumerate(limits):
        x = record.state[:, i]
        assert np.max(np.abs(x[:, 0])) <= lim.position_m + tolerance
        assert np.max(np.abs(x[:, 1])) <= lim.velocity_m_per_s + tolerance
        assert np.max(np.abs(x[:, 2])) <= lim.acceleration_m_per_s2 + tolerance
        for k in range(len(x) - 1):
            for end in (x[k, 0], x[k + 1, 0]):
                reach = np.max(np.abs(intervals[k][:, i] - end))
                assert reach <= lim.fast_range_m + tolerance


@pytest.mark.parametrize("name", CAPPED)
def test_capped_loops_finish_and_keep_every_constraint(name):
    v = CAPPED[name]
    record = run(Cascade(design(v)), v, PATH, 600)
    assert record.complete
    assert record.begun == len(PATH) - 1
    found = {Status(o[f"status_{a}"]) for o in record.outputs for a in "xy"}
    assert found <= {Status.OK, Status.SUBOPTIMAL, Status.BACKUP}
    if v.horizon > 2:  # with less ahead, the free optimum of this path breaks no bound
        assert Status.BACKUP in found
    check_constraints(record, v, PATH, 1e-9 if v.precision == "float64" else 2e-6)


@pytest.mark.parametrize("name", ["cap 1", "N = 1", "N = 3", "axes differ", "fourth order"])
def test_the_shifted_plan_is_feasible_at_every_step(name):
    """Nothing but Corollary 1: the judgement of every shifted plan must be BACKUP."""
    v = CAPPED[name]
    cascade = Cascade(design(v))
    judged = []
    for mpc in cascade.mpc:

        def shift(state, reference, low, high, mpc=mpc):
            relative = reference - state[0]
            below, above = mpc._bounds(state[0], relative, low, high)
            plan = np.append(mpc.plan[1:], reference[-1])
            judged.append(mpc._judge(plan - state[0], mpc._start(state), below, above))
            mpc._accept(state, plan)
            return Status.BACKUP, mpc.plan[0], 1

        mpc.step = shift
    record = run(cascade, v, PATH, 150)
    assert record.begun == len(PATH) - 1
    assert set(judged) == {Status.BACKUP}
    check_constraints(record, v, PATH, 1e-9)


def test_one_end_of_the_interval_is_not_enough():
    """As printed the plan leaves the range at the other end: the reason for ``both_ends``."""
    v = Variant(both_ends=False)
    record = run(Cascade(design(v)), v, PATH, 600)
    intervals = points_of(record, PATH)
    worst = 0.0
    for i in range(2):
        for k in range(len(record.state) - 1):
            for end in (record.state[k, i, 0], record.state[k + 1, i, 0]):
                worst = max(worst, float(np.max(np.abs(intervals[k][:, i] - end))))
    assert worst > LIMITS.fast_range_m + 1e-5


@pytest.mark.parametrize("letter", ["B", "H", "L"])
def test_calibrations_keep_every_constraint_and_seldom_need_the_backup(letter):
    alone = run(Cascade(design(Variant(horizon=0))), Variant(horizon=0), PATH, 600)
    assert alone.complete
    check_constraints(alone, Variant(horizon=0), PATH, 1e-9)
    v = Variant(letter=letter, cap=800)
    record = run(Cascade(design(v)), v, PATH, 600)
    assert record.complete
    check_constraints(record, v, PATH, 1e-9)
    statuses = [Status(o[f"status_{a}"]) for o in record.outputs for a in "xy"]
    assert statuses.count(Status.BACKUP) <= 0.01 * len(statuses)
    if letter == "H":
        assert len(record.status) <= len(alone.status)


@pytest.mark.parametrize("horizon", [0, 1, 5])
def test_a_lost_measurement_is_bridged_by_the_prediction(horizon):
    """The model is exact here, so going on without a measurement changes nothing but the feed."""
    v = Variant(horizon=horizon)
    cascade = Cascade(design(v))
    seen_states, lost = {}, {20, 21, 40}

    def disturb(k: int, state: np.ndarray) -> np.ndarray:
        seen_states[k] = state.copy()
        if k in lost:
            state[0, 1] = np.nan
        return state

    predictions = []
    plain = cascade.fast.call

    def begin(operation, inputs=None):
        if operation == "begin":
            predictions.append([inputs[f"{a}_{n}"] for a in "xy" for n in ("position", "velocity")])
        return plain(operation, inputs)

    cascade.fast.call = begin
    record = run(cascade, v, PATH, 60, fast_steps=v.points, disturb=disturb)
    for k in lost:
        assert record.status[k] is Status.NOT_FINITE
        assert record.outputs[k]["points_taken"] == 0
        true = seen_states[k][:, :2].ravel()
        assert np.allclose(np.array(predictions[k], dtype=float), true, atol=1e-9)
    assert all(record.status[k] is Status.OK for k in range(60) if k not in lost)
    check_constraints(record, v, PATH, 1e-9)


def test_a_knocked_machine_is_reported_and_recovers():
    v = Variant(horizon=5)

    def disturb(k: int, state: np.ndarray) -> np.ndarray:
        if k == 30:
            state[0, 1] = 1.0  # beyond the velocity limit: no plan can be feasible
        return state

    record = run(Cascade(design(v)), v, PATH, 600, disturb=disturb)
    assert record.status[30] is Status.INFEASIBLE
    assert record.complete


def test_points_are_conserved():
    """Taken = begun + pending at every step; finished means that all of them were begun."""
    for v in (Variant(horizon=3), Variant(horizon=0), Variant(horizon=1)):
        record = run(Cascade(design(v)), v, PATH, 600)
        # taken while priming, before the first recorded step
        early = record.outputs[0]["pending"] + record.outputs[0]["interval_points"]
        early -= record.outputs[0]["points_taken"]
        taken, begun = early, 0
        for outputs in record.outputs:
            taken += outputs["points_taken"]
            begun += outputs["interval_points"]
            assert outputs["pending"] == taken - begun
            assert 0 <= outputs["interval_points"] <= v.points
        assert begun == len(PATH) - 1


def test_priming_builds_the_plan_of_the_governor():
    v = Variant(horizon=4)
    cascade = Cascade(design(v))
    cascade.call("reset", {"position_x": PATH[0, 0], "position_y": PATH[0, 1]})
    model = discretise(slow_stage(), 0.03)
    state = np.array([PATH[0, 0], 0.0, 0.0])
    given = 0
    for _ in range(v.horizon - 1):
        inputs = {f"{a}_{n}": 0.0 for a in "xy" for n in ("position", "velocity", "acceleration")}
        inputs |= {"x_position": PATH[0, 0], "y_position": PATH[0, 1], "n_points": v.points}
        for i, a in enumerate("xy"):
            inputs[f"points_{a}"] = PATH[given + 1 : given + 1 + v.points, i]
        status, outputs = cascade.call("step", inputs)
        assert status is Status.PRIMING
        assert outputs["command_x"] == PATH[0, 0]
        given += outputs["points_taken"]
        state = model.a @ state + model.b * PATH[given, 0]
        assert cascade.mpc[0].plan[-1] == PATH[given, 0]
        assert cascade.reference[0][-1] == PATH[given, 0]
    # the shifted plan, which the first real step may fall back on, leads to this state
    end = cascade.mpc[0].candidate(np.array([PATH[0, 0], 0.0, 0.0]))
    assert np.allclose(end, state, atol=1e-12)
