"""The tracking MPC by the active-set method: the C is the reference, and its mutants are found."""

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
from servogen.controllers.design import Status, Value
from servogen.controllers.mpc_solver import ActiveSetSolver
from servogen.controllers.tracking_mpc import TrackingMpc
from servogen.emit.package import CPackage, emit_package
from servogen.sil.build import compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
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
    "at the cap, float32": replace(BASE, prefix="asf1", cap=1, precision="float32"),
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
    for title, reference, calls in suite(design(v), 11, 60):
        if "_mpc" not in title:
            continue
        declaration = reference().declaration
        agreement = compare(reference(), CompiledController(module(), declaration), calls)
        assert agreement.passed, f"{title}: {agreement.difference}"
        assert agreement.worst == 0.0
        seen |= set(agreement.statuses)
    assert {"OK", "NOT_FINITE", "OUT_OF_RANGE", "NOT_READY", "INFEASIBLE"} <= seen
    assert "BACKUP" in seen or not name.startswith("at the cap")


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
    name = "at the cap" if name == "float64" else "at the cap, float32"
    v = VARIANTS[name]
    reference, twin = pair(name)
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
    assert isinstance(reference.solver, ActiveSetSolver)
    assert reference.solver.work.size == 1
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
            bound = 1e-8 if v.precision == "float64" else 1e-2
            assert np.max(np.abs(fresh.plan - warm.plan)) < bound * made.limits.fast_range_m
            compared += 1
    assert compared > 20


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    return change


MUTANTS: dict[str, Callable[[str], str]] = {
    "side of an entering row": swap(
        "side = 1;\n                    }", "side = -1;\n                    }"
    ),
    "side of a product": swap("(side == self->side[j]) ? -along : along", "-along"),
    "upper and lower side missed": swap("(self->side[j] > 0) ?", "(self->side[j] < 0) ?"),
    "side of a multiplier": swap("? dual[j] : -dual[j]", "? dual[j] : dual[j]"),
    "bounds the other way round": swap(
        "sg_max(r0 - high[first], low[first] - r0)", "sg_max(r0 - low[first], high[first] - r0)"
    ),
    "a slot is not freed": swap("self->slot[last] = freed;", ""),
    "slots do not move up": swap("self->slot[i] = self->slot[i + 1];", ""),
    "sides do not move up": swap("self->side[i] = self->side[i + 1];", ""),
    "multipliers do not move up": swap("self->dual[i] = self->dual[i + 1];", ""),
    "missed of the last call": swap(
        "CORE_MPC_VARIABLES, (sg_real)0, self->missed);\n    }\n    return",
        "0, (sg_real)0, self->missed);\n    }\n    return",
    ),
    "what is missed stays after a part of a step": swap(
        "(self->missed[i] - (share * self->missed[i]))", "(self->missed[i])"
    ),
    "the set is not shifted": swap("= core_mpc_shifted(self->row[j]);", "= self->row[j];"),
    "size not reset": swap(
        "        self->size = 0;\n        for (int32_t j", "        for (int32_t j"
    ),
    "tolerance dropped": swap("if (excess > core_mpc_tolerance) {", "if (excess > (sg_real)0) {"),
    "pivot test dropped": swap("if (pivot > (least * *square)) {", "if (pivot > -(sg_real)1) {"),
    "tie to the last row": swap("            row = i;\n            break;", "            row = i;"),
    "the cap ignored": swap(
        "sg_status status = SG_BACKUP;\n    int32_t entering",
        "sg_status status = SG_OK;\n    int32_t entering",
    ),
    "lines of L": swap("(j * (j - 1)) / 2, 0", "(j * j) / 2, 0"),
    "a kept set taken as it is": swap(
        "if ((dropped & kept) == 1) {", "if ((dropped & kept) == 2) {"
    ),
    "sets are never kept": swap("if (size < CORE_MPC_KEEP) {", "if (size <= CORE_MPC_VARIABLES) {"),
    "the last to vanish is dropped": swap(
        "} else if (here < share) {", "} else if (here > share) {"
    ),
    "no way is no answer": swap(
        "            status = SG_INFEASIBLE;\n        }\n    }\n",
        "            status = SG_OK;\n        }\n    }\n",
    ),
    "iterations": swap("*iterations = k + 1;", "*iterations = k;"),
    "the rank-one update": swap("own -= below[k] * entry;", "own += below[k] * entry;"),
    "a plan that is not judged": swap("status = core_mpc_judge(self, origin);", ""),
    "where the plant starts": swap("self->start[i] = rest[i - 1]", "self->start[i] = rest[0]"),
}


@cache
def mutants() -> Any:
    packages = [alone(renamed(len(MUTANTS)))]
    for number, change in enumerate(MUTANTS.values()):
        made = alone(renamed(number))
        file = f"{made.name}_mpc.c"
        text = made.files[file].replace(f"{made.name}_mpc", "core_mpc")
        text = text.replace(f"{made.name}_mpc".upper(), "CORE_MPC")
        changed = change(text)
        assert changed != text, number
        changed = changed.replace("core_mpc", f"{made.name}_mpc")
        changed = changed.replace("CORE_MPC", f"{made.name}_mpc".upper())
        packages.append(replace(made, files={**made.files, file: changed}, hash=made.hash[::-1]))
    return compile_package(packages, temporary_folder("mutants"), ["-O0", "-Wno-error"])


def renamed(number: int) -> Variant:
    return replace(BASE, prefix=f"set{number}", letter="B")


@cache
def calls() -> list[Call]:
    """Random programs, each twice and then the one before: what a set begins with is now right,
    now one sample off, now another program's."""
    d = design(renamed(0)).mpc[0]
    made = list(random_calls(d, 7, 400))
    steps = [c for c in made if c.operation == "step"]
    reference, many = TrackingMpc(d), []
    reference.call("reset", {"position": 0.0})
    assert isinstance(reference.solver, ActiveSetSolver)
    for c in steps:
        status = reference.call("step", c.inputs)[0]
        if status is Status.OK and reference.solver.work.size >= reference.solver.tables.keep:
            many.append(c)
    some = steps[:150:3]
    turns = [c for k, c in enumerate(some) for c in (c, c, some[k - 1])]
    # sets that are kept, met by programs that need them, another one or none
    turns += [
        c for k, large in enumerate(many) for c in (large, large, some[k], large, many[k - 1])
    ]
    edges = [c for c in edge_calls(TrackingMpc(d).declaration) if c.operation != "candidate"]
    return [made[0], *turns, *edges]


def found(v: Variant) -> str:
    """The first thing that these calls say of the C of the variant; empty for nothing."""
    reference = TrackingMpc(design(v).mpc[0])
    agreement = compare(reference, CompiledController(mutants(), reference.declaration), calls())
    return "" if agreement.passed else str(agreement.difference)


def test_the_unchanged_package_agrees():
    assert found(renamed(len(MUTANTS))) == ""


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_found(name):
    told = found(renamed(list(MUTANTS).index(name)))
    assert told, f"nothing noticed the mutant {name!r}"
