"""The tracking MPC by the active-set method: the C is the reference, and one change in it is found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from core_designs import Variant, design, package, temporary_folder
from core_loop import run, zigzag

from servogen.controllers.cascade import Cascade
from servogen.controllers.design import Reference, Status, Value
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.emit.package import CPackage, emit_package
from servogen.precision import FloatArray
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, Twin, compare
from servogen.sil.random_calls import mpc_window, random_calls
from servogen.sil.scenarios import suite

# One worker: the mutants are one module.
pytestmark = pytest.mark.xdist_group("active set")
BASE = Variant("as64", horizon=8, cap=40, letter="L", method="active_set")
VARIANTS = {
    "float64": BASE,
    "float32": replace(BASE, prefix="as32", precision="float32"),
    "a horizon of no whole blocks": replace(BASE, prefix="as7", horizon=7),
    "N = 2": replace(BASE, prefix="as2", horizon=2, precision="float32"),
    "at the cap": replace(BASE, prefix="as1", cap=1),
}
both = pytest.mark.parametrize("name", ["float64", "float32"])


def alone(v: Variant) -> CPackage:
    """The package of the MPC without the rest of its cascade."""
    return emit_package(v.prefix, (TrackingMpc(design(v).mpc[0]).declaration,))


@cache
def module() -> Any:
    return compile_package(
        [package(VARIANTS["float64"]), *(alone(v) for v in list(VARIANTS.values())[1:])],
        temporary_folder("active-set"),
        ["-O0"],
    )


def pair(name: str) -> tuple[TrackingMpc, Twin]:
    """A reference of its own to look into, and the reference and the C side by side."""
    made = design(VARIANTS[name]).mpc[0]
    reference = TrackingMpc(made)
    return reference, Twin(reference, CompiledController(module(), reference.declaration))


def at_rest(v: Variant, where: float, target: float, **other: Value) -> dict[str, Value]:
    """A step from rest at ``where`` towards ``target``, at the speed that the machine may have."""
    limits = design(v).mpc[0].limits
    step = 0.9 * limits.velocity_m_per_s * 0.03
    ahead = np.arange(v.horizon + 1) * step * np.sign(target - where)
    path = where + np.clip(ahead, -abs(target - where), abs(target - where))
    low, high = mpc_window(path, limits)
    state = {"position": where, "velocity": 0.0, "acceleration": 0.0}
    return {**state, "reference": path, "low": low, "high": high, **other}


@pytest.mark.parametrize("name", VARIANTS)
def test_edges_and_random_calls_agree_bit_for_bit(name):
    """Bounds, NaN, infinities, what is out of range; random states, windows that contradict."""
    seen: set[str] = set()
    v = VARIANTS[name]
    for title, reference, calls in suite(design(v), 11, 80):
        if "_mpc" not in title:
            continue
        declaration = reference().declaration
        agreement = compare(reference(), CompiledController(module(), declaration), calls)
        assert agreement.passed, f"{title}: {agreement.difference}"
        assert agreement.worst == 0.0
        seen |= set(agreement.statuses)
    assert {"OK", "NOT_FINITE", "OUT_OF_RANGE", "NOT_READY", "INFEASIBLE"} <= seen
    assert "BACKUP" in seen or name != "at the cap"


def test_a_closed_loop_agrees_bit_for_bit():
    v = VARIANTS["float64"]
    cascade = Cascade(design(v))
    twin = Twin(cascade, CompiledController(module(), cascade.declaration))
    record = run(twin, v, zigzag(seconds=4.0), 100, fast_steps=3)
    assert twin.agreement.passed, twin.agreement.difference
    iterations = np.array([o[f"iterations_{a}"] for o in record.outputs for a in "xy"])
    assert np.count_nonzero(iterations) >= 10
    assert np.max(iterations) >= 3


@both
def test_at_the_cap_the_shifted_plan_goes_on(name):
    """One iteration cannot add a row and see that it was enough: BACKUP, and the last plan."""
    v = replace(VARIANTS["at the cap"], precision=VARIANTS[name].precision)
    reference = TrackingMpc(design(v).mpc[0])
    made = replace(v, prefix=f"cap{v.precision}")
    own = TrackingMpc(design(made).mpc[0])
    compiled = CompiledController(
        compile_package([alone(made)], temporary_folder("cap"), ["-O0"]), own.declaration
    )
    twin = Twin(reference, compiled)
    twin.call("reset", {"position": 0.0})
    assert twin.call("step", at_rest(v, 0.0, 0.0))[0] is Status.OK
    before = reference.plan.copy()
    inputs = at_rest(v, 0.0, 0.015, high=np.full(v.horizon, 0.008))
    status, out = twin.call("step", inputs)
    assert status is Status.BACKUP
    assert out["iterations"] == 1
    assert out["command"] == before[1]
    assert np.array_equal(reference.plan[:-1], before[1:])
    assert reference.plan[-1] == before.dtype.type(0.015)
    assert twin.agreement.passed, twin.agreement.difference


@both
def test_bounds_that_contradict_are_told_and_leave_the_shifted_plan(name):
    v = VARIANTS[name]
    reference, twin = pair(name)
    twin.call("reset", {"position": 0.0})
    twin.call("step", at_rest(v, 0.0, 0.2))
    before = reference.plan.copy()
    low, high = np.full(v.horizon, 0.01), np.full(v.horizon, 0.2)
    high[3] = -0.01
    inputs = at_rest(v, 0.0, 0.0, low=low, high=high)
    status, out = twin.call("step", inputs)
    assert status is Status.INFEASIBLE
    assert out["command"] == before[1]
    assert np.array_equal(reference.plan[:-1], before[1:])
    status, _ = twin.call("step", at_rest(v, 0.0, 0.0))  # and nothing of it is left
    assert status is Status.OK
    assert twin.agreement.passed, twin.agreement.difference


@both
def test_a_bound_that_is_just_met_needs_no_iteration_and_one_just_missed_does(name):
    v = VARIANTS[name]
    reference, twin = pair(name)
    d = design(v).mpc[0]
    real, start = d.precision.dtype.type, at_rest(v, 0.0, 0.0)
    twin.call("reset", {"position": 0.0})
    for beyond, wanted in ((0.0, 0), (4.0, 1)):
        # at rest at the origin all positions ahead are zero: a bound of the margin, and less
        margin = float(d.tol.margin) * (1.0 - beyond) * d.limits.fast_range_m
        high = np.full(v.horizon, 0.2)
        high[2] = real(margin)
        status, out = twin.call("step", {**start, "high": high})
        assert status is Status.OK
        assert (int(np.asarray(out["iterations"])) > 0) == bool(wanted)
    assert reference.work.size == 1
    assert twin.agreement.passed, twin.agreement.difference


@both
def test_a_long_run_without_measurements_keeps_its_plan_and_comes_back(name):
    v = VARIANTS[name]
    reference, twin = pair(name)
    limit = design(v).mpc[0].limits.position_m
    twin.call("reset", {"position": 0.0})
    twin.call("step", at_rest(v, 0.0, 0.3))
    for k in range(300):
        lost = at_rest(v, 0.0, 0.3, velocity=(np.nan, np.inf, -1e30)[k % 3])
        status, out = twin.call("step", lost)
        assert status in (Status.NOT_FINITE, Status.OUT_OF_RANGE)
        assert abs(float(np.asarray(out["command"]))) <= 4.0 * limit
        assert np.all(np.isfinite(reference.predicted))
    where = float(np.clip(reference.predicted[0], -limit, limit))
    status, _ = twin.call("step", at_rest(v, where, where))
    assert status is Status.OK
    assert twin.agreement.passed, twin.agreement.difference


@both
def test_a_set_of_garbage_is_left_behind(name):
    """Whatever the last program left as its working set, the next one has the same optimum."""
    v, rng = VARIANTS[name], np.random.default_rng(5)
    made = design(v).mpc[0]
    calls = [c for c in random_calls(made, 3, 60) if c.operation == "step"]
    cold: dict[str, FloatArray] = {}
    warm = TrackingMpc(made)
    warm.call("reset", {"position": 0.0})
    compared = 0
    for index in rng.permutation(len(calls)):
        inputs = calls[index].inputs
        fresh = TrackingMpc(made)
        fresh.call("reset", {"position": 0.0})
        first, second = fresh.call("step", inputs), warm.call("step", inputs)
        if first[0] is Status.OK:
            assert second[0] is Status.OK
            cold[str(index)] = fresh.plan
            bound = 1e-9 if v.precision == "float64" else 2e-3
            assert np.max(np.abs(fresh.plan - warm.plan)) < bound * made.limits.fast_range_m * 10
            compared += 1
    assert compared > 20


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    return change
