"""One axis of the extended command governor: the C is its reference, and its mutants are found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from core_designs import temporary_folder
from governor_designs import SHAPES, Shape, axis

from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_declaration import declare_axis_governor
from servogen.controllers.command_governor_design import AxisGovernorDesign
from servogen.controllers.design import Status
from servogen.emit.package import CPackage, emit_package
from servogen.sil.build import compile_package
from servogen.sil.command_governor_calls import axis_governor_calls, waiting_axis_calls
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call, compare
from servogen.sil.player import DIRT

# One worker: the mutants are one module.
pytestmark = pytest.mark.xdist_group("governor axis")
both = pytest.mark.parametrize("name", ["float64", "float32"])


def package(shape: Shape) -> CPackage:
    return emit_package(f"{shape.prefix}p", (declare_axis_governor(axis(shape)),))


@cache
def module() -> Any:
    packages = [package(shape) for shape in SHAPES.values()]
    return compile_package(packages, temporary_folder("governor-axis"), ["-O0"])


def in_c(name: str) -> CompiledController:
    return CompiledController(module(), declare_axis_governor(axis(SHAPES[name])))


@pytest.mark.parametrize("name", SHAPES)
def test_edges_and_random_calls_agree_bit_for_bit(name: str) -> None:
    design = axis(SHAPES[name])
    seen: set[str] = set()
    for seed in range(2):
        rng = np.random.default_rng(seed)
        calls = list(axis_governor_calls(design, rng, 120))
        if seed:
            calls = list(edge_calls(declare_axis_governor(design)))
        agreement = compare(AxisGovernor(design), in_c(name), calls)
        assert agreement.passed, agreement.difference
        assert agreement.worst == 0.0
        assert agreement.calls == len(calls)
        seen |= set(agreement.statuses)
    assert {"OK", "NOT_FINITE", "OUT_OF_RANGE", "NOT_READY", "INFEASIBLE"} <= seen
    assert "BACKUP" in seen or "cap" not in name


def resting(name: str, where: float, stroke: float = 0.025) -> dict[str, Any]:
    """A stage at rest and a point of the path where it is."""
    design = axis(SHAPES[name])
    wide = np.ones(design.intervals)
    return {
        "position": where, "velocity": 0.0, "acceleration": 0.0,
        "reference": np.full(design.program.variables, where),
        "low": (where - stroke) * wide, "high": (where + stroke) * wide,
    }  # fmt: skip


@pytest.mark.parametrize("name", ["at the cap", "at the cap, float32"])
def test_at_the_cap_the_moved_plan_goes_on(name: str) -> None:
    """Property (b) in the C: every command is the one planned before, and none is infeasible."""
    design, controller = axis(SHAPES[name]), in_c(name)
    controller.call("reset", {"position": 0.1})
    own = AxisGovernor(design)
    own.call("reset", {"position": 0.1})
    backups, state = 0, np.array([0.1, 0.0, 0.0])
    a, b = design.plant.a, design.plant.b
    for k in range(60):
        inputs = resting(name, float(state[0]))
        inputs |= dict(zip(("position", "velocity", "acceleration"), state, strict=True))
        wish = 0.1 + 0.02 * np.sin(0.5 * k)
        inputs["reference"] = np.full(design.program.variables, wish)
        inputs["low"] = np.full(design.intervals, wish - 0.022)
        inputs["high"] = np.full(design.intervals, wish + 0.022)
        planned = own.moved()[0]
        status, out = controller.call("step", inputs)
        assert own.call("step", inputs)[0] is status
        assert status in (Status.OK, Status.BACKUP, Status.INFEASIBLE)
        if status is not Status.OK:
            assert out["command"] == planned
        backups += status is Status.BACKUP
        state = a @ state + b * float(np.asarray(out["command"]))
    assert backups >= 5


@both
def test_a_plan_that_no_longer_fits_is_told_and_held(name: str) -> None:
    """Windows that contradict: INFEASIBLE, the command planned before, nothing of it left."""
    design, controller = axis(SHAPES[name]), in_c(name)
    controller.call("reset", {"position": 0.1})
    apart = resting(name, 0.1)
    apart["low"], apart["high"] = apart["low"] + 0.1, apart["high"] - 0.1
    status, out = controller.call("step", apart)
    assert status is Status.INFEASIBLE
    assert out["command"] == design.precision.dtype.type(0.1)
    assert controller.call("step", resting(name, 0.1))[0] is Status.OK


@both
def test_two_instances_in_dirty_memory_know_nothing_of_each_other(name: str) -> None:
    design = axis(SHAPES[name])
    first = list(axis_governor_calls(design, np.random.default_rng(5), 30))
    second = list(axis_governor_calls(design, np.random.default_rng(6), 30))
    controllers = []
    for _ in range(2):
        controller = in_c(name)
        dirt = np.frombuffer(controller._ffi.buffer(controller.memory), dtype=np.uint8)
        dirt[:] = DIRT
        getattr(controller._lib, f"{controller.declaration.prefix}_init")(controller.memory)
        controllers.append(controller)
    references = [AxisGovernor(design), AxisGovernor(design)]
    assert in_c(name).call(first[0].operation, first[0].inputs)[0] is Status.OK
    for pair in zip(first, second, strict=False):
        for call, reference, controller in zip(pair, references, controllers, strict=True):
            status, out = reference.call(call.operation, call.inputs)
            told, given = controller.call(call.operation, call.inputs)
            assert told is status
            for port, value in out.items():
                np.testing.assert_array_equal(given[port], value)


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    return change


MUTANTS: dict[str, Callable[[str], str]] = {
    "the plan is not moved": swap("sg_shift(CORE_VARIABLES, moved,", "sg_shift(0 + 1, moved,"),
    "positions count from zero": swap("plan[i] - origin;", "plan[i];"),
    "references count from zero": swap("in->reference[i] - origin;", "in->reference[i];"),
    "an answer from the position": swap("self->relative[i] + origin;", "self->relative[i];"),
    "the middle of the range": swap("(core_centre - origin)", "(-origin)"),
    "no row moves": swap("(core_step_moves[i] == 1)", "(core_step_moves[i] == 2)"),
    "no row of the end moves": swap("(core_end_moves[i] == 1)", "(core_end_moves[i] == 2)"),
    "high for low": swap("((in->low[interval] - origin)", "((in->high[interval] - origin)"),
    "settling is not kept": swap("core_position_scale) - settle;", "core_position_scale);"),
    "the next interval": swap("core_allow(self, row, k + 1,", "core_allow(self, row, k,"),
    "all that follows": swap("core_allow(self, row, CORE_INTERVALS - 1", "core_allow(self, row, 0"),
    "margin of the upper sides": swap("(middle + limit) - core_margin;", "(middle + limit);"),
    "margin of the positions": swap("low + core_margin);", "low);"),
    "a plan that is not judged": swap("status = core_judge(self, origin, plan);", ""),
    "judged by the bounds drawn in": swap("(self->above[i] + core_margin)", "self->above[i]"),
    "a velocity that is not scaled": swap("state[i] * core_start_scale[i]", "state[i]"),
    "the state predicted": swap("core_b[i] * self->plan[0]", "core_b[i] * self->plan[1]"),
    "in reach where it begins": swap("out->least[0] = (sg_real)0;", ""),
    "the stroke of what is in reach": swap(
        "(out->greatest[i] + core_in_reach)", "(out->greatest[i] - core_in_reach)"
    ),
    "what is in reach settles": swap("position + settle);", "position);"),
    "the next sample": swap("core_advance(self, state, ahead);\n    }", "}"),
    "a bad measurement is foreseen from": swap(
        "(status == SG_OK) ? in->velocity : self->predicted[1]", "in->velocity"
    ),
    "a set that outlives its reset": swap(
        "self->waited = 0;\n    core_forget(self);", "self->waited = 0;"
    ),
    "never ready": swap("self->ready = (status == SG_OK) ? 1 : 0;", "self->ready = 1;"),
    "held without moving": swap(
        "core_move(self, plan);\n    core_accept",
        "sg_copy(CORE_VARIABLES, self->plan, plan);\n    core_accept",
    ),
    "foreseen before a reset": swap(
        "if (self->ready == 0) {\n        status = SG_NOT_READY;", "if (self->ready == 0) {"
    ),
    "no command before a reset": swap("(self->ready == 0) ? core_centre : ", ""),
    "where it will be does not matter": swap("stands *= core_near(self->predicted[0], rest);", ""),
    "nor where it is sent": swap("stands *= core_near(self->plan[i], rest);", ""),
    "below is near": swap("where < (rest - core_standing)", "where < (rest - core_farthest)"),
    "above is near": swap("where > (rest + core_standing)", "where > (rest + core_farthest)"),
    "the references are always kept": swap("(excess > core_tolerance) ? 0 : 1", "1"),
    "begun anew at rest": swap("if (self->waited > 0) {", "if (self->waited < 0) {"),
    "the row that was to enter is lost": swap("(self->pending == 1)", "(self->pending > 1)"),
    "it enters in every call": swap("    self->pending = 0;\n    if (entering", "    if (entering"),
    "multipliers begin anew": swap(
        "core_less(self, self->dual, z);\n    core_rows",
        "sg_fill(CORE_VARIABLES, (sg_real)0, self->dual);\n    core_rows",
    ),
    "nothing is missed": swap(
        "self->dual[i] = (sg_real)0;\n            self->missed[i] = (sg_real)0;\n        }",
        "self->dual[i] = (sg_real)0;\n        }\n        self->missed[i] = (sg_real)0;",
    ),
    "patience without end": swap("(self->waited == CORE_PATIENCE)", "(self->waited < 0)"),
    "patience ends a step early": swap(
        "(self->waited == CORE_PATIENCE)", "(self->waited >= (CORE_PATIENCE - 1))"
    ),
    "patience does not begin anew": swap(
        "self->waited = 0;\n    core_drop_stalled(self);", "core_drop_stalled(self);"
    ),
    "patience outlives a reset": swap(
        "self->waited = 0;\n    core_forget(self);", "core_forget(self);"
    ),
    "a stage that moves is patient too": swap("SG_BACKUP) ? standing", "SG_BACKUP) ? 1"),
}  # fmt: skip


def renamed(number: int) -> Shape:
    return Shape(f"mutant{number}", cap=3, horizon=4)


@cache
def mutants() -> Any:
    packages = [package(renamed(len(MUTANTS)))]
    for number, change in enumerate(MUTANTS.values()):
        shape = renamed(number)
        made, prefix = package(shape), axis(shape).prefix
        file = f"{prefix}.c"
        text = made.files[file].replace(prefix, "core").replace(prefix.upper(), "CORE")
        changed = change(text).replace("core_", f"{prefix}_").replace("core.h", f"{prefix}.h")
        changed = changed.replace("CORE_", f"{prefix.upper()}_")
        packages.append(replace(made, files={**made.files, file: changed}, hash=made.hash[::-1]))
    return compile_package(packages, temporary_folder("governor-mutants"), ["-O0", "-Wno-error"])


@cache
def calls() -> list[Call]:
    design = axis(renamed(0))
    some = list(axis_governor_calls(design, np.random.default_rng(7), 300))
    waits = list(waiting_axis_calls(design, np.random.default_rng(1)))
    # patience cut short by a reset, and waiting that begins anew
    edges = edge_calls(declare_axis_governor(design))
    return [*edges, *some, *waits[: design.patience], *hard_from_rest(design, 6), *waits]


def hard_from_rest(design: AxisGovernorDesign, count: int) -> list[Call]:
    """A reset and steps from there, most of which end at the cap: a reference that jumps."""
    rng, size, stroke = np.random.default_rng(0), design.program.variables, design.program.stroke_m
    made = [Call("reset", {"position": 0.1})]
    for _ in range(count):
        step = resting("float64", 0.1, 0.002 * stroke)
        jumps = rng.choice([-1.0, 1.0], size) * rng.choice([0.1, 1.0, 10.0], size)
        made.append(Call("step", step | {"reference": np.clip(0.1 + stroke * jumps, 0.0, 0.25)}))
    return made


def found(shape: Shape) -> str:
    """The first thing that these calls say of the C of the shape; empty for nothing."""
    reference = AxisGovernor(axis(shape))
    agreement = compare(reference, CompiledController(mutants(), reference.declaration), calls())
    return "" if agreement.passed else str(agreement.difference)


def test_the_unchanged_package_agrees() -> None:
    assert found(renamed(len(MUTANTS))) == ""


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_found(name: str) -> None:
    told = found(renamed(list(MUTANTS).index(name)))
    assert told, f"nothing noticed the mutant {name!r}"
