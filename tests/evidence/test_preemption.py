"""fast_step may interrupt plan: what they share is listed, and either may go first."""

from __future__ import annotations

import numpy as np
import pytest
from core_designs import Variant, compiled, package
from core_loop import zigzag
from small_bench import changed, subject

from servogen.controllers.design import Value
from servogen.evidence.preemption import SAFE, examine_preemption
from servogen.sil.compiled import CompiledController
from servogen.wcet.refusal import CountRefused

MPC = Variant("pre", horizon=3, points=5, ramp=1, cap=12)
SPRG = Variant("pres", horizon=0, points=5, ramp=1)


@pytest.mark.parametrize("v", [MPC, SPRG], ids=["mpc", "sprg"])
def test_only_the_ring_is_shared(v: Variant) -> None:
    faults, figures = examine_preemption(subject(v))
    assert faults == []
    assert figures["shared"] == {"plan": sorted(SAFE), "predict": []}


RESULT = "    push.n_points = told.points_taken;\n"
PLANTED = {
    "a write to what the other reads": ("self->fast.rate_flat = (sg_real)0;", "fast.rate_flat"),
    "a read of what the other writes": ("told.low_x = self->fast.state_x[0];", "fast.state_x"),
    "all of a part": ("self->fast = self->fast;", "fast"),
    "by a pointer": (
        "sg_real *const p = (status == SG_OK) ? &self->fast.along : self->low_x; *p = told.low_x;",
        "fast.along",
    ),
    "in a function called": ("sg_fill(PRE_ORDER, told.low_x, self->fast.state_y);", "fast.state_y"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_what_else_is_shared_is_found(name: str) -> None:
    line, member = PLANTED[name]
    made = changed(package(MPC), "pre.c", RESULT, f"{RESULT}    {line}\n")
    told = f"pre_fast_step may interrupt pre_plan, and both touch {member}"
    assert told in examine_preemption(subject(MPC, made))[0]


@pytest.mark.parametrize(
    ("anchor", "line", "name"),
    [
        ("/* The measured states", "static sg_real kept;\n", "pre.c: kept"),
        (RESULT, "    static sg_real *kept; kept = self->low_x;\n", "pre.c: kept of pre_govern"),
    ],
)
def test_what_is_kept_outside_the_controller_is_found(anchor: str, line: str, name: str) -> None:
    made = changed(package(MPC), "pre.c", anchor, f"{line}{anchor}")
    told = f"{name} outlives a call and is no part of the controller"
    assert told in examine_preemption(subject(MPC, made))[0]


def test_an_entry_that_nothing_needs_and_a_pointer_that_is_lost_are_told() -> None:
    made = package(MPC)
    for axis in "xy":
        old = f"self->path_{axis}[self->tail] = in->points_{axis}[i];"
        made = changed(made, "pre_follower.c", old, "")
    assert examine_preemption(subject(MPC, made))[0] == [
        f"{member} is listed as shared and safe, and is not shared" for member in SAFE
    ]
    lost = "sg_real *kept[1] = { self->low_x }; *kept[0] = told.low_x;"
    made = changed(package(MPC), "pre.c", RESULT, f"{RESULT}    {lost}\n")
    with pytest.raises(CountRefused, match="a pointer into the controller that cannot be followed"):
        examine_preemption(subject(MPC, made))


@pytest.mark.parametrize("v", [MPC, SPRG], ids=["mpc", "sprg"])
def test_plan_and_fast_steps_in_either_order_are_the_same_to_the_last_bit(v: Variant) -> None:
    """Also where a measurement is lost; whatever lies between the two orders is then the same."""
    path = zigzag(seconds=1.5)[:: 150 // v.points]
    module, declaration = compiled(v, quick=True), package(v).declarations[-1]
    first, second = (CompiledController(module, declaration) for _ in range(2))
    for each in (first, second):
        each.call("reset", {"position_x": path[0, 0], "position_y": path[0, 1]})
    state: dict[str, Value] = {port.name: 0.0 for port in declaration.operation("predict").inputs}
    state |= {"x_position": path[0, 0], "y_position": path[0, 1]}
    given, window = 0, np.zeros((2, v.points))
    for period in range(40):
        state = first.call("predict", state)[1]
        count = min(v.points, len(path) - 1 - given)
        window[:, :count] = path[given + 1 : given + 1 + count].T
        lost = period % 7 == 6
        asked = {
            **(dict.fromkeys(state, float("nan")) if lost else state),
            "points_x": window[0], "points_y": window[1], "n_points": count,
        }  # fmt: skip
        told = first.call("plan", asked)
        fast = [first.call("fast_step") for _ in range(v.points - 1)]
        assert fast == [second.call("fast_step") for _ in range(v.points - 1)]
        assert told == second.call("plan", asked)
        assert bytes(first._ffi.buffer(first.memory)) == bytes(second._ffi.buffer(second.memory))
        assert first.call("start") == second.call("start")
        given += int(told[1]["points_taken"])
    assert given > 10 * v.points
