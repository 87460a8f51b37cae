"""Every controller of every kind of cascade: the C is the reference, bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from core_designs import Variant, compiled, design, package
from core_loop import run, zigzag

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Status
from servogen.project import load_project
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import resting_inputs
from servogen.sil.harness import Twin, compare
from servogen.sil.random_calls import random_calls
from servogen.sil.scenarios import suite
from servogen.systems.judgement import check_project

EXAMPLE = Path(__file__).parents[2] / "examples" / "two_stage" / "servogen.toml"
# Two modules of several packages each: compiling is what takes the time here.
GROUP_ONE = (
    Variant("e64", cap=40),
    Variant("e32", cap=40, precision="float32"),
    Variant("s64", horizon=0),
)
GROUP_TWO = (
    Variant("n1", horizon=1, cap=1),
    Variant("n2", horizon=2, cap=2, precision="float32", letter="L"),
    Variant("n3", horizon=3, both_ends=False, ramp=0, inter=2, cap=12),
    Variant("s32", horizon=0, precision="float32", order=4, matching=False),
    Variant("m2", horizon=3, points=2, ramp=0, cap=12, period=3),
    Variant("m5", horizon=2, points=5, ramp=1, cap=12, precision="float32"),
    Variant("df", horizon=3, differing=True, cap=12, precision="float32"),
    Variant("o4", horizon=4, order=4, cap=12),
    Variant("p0", horizon=3, period=0, cap=12),
    Variant("p2", horizon=3, period=2, cap=12),
    Variant("nt", horizon=2, bandwidth=200.0, cap=12),
)
ALL = {v.prefix: (v, group) for group in (GROUP_ONE, GROUP_TWO) for v in group}
# One worker for each module: it is compiled once.
one, two = (pytest.mark.xdist_group(f"equivalence {number}") for number in (1, 2))


def each(*prefixes: str):
    """One test for each of these cascades, on the worker that has its module."""
    marked = [pytest.param(p, marks=one if ALL[p][1] is GROUP_ONE else two) for p in prefixes]
    return pytest.mark.parametrize("prefix", marked)


def controller(v: Variant, group: tuple[Variant, ...], index: int = -1) -> CompiledController:
    return CompiledController(
        compiled(*group, quick=group is GROUP_TWO), package(v).declarations[index]
    )


@each(*ALL)
def test_edges_and_random_calls_agree_bit_for_bit(prefix):
    v, group = ALL[prefix]
    module = compiled(*group, quick=group is GROUP_TWO)
    statuses: dict[str, set[str]] = {}
    for name, reference, calls in suite(design(v), 11, 30):
        declaration = reference().declaration
        agreement = compare(reference(), CompiledController(module, declaration), calls)
        assert agreement.passed, f"{name}: {agreement.difference}"
        assert agreement.calls == len(calls)
        assert agreement.worst == 0.0
        statuses.setdefault(name.split(":")[0], set()).update(agreement.statuses)
    everything = {"OK", "NOT_FINITE", "OUT_OF_RANGE"}
    assert everything | {"INFEASIBLE"} <= statuses[f"{prefix}_governor"]
    assert everything | {"NOT_READY", "OVERFLOW"} <= statuses[f"{prefix}_follower"]
    assert everything | {"NOT_READY"} <= statuses[prefix]
    if v.horizon > 1:
        assert "PRIMING" in statuses[prefix]
    for name in statuses:
        if "_mpc" in name:
            assert everything | {"NOT_READY", "BACKUP", "INFEASIBLE"} <= statuses[name]


@each("e64", "e32")
def test_the_first_periods_of_a_closed_loop_agree_bit_for_bit(prefix):
    """Both stages, every fast sample, 200 slow periods of a path that needs the solver."""
    v, group = ALL[prefix]
    twin = Twin(Cascade(design(v)), controller(v, group))
    record = run(twin, v, zigzag(seconds=8.0), 200, fast_steps=v.points)
    assert twin.agreement.passed, twin.agreement.difference
    assert twin.agreement.worst == 0.0
    assert twin.agreement.calls > 200 * 150
    iterations = [o[f"iterations_{a}"] for o in record.outputs for a in "xy"]
    assert np.count_nonzero(iterations) >= 20
    assert Status.SUBOPTIMAL in record.status or Status.BACKUP in record.status or prefix == "e64"


@one
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_whole_path_of_the_example_agrees_bit_for_bit(precision):
    """All slow periods of the bundled drawing (its fast samples: the closed loop above)."""
    path = check_project(load_project(EXAMPLE)).timed.points
    v = ALL["e64" if precision == "float64" else "e32"][0]
    twin = Twin(Cascade(design(v)), controller(v, GROUP_ONE))
    record = run(twin, v, path)
    assert twin.agreement.passed, twin.agreement.difference
    assert twin.agreement.worst == 0.0
    assert record.complete
    assert record.begun == len(path) - 1


@one
def test_two_instances_do_not_know_of_each_other():
    """Interleaved call by call, each does what it does alone."""
    v, group = ALL["e64"]
    these, those = (list(random_calls(design(v), seed, 12)) for seed in (1, 2))
    alone = []
    for calls in (these, those):
        own = controller(v, group)
        alone.append([own.call(c.operation, c.inputs) for c in calls])
    first, second = controller(v, group), controller(v, group)
    for i in range(max(len(these), len(those))):
        for calls, instance, expected in ((these, first, alone[0]), (those, second, alone[1])):
            if i < len(calls):
                assert instance.call(calls[i].operation, calls[i].inputs) == expected[i]


@one
def test_two_controllers_of_different_precision_run_in_one_program():
    """A float64 and a float32 cascade of one module, turn by turn, each against its reference."""
    pairs = []
    for prefix in ("e64", "e32", "s64"):
        v, group = ALL[prefix]
        pairs.append((Cascade(design(v)), controller(v, group), random_calls(design(v), 5, 8)))
    for calls in zip(*(pair[2] for pair in pairs), strict=False):
        for (reference, instance, _), call in zip(pairs, calls, strict=True):
            agreement = compare(reference, instance, [call])
            assert agreement.passed, agreement.difference


def test_the_suite_is_the_same_every_time():
    v = ALL["n3"][0]
    first, second = (list(suite(design(v), 3, 5)) for _ in range(2))
    assert [s.name for s in first] == [s.name for s in second]
    for a, b in zip(first, second, strict=True):
        assert repr(a.calls) == repr(b.calls)
    other = list(suite(design(v), 4, 5))
    assert repr(other[1].calls) != repr(first[1].calls)


@each("s64", "n3")
def test_points_beyond_the_valid_ones_are_not_read(prefix):
    v, group = ALL[prefix]
    for cascade in (Cascade(design(v)), controller(v, group)):
        told = []
        for beyond in (0.0, np.nan, 1e300):
            cascade.call("reset", {"position_x": 0.0, "position_y": 0.0})
            inputs = dict(resting_inputs(cascade.declaration, "step"), n_points=7)
            for axis in "xy":
                inputs[f"points_{axis}"] = np.where(np.arange(v.points) < 7, 1e-5, beyond)
            told.append([cascade.call("step", inputs) for _ in range(4)])
        assert told[0][-1][1]["points_taken"] == 7
        assert told[1] == told[0]
        assert told[2] == told[0]
