"""Minimal motion of a streamed path: the C is its reference, the reference is the whole path's
where the window sees far enough, and what holds for any window."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import chain, repeat
from math import fsum
from typing import Any

import numpy as np
import pytest
from core_designs import temporary_folder
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from servogen.controllers.design import Declaration, Port, Status, Value
from servogen.controllers.errors import DesignError
from servogen.controllers.motion_window import MotionWindow
from servogen.controllers.motion_window_design import MotionWindowDesign, declare_motion_window
from servogen.emit.package import CPackage, emit_package
from servogen.paths.minimal_motion import look_ahead, minimal_motion, tube_around
from servogen.precision import PRECISIONS
from servogen.sil.build import Module, compile_package
from servogen.sil.compiled import CompiledController
from servogen.sil.edges import edge_calls
from servogen.sil.harness import Call, compare
from servogen.sil.motion_calls import motion_window_calls, random_pattern
from servogen.sil.player import struct_layout
from servogen.wcet.dynamic import build_counted
from servogen.wcet.package import count_package

Array = NDArray[np.float64]
# window, block, free end: one by one, a block longer than the window, and as they are used
SHAPES = {"single": (1, 1, False), "short": (3, 8, True), "even": (12, 4, False),
          "long": (60, 10, True)}  # fmt: skip
REACH, LIMIT = 0.02, 0.1


def design(shape: str, precision: str = "float64") -> MotionWindowDesign:
    window, block, free = SHAPES[shape]
    return MotionWindowDesign(
        shape, PRECISIONS[precision], window, block, REACH, LIMIT, 0.01, free_end=free
    )


def package(precision: str) -> CPackage:
    own = tuple(declare_motion_window(design(shape, precision)) for shape in SHAPES)
    return emit_package("motion", own)


@cache
def compiled(precision: str) -> Module:
    return compile_package([package(precision)], temporary_folder(f"motion_{precision}"))


def in_c(shape: str, precision: str = "float64") -> CompiledController:
    return CompiledController(compiled(precision), declare_motion_window(design(shape, precision)))


def stream(
    controller: MotionWindow | CompiledController,
    path: Array,
    start: float,
    sizes: Iterator[int] | None = None,
) -> tuple[Array, Array]:
    """All references of a path, and whether each was said to be settled."""
    outputs = controller.declaration.operation("step").outputs
    block = outputs[0].size
    assert controller.call("reset", {"start": start})[0] is Status.OK
    references, settled, at, status = [], [], 0, Status.OK
    while status is not Status.FINISHED:
        some = path[at : at + (block if sizes is None else next(sizes))]
        at += some.size
        points = np.zeros(block)
        points[: some.size] = some
        inputs = {"points": points, "n_points": some.size, "ended": int(at == path.size)}
        status, out = controller.call("step", inputs)
        assert status in (Status.PRIMING, Status.OK, Status.FINISHED)
        count, decided = int(np.asarray(out["n_references"])), int(np.asarray(out["n_decided"]))
        references.append(np.asarray(out["reference"], dtype=np.float64)[:count])
        settled.append(np.arange(count) < decided)
    return np.concatenate(references), np.concatenate(settled)


def some_path(shape: str, seed: int, size: int = 0) -> tuple[Array, float]:
    """A pattern, and a start within reach of its first point."""
    rng = np.random.default_rng(seed)
    path = np.asarray(random_pattern(design(shape), rng, size or int(rng.integers(1, 300))))
    return path, float(np.clip(path[0] + REACH * rng.uniform(-1.0, 1.0), -LIMIT, LIMIT))


def whole(path: Array, start: float, free_end: bool) -> Array:
    lower, upper = tube_around(path, REACH)
    end = None if free_end or path.size == 1 else float(path[-1])
    return minimal_motion(lower, upper, start=start, end=end)


def distance(x: Array) -> float:
    return fsum(np.abs(np.diff(x)).tolist())


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_c_is_the_reference_bit_for_bit(precision: str) -> None:
    for number, shape in enumerate(SHAPES):
        own = design(shape, precision)
        rng = np.random.default_rng(10 * number)
        calls = [*edge_calls(declare_motion_window(own)), *motion_window_calls(own, rng, 1000)]
        agreement = compare(MotionWindow(own), in_c(shape, precision), calls)
        assert agreement.passed, (shape, agreement.difference)
        assert agreement.worst == 0.0
        assert agreement.calls == len(calls)
        expected = {"OK", "PRIMING", "FINISHED", "INFEASIBLE", "OVERFLOW", "NOT_FINITE",
                    "OUT_OF_RANGE", "NOT_READY"}  # fmt: skip
        assert set(agreement.statuses) == expected, shape


@pytest.mark.parametrize("shape", SHAPES)
def test_a_window_that_sees_far_enough_gives_the_motion_of_the_whole_path(shape: str) -> None:
    tried, late = 0, 0
    for seed in range(25):
        path, start = some_path(shape, seed)
        lower, upper = tube_around(path, REACH)
        free = design(shape).free_end
        end = None if free or path.size == 1 else float(path[-1])
        need = max(1, look_ahead(lower, upper, start=start, end=end))
        x, settled = stream(MotionWindow(replace(design(shape), window=need)), path, start)
        np.testing.assert_allclose(x, whole(path, start, free), rtol=0.0, atol=1e-14)
        assert settled.all()
        if need == 1:
            continue
        tried += 1
        shorter = replace(design(shape), window=need - 1, block=1)
        late += not stream(MotionWindow(shorter), path, start)[1].all()
    assert tried > 10
    assert late >= 0.9 * tried  # pieces in one line are known before their knots are


@pytest.mark.parametrize("shape", SHAPES)
def test_any_window_keeps_the_tube_and_covers_the_least_distance(shape: str) -> None:
    for seed in range(150):
        path, start = some_path(shape, 1000 + seed)
        controller, own = in_c(shape), design(shape)
        sizes = np.random.default_rng(seed).integers(1, own.block + 1, path.size).tolist()
        x, settled = stream(controller, path, start, chain(sizes, repeat(1)) if seed % 2 else None)
        assert x.size == path.size
        assert x[0] == start
        assert np.all((x[1:] >= path[1:] - REACH) & (x[1:] <= path[1:] + REACH))
        best = whole(path, start, own.free_end)
        if own.free_end:
            assert distance(x) <= distance(best) + 1e-12
        else:
            assert x[-1] == path[-1] or path.size == 1
            assert distance(x) <= distance(best) + 4.0 * REACH
        if settled.all():
            np.testing.assert_allclose(x, best, rtol=0.0, atol=1e-14)
        assert np.all(x >= min(start, path.min()) - 1e-15)
        assert np.all(x <= max(start, path.max()) + 1e-15)


def test_in_single_precision_the_tube_is_kept_to_its_last_place() -> None:
    """Twice an ulp of a coordinate: one of the bound, one of the point."""
    for seed in range(40):
        path, start = some_path("even", seed)
        x, _ = stream(in_c("even", "float32"), path, start)
        assert np.all(np.abs(x - path) <= REACH + 2.0 * np.spacing(np.float32(LIMIT)))
        assert x.size == path.size


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 30), st.integers(1, 12))
def test_what_is_settled_no_further_point_changes(seed: int, window: int, block: int) -> None:
    """Up to the first that is not said to be, with two ways in which the path goes on."""
    path, start = some_path("even", seed, 60)
    own = replace(design("even"), window=window, block=block, free_end=True)
    x, settled = stream(MotionWindow(own), path, start)
    settled = settled[: max(60 // block * block - window - block, 0)]  # before the end was told
    until = settled.size if settled.all() else int(np.argmin(settled))
    for far in (-LIMIT, LIMIT):
        lower, upper = tube_around(np.append(path[: until + window + block], far), REACH)
        other = minimal_motion(lower, upper, start=start)
        np.testing.assert_allclose(x[:until], other[:until], rtol=0.0, atol=1e-13)


def test_of_a_level_path_nothing_moves_and_of_a_wire_nothing_is_late() -> None:
    x, _ = stream(in_c("even"), np.full(100, 0.03), 0.03)
    assert np.all(x == 0.03)
    wire = replace(design("even"), reach_m=1e-9)
    path, _ = some_path("even", 5, 200)
    x, _ = stream(MotionWindow(wire), path, float(path[0]))
    np.testing.assert_allclose(x, path, rtol=0.0, atol=1.0000001e-9)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_inputs_of_no_use_leave_the_path_as_it_was(precision: str) -> None:
    path, start = some_path("even", 3, 80)
    clean, _ = stream(in_c("even", precision), path, start)
    for kind in (MotionWindow(design("even", precision)), in_c("even", precision)):
        kind.call("reset", {"start": start})
        found: list[float] = []
        for at in range(0, 80, 4):
            for value, status in (
                (np.nan, Status.NOT_FINITE),
                (-np.inf, Status.NOT_FINITE),
                (1.001 * LIMIT, Status.OUT_OF_RANGE),
            ):
                bad = np.append(path[at : at + 3], value)
                said, out = kind.call("step", {"points": bad, "n_points": 4, "ended": 1})
                assert said is status
                assert (out["n_references"], out["n_decided"]) == (0, 0)
                held = np.asarray(out["reference"])
                np.testing.assert_array_equal(held, np.full(4, held[0]))
                assert held[0] == (found[-1] if found else held.dtype.type(start))
            inputs = {"points": path[at : at + 4], "n_points": 4, "ended": int(at == 76)}
            said, out = kind.call("step", inputs)
            found += np.asarray(out["reference"])[: int(np.asarray(out["n_references"]))].tolist()
        while said is not Status.FINISHED:
            said, out = kind.call("step", {"points": np.zeros(4), "n_points": 0, "ended": 1})
            found += np.asarray(out["reference"])[: int(np.asarray(out["n_references"]))].tolist()
        np.testing.assert_array_equal(found, clean)


def test_statuses_of_a_path_from_before_its_reset_to_after_its_end() -> None:
    block = {"points": np.full(4, 0.05), "n_points": 4, "ended": 0}
    for kind in (MotionWindow(design("even")), in_c("even")):
        assert kind.call("step", block)[0] is Status.NOT_READY
        assert kind.call("reset", {"start": 2.0 * LIMIT})[0] is Status.OUT_OF_RANGE
        assert kind.call("step", block)[0] is Status.NOT_READY
        assert kind.call("reset", {"start": 0.0299})[0] is Status.OK
        status, out = kind.call("step", block)
        assert status is Status.INFEASIBLE
        np.testing.assert_array_equal(out["reference"], np.full(4, 0.0299))
        kind.call("reset", {"start": 0.0301})
        said = [kind.call("step", block)[0] for _ in range(4)]
        assert said == [Status.PRIMING, Status.PRIMING, Status.OK, Status.OK]
        assert kind.call("step", {**block, "n_points": 0})[0] is Status.OK
        ending = {**block, "n_points": 0, "ended": 1}
        assert kind.call("step", ending)[0] is Status.OK
        assert kind.call("step", block)[0] is Status.OVERFLOW
        assert [kind.call("step", {**ending, "ended": 0})[0] for _ in range(2)] == [
            Status.OK,
            Status.FINISHED,
        ]
        status, out = kind.call("step", ending)
        assert status is Status.FINISHED
        assert out["n_references"] == 0
        np.testing.assert_array_equal(out["reference"], np.full(4, 0.05))
        assert kind.call("reset", {"start": 0.0})[0] is Status.OK
        assert kind.call("step", ending)[0] is Status.FINISHED  # a path without points


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_worst_case_is_counted_and_never_exceeded(precision: str) -> None:
    made = package(precision)
    folder = temporary_folder(f"motion_count_{precision}")
    made.write(folder)
    sources = [folder / file for file in made.sources]
    steps = [f"{shape}_step" for shape in SHAPES]
    counts = count_package(sources, [folder], steps).entry_points
    library = build_counted(sources, [folder], folder / "counted")
    for number, shape in enumerate(SHAPES):
        own = design(shape, precision)
        declaration = declare_motion_window(own)
        assert counts[f"{shape}_step"].caps == {}
        bound = counts[f"{shape}_step"].total()
        memory = np.zeros(1 + len(in_c(shape, precision).memory))
        getattr(library.functions, f"{shape}_init")(address(memory))
        for call in motion_window_calls(own, np.random.default_rng(number), 150):
            operation = declaration.operation(call.operation)
            arguments = [filled(operation.inputs, declaration, call.inputs)]
            if operation.outputs:
                arguments.append(np.zeros(1, struct_layout(operation.outputs, declaration)))
            library.reset()
            entry = getattr(library.functions, f"{shape}_{call.operation}")
            entry(address(memory), *(address(argument) for argument in arguments))
            if call.operation == "step":
                ran = library.read()
                assert bound.covers(ran), f"{shape}: {ran} above {bound}"


def filled(
    ports: Sequence[Port], declaration: Declaration, inputs: Mapping[str, Value]
) -> NDArray[np.void]:
    struct = np.zeros(1, struct_layout(ports, declaration))
    for port in ports:
        struct[port.name] = inputs[port.name]
    return struct


def address(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def test_a_path_that_takes_every_change_there_is() -> None:
    """Bounds that all enter a chain and all leave it again, before the last of the block."""
    own = design("long")
    size = own.room
    t = np.arange(size)
    path = 0.01 * (t / size) ** 2  # convex: the upper chain keeps all, until the tube falls
    path[-1] = -LIMIT
    calls = [Call("reset", {"start": float(path[0])})]
    for at in range(0, size, own.block):
        calls.append(Call("step", {"points": path[at : at + own.block], "n_points": own.block,
                                   "ended": 0}))  # fmt: skip
    agreement = compare(MotionWindow(own), in_c("long"), calls)
    assert agreement.passed, agreement.difference
    assert agreement.statuses["OK"] >= 1


def test_a_design_that_cannot_be_is_refused() -> None:
    sound = design("even")
    for key, value in (
        ("window", 0),
        ("block", 0),
        ("reach_m", 0.0),
        ("reach_m", np.nan),
        ("limit_m", -1.0),
        ("limit_m", np.inf),
        ("sample_time_s", 0.0),
    ):
        with pytest.raises(DesignError, match=key):
            replace(sound, **{key: value})
    with pytest.raises(DesignError, match="window is 16777216"):
        replace(design("even", "float32"), window=2**24 - 4)
