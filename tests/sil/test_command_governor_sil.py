"""The extended command governor of both axes: the C is its reference, indices and all."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from core_designs import temporary_folder
from governor_designs import SHAPES, alike, governor, package, standing_calls

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_declaration import AXES
from servogen.controllers.command_governor_design import CommandGovernorDesign
from servogen.controllers.design import Status, Value
from servogen.evidence.bench import Subject
from servogen.evidence.counts_run import count_runs
from servogen.sil.build import compile_package
from servogen.sil.command_governor_calls import command_governor_calls
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import compare
from servogen.sil.player import DIRT, Play
from servogen.steps.counted import count_emitted

# One worker: one module.
pytestmark = pytest.mark.xdist_group("governor")
both = pytest.mark.parametrize("name", ["float64", "float32"])


@cache
def module() -> Any:
    packages = [package(design(name)) for name in SHAPES]
    return compile_package(packages, temporary_folder("governor"), ["-O0"])


def design(name: str) -> CommandGovernorDesign:
    """Of one shape each axis has tables of its own."""
    own = governor(SHAPES[name])
    return own if name == "float64" else alike(own)


def in_c(name: str) -> CompiledController:
    return CompiledController(module(), CommandGovernor(design(name)).declaration)


@pytest.mark.parametrize("name", SHAPES)
def test_edges_and_random_calls_agree_bit_for_bit(name: str) -> None:
    own = design(name)
    edges = list(edge_calls(CommandGovernor(own).declaration))
    seen: set[str] = set()
    for calls in (edges, list(command_governor_calls(own, np.random.default_rng(2), 200))):
        agreement = compare(CommandGovernor(own), in_c(name), calls)
        assert agreement.passed, agreement.difference
        assert agreement.worst == 0.0
        assert agreement.calls == len(calls)
        seen |= set(agreement.statuses)
    wanted = {"OK", "FINISHED", "INFEASIBLE", "NOT_FINITE", "OUT_OF_RANGE", "NOT_READY"}
    assert wanted <= seen
    assert "BACKUP" in seen or "cap" not in name


def resting(name: str, where: float, **other: Value) -> dict[str, Value]:
    window = design(name).window
    state = {"position": where, "velocity": 0.0, "acceleration": 0.0}
    points = {f"{k}_{a}": np.full(window, where) for k in ("points", "slow") for a in AXES}
    own = {f"{a}_{k}": value for a in AXES for k, value in state.items()}
    return {**own, **points, "n_points": window, **other}


@both
def test_statuses_from_before_the_reset_to_the_end_of_the_path(name: str) -> None:
    own, controller = design(name), in_c(name)
    real, window = own.precision.dtype.type, own.window
    status, out = controller.call("step", resting(name, 0.1))
    assert (status, out["points_taken"], out["command_x"]) == (Status.NOT_READY, 0, 0.0)
    assert out["status_x"] == out["status_y"] == int(Status.NOT_READY)
    start = {"position_x": 0.1, "position_y": 9.0}
    assert controller.call("reset", start)[0] is Status.OUT_OF_RANGE
    status, out = controller.call("step", resting(name, 0.1))
    assert (status, out["command_x"], out["command_y"]) == (Status.NOT_READY, real(0.1), 0.125)
    assert controller.call("reset", {"position_x": 0.1, "position_y": 0.1})[0] is Status.OK
    status, out = controller.call("step", resting(name, 0.1))
    assert (status, out["points_taken"]) == (Status.OK, own.points)
    none = np.full(window, np.nan)
    for bad, said in (
        ({"x_velocity": np.nan}, Status.NOT_FINITE),
        ({"slow_y": none}, Status.NOT_FINITE),
        ({"n_points": window + 1}, Status.OUT_OF_RANGE),
        ({"n_points": -1}, Status.OUT_OF_RANGE),
        ({"points_x": np.full(window, 1.0)}, Status.OUT_OF_RANGE),
    ):
        status, out = controller.call("step", resting(name, 0.1, **bad))
        assert (status, out["points_taken"], out["iterations_x"]) == (said, 0, 0)
        assert out["status_x"] == out["status_y"] == int(said)
        assert out["command_x"] == out["command_y"] == real(0.1)
    far = resting(name, 0.1, x_position=0.2)
    status, out = controller.call("step", far)
    assert (status, out["points_taken"]) == (Status.INFEASIBLE, 0)
    nothing = resting(name, 0.1, n_points=0, points_x=none, slow_y=none)
    status, out = controller.call("step", nothing)
    assert (status, out["points_taken"]) == (Status.FINISHED, 0)
    assert controller.call("step", resting(name, 0.1))[1]["points_taken"] == own.points


@pytest.mark.parametrize("name", ["at the cap", "at the cap, float32"])
def test_stages_that_stay_at_the_cap_are_told_to_be_unreachable_and_go_on(name: str) -> None:
    """After their patience, and not before; without points finished, points in reach are taken."""
    own, controller = design(name), in_c(name)
    patience, seen = own.axes[0].patience, list[Status]()
    for call in standing_calls(own, more=30):
        status, out = controller.call(call.operation, call.inputs)
        seen.append(status)
    first = seen.index(Status.UNREACHABLE)
    assert seen[first - patience + 1 : first] == [Status.BACKUP] * (patience - 1)
    assert seen.count(Status.BACKUP) - (patience - 1) < patience
    assert set(seen[first:-2]) == {Status.UNREACHABLE}
    assert seen[-2] is Status.FINISHED
    assert out["points_taken"] == own.points
    agreement = compare(CommandGovernor(own), in_c(name), standing_calls(own, more=30))
    assert agreement.passed, agreement.difference


@both
def test_two_instances_in_dirty_memory_know_nothing_of_each_other(name: str) -> None:
    own = design(name)
    runs = [list(command_governor_calls(own, np.random.default_rng(k), 40)) for k in (5, 6)]
    controllers, references = [], [CommandGovernor(own), CommandGovernor(own)]
    for _ in range(2):
        controller = in_c(name)
        dirt = np.frombuffer(controller._ffi.buffer(controller.memory), dtype=np.uint8)
        dirt[:] = DIRT
        getattr(controller._lib, f"{controller.declaration.prefix}_init")(controller.memory)
        controllers.append(controller)
    for pair in zip(*runs, strict=False):
        for call, reference, controller in zip(pair, references, controllers, strict=True):
            status, out = reference.call(call.operation, call.inputs)
            told, given = controller.call(call.operation, call.inputs)
            assert told is status
            for port, value in out.items():
                np.testing.assert_array_equal(given[port], value)


def test_the_worst_case_is_counted_and_never_exceeded() -> None:
    own = design("float32")
    made = package(own)
    p, rng = own.prefix, np.random.default_rng(3)
    plays = [
        Play("random", p, tuple(command_governor_calls(own, rng, 200))),
        Play("edges", p, tuple(edge_calls(made.declarations[-1]))),
    ]
    subject = Subject(made, own.precision, count_emitted(made), lambda _: plays, lambda _: plays)
    step = count_runs(subject, plays).entries[f"{p}_step"]
    assert step.calls > 400
    assert step.above is None
    assert step.unequal is None
    assert 0.3 < step.closest <= 1.0
