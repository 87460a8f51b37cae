"""Every form of lookup in C against its reference, and against the program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lookup_designs import CASES, compiled, design, form_of, package, program

from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.controllers.lookup import Lookup
from servogen.controllers.lookup_design import design_lookup
from servogen.explicit.choose import choose
from servogen.explicit.lookup import TreeLookup
from servogen.precision import FLOAT64
from servogen.qp.parametric_solver import ParametricSolver
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call, compare
from servogen.sil.lookup_calls import lookup_calls

PRECISIONS = ("float64", "float32")


def in_c(prefix: str, precision: str = "float64") -> CompiledController:
    return CompiledController(compiled(), Lookup(design(prefix, precision)).declaration)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("prefix", CASES)
def test_moves_and_laws_are_the_reference_s_bits(prefix: str, precision: str) -> None:
    made = design(prefix, precision)
    calls = list(lookup_calls(made, np.random.default_rng(5), 600))
    calls += list(edge_calls(Lookup(made).declaration))
    agreement = compare(Lookup(made), in_c(prefix, precision), calls)
    assert agreement.passed, agreement.difference
    assert agreement.calls == len(calls)
    assert agreement.worst == 0.0
    assert {"OK", "NOT_FINITE", "OUT_OF_RANGE"} <= set(agreement.statuses)
    assert ("INFEASIBLE" in agreement.statuses) == (made.feasible is not None)


@pytest.mark.parametrize("prefix", CASES)
def test_the_first_move_is_the_program_s(prefix: str) -> None:
    """Status and moves against the dual method, away from the rounding's width of the edge."""
    made, problem = design(prefix), program(CASES[prefix].program)
    solver, controller = ParametricSolver(problem), in_c(prefix)
    span = np.where(np.isfinite(made.high - made.low), made.high - made.low, 1.0)
    slope = np.abs(problem.unconstrained()[0])
    seen = {Status.OK: 0, Status.INFEASIBLE: 0}
    for call in lookup_calls(made, np.random.default_rng(6), 300):
        theta = np.asarray(call.inputs["theta"])
        if not np.all(np.isfinite(theta)):
            continue
        status, out = controller.call("find", call.inputs)
        found = solver.solve(theta)
        if made.feasible is not None:
            reach = np.abs(made.feasible.rows) @ np.abs(theta) + 1.0
            if np.min(np.abs(made.feasible.rows @ theta - made.feasible.bounds) / reach) < 1e-8:
                continue
        assert (status is Status.OK) == found.feasible, theta
        seen[status] += 1
        if status is Status.OK:
            size = span + 1e-6 * np.max(slope @ np.abs(theta))
            np.testing.assert_array_less(np.abs(out["move"] - found.z[: made.moves]), 1e-9 * size)
        else:
            np.testing.assert_array_equal(out["move"], made.safe)
            assert out["law"] == -1
    assert seen[Status.OK] > 40
    if made.feasible is not None:
        assert seen[Status.INFEASIBLE] > 40


def test_the_moves_keep_their_bounds_whatever_comes() -> None:
    for prefix in CASES:
        for precision in PRECISIONS:
            made = design(prefix, precision)
            dtype = made.precision.dtype
            rng = np.random.default_rng(7)
            for call in lookup_calls(made, rng, 100):
                far = np.clip(np.asarray(call.inputs["theta"]) * 1e30, -made.reach, made.reach)
                _, out = in_c(prefix, precision).call("find", {"theta": far})
                assert np.all(np.isfinite(out["move"]))
                assert np.all(out["move"] >= made.low.astype(dtype))
                assert np.all(out["move"] <= made.high.astype(dtype))


def test_every_law_is_reached() -> None:
    for prefix in CASES:
        made = design(prefix)
        if not isinstance(made.form, TreeLookup):
            continue
        controller = in_c(prefix)
        calls = lookup_calls(made, np.random.default_rng(8), 3000)
        laws = {controller.call("find", call.inputs)[1]["law"] for call in calls}
        tree = made.form.tree  # a mirrored one has leaves for about half of the laws
        leaves = {-1 - int(c) for c in tree.children.ravel() if c < 0} or {0}
        assert laws - {-1} == leaves, prefix


def test_next_to_a_tree_s_hyperplane_float32_is_off_by_rounding_alone() -> None:
    """Wrong law, right move: the optimum is continuous. A rounding is one of the largest term."""
    exact, single = Lookup(design("lawtree")), in_c("lawtree", "float32")
    form = exact.design.form
    steep = np.max(np.sum(np.abs(form.gains), axis=2))
    differing = 0
    for call in lookup_calls(design("lawtree", "float32"), np.random.default_rng(9), 3000):
        theta = np.float32(call.inputs["theta"]).astype(np.float64)
        if not np.all(np.isfinite(theta)):
            continue
        _, wide = exact.call("find", {"theta": theta})
        _, short = single.call("find", {"theta": theta})
        differing += wide["law"] != short["law"]
        terms = 1.0 + np.max(np.abs(form.matrix) @ np.abs(theta))
        apart = abs(float(wide["move"][0]) - float(short["move"][0]))
        assert apart < 8.0 * steep * terms * np.finfo(np.float32).eps
    assert differing > 10


def test_forms_left_out_are_refused() -> None:
    problem = program("one move")
    chosen = choose(problem, 50, 5)
    left_out = next(form for form in chosen.forms if form.lookup is None)
    with pytest.raises(DesignError, match="not grown"):
        design_lookup("x", FLOAT64, problem, chosen, 1.0, 50, form=left_out)
    form = form_of("one move", "clip tree")
    huge = replace(form.lookup, gains=np.full_like(form.lookup.gains, 1e307))
    with pytest.raises(DesignError, match="float64 can compute with"):
        design_lookup("x", FLOAT64, problem, chosen, 1.0, 50, form=replace(form, lookup=huge))


def test_headers_say_what_is_told() -> None:
    files = package("float64").files
    assert "int32_t law; /* 1 [-1 .. 10]" in files["lawtree_d.h"]
    assert "law;" not in files["clips_d.h"].partition("_find_out")[0].partition("_find_in")[2]
    assert "DOUBLE_D_TREE_DEPTH = 5" in files["double_d.h"]
    assert Call("find").operation in files["clips_d.h"]
