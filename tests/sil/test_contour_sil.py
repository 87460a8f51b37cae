"""The contour controller's C is its reference, bit for bit, and does what its paper asks."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from contour_designs import NAMES, in_c, made, package
from contour_machine import CASES, batch_input

from servogen.controllers.contour_estimate import wanted_state
from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.design import Status
from servogen.plants.machining_centre import SAMPLE_TIME_S, machining_centre
from servogen.sil.contour_calls import contour_calls
from servogen.sil.contour_scenarios import contour_suite
from servogen.sil.harness import Call, Stepwise, Twin, compare
from servogen.sil.player import DIRT
from servogen.steps.counted import count_emitted
from servogen.systems.contour_loop import ContourRun, run_contour
from servogen.systems.contour_motion import ContourMotion, at_feed, butterfly, circle

pytestmark = pytest.mark.xdist_group("contour")
AXES = machining_centre()
TURN, SETTLED = 251, 60


@pytest.mark.parametrize("name", NAMES)
def test_edges_and_random_calls_agree_bit_for_bit(name: str) -> None:
    design, seen = made(name), set()
    for scenario in contour_suite(design, 3, 240):
        agreement = compare(scenario.reference(), in_c(name), scenario.calls)
        assert agreement.passed, f"{scenario.name}: {agreement.difference}"
        assert agreement.worst == 0.0
        assert agreement.calls == len(scenario.calls)
        seen |= set(agreement.statuses)
    assert seen == {"OK", "PRIMING", "NOT_FINITE", "OUT_OF_RANGE", "NOT_READY"}


def looped(
    name: str, motion: ContourMotion, samples: int, encoder_m: float | None = None
) -> ContourRun:
    """The closed loop on the C, with the reference beside it."""
    twin = Twin(Stepwise(ContourLq(made(name))), in_c(name))
    found = run_contour(made(name), twin, AXES, motion, samples, encoder_m)
    assert twin.agreement.passed, twin.agreement.difference
    assert twin.agreement.worst == 0.0
    assert twin.agreement.calls == samples + 1
    return found


CIRCLE = circle(1e-3, 0.05, SAMPLE_TIME_S, TURN + SETTLED + 20)


@pytest.mark.parametrize("case", CASES)
def test_float32_in_the_loop_costs_less_than_a_hundredth_of_a_micrometre(case: str) -> None:
    """On the paper's circle, by the C."""
    runs = [looped(f"{case} {bits}", CIRCLE, TURN + SETTLED) for bits in (64, 32)]
    assert all(np.all(found.status == Status.OK) for found in runs)
    for error in (ContourRun.tracking_rms_m, ContourRun.contour_rms_m):
        wide, narrow = (1e6 * error(found, TURN) for found in runs)
        assert abs(narrow - wide) < 2e-3, (wide, narrow)


def test_a_butterfly_and_the_encoders() -> None:
    motion = at_feed(lambda turn: 1e-3 * butterfly(turn), 0.35, 0.05, SAMPLE_TIME_S)
    for name in ("II 64", "IV 32", "table, float32"):
        found = looped(name, motion, 400, encoder_m=0.8e-6)
        assert np.all(found.status == Status.OK)
        assert 1e6 * found.contour_rms_m(300) < 3.0


def pieces() -> ContourMotion:
    """A square with a stop in each corner, points that repeat, the way back on the last side."""
    side = np.linspace(0.0, 1e-3, 41)[1:]
    corners = 1e-3 * np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0], [0, 1]])
    parts = [np.zeros((15, 2))]
    for here, there in pairwise(corners):
        way = here + np.outer(side / 1e-3, there - here)
        parts += [np.repeat(way, 2, axis=0) if there[0] == 0 else way, np.tile(way[-1], (7, 1))]
    parts.append(np.tile(corners[-1], (60, 1)))
    return ContourMotion(np.vstack(parts), lambda points, first: np.zeros(len(points)))


@pytest.mark.parametrize("name", ["II 64", "II 32", "IV 64", "table", "table, float32"])
def test_stops_repeats_corners_and_ways_back(name: str) -> None:
    """Finite commands all along, a status, and the axes where they ought to be in the end."""
    motion = pieces()
    found = looped(name, motion, len(motion.points) - 10)
    assert np.all(np.isfinite(found.command))
    assert Counter(found.status.tolist()).keys() == {Status.PRIMING, Status.OK}
    assert np.all(found.known[found.status == Status.PRIMING] == 0)
    assert np.max(np.abs(found.output[-1] - motion.points[-1])) < 1e-6


def tangents_of(points: np.ndarray) -> np.ndarray:
    """(N, p) along a smooth contour, as docs/contour.md says, of points 0..N."""
    way = np.diff(points, axis=0)
    way = way / np.max(np.abs(way), axis=1)[:, None]
    last, before = way[-1], way[-2:][0]
    behind = np.vstack([way[1:], 2.0 * (last @ before) / (last @ last) * last - before])
    found = []
    for b, a in zip(way, behind, strict=True):
        squared = (b @ a) ** 2 / ((b @ b) * (a @ a))
        middle = a + b if a @ b >= 0.0 else b - a
        found.append(squared * (2.0 - squared) * middle / np.linalg.norm(middle))
    return np.array(found)


BATCHED = ("one slide", "one slide before the end", "forty slides", "forty points", "space")


@pytest.mark.parametrize("name", [*(f"{case} 64" for case in CASES), *BATCHED])
def test_the_command_is_that_of_the_batch_least_squares(name: str) -> None:
    """In float64 C, to 1e-12 of the largest command, at the origin where nothing cancels."""
    own, rng, worst = made(name), np.random.default_rng(7), 0.0
    axes = [axis.model.plant for axis in own.axes]
    for _ in range(20):
        points = wandering(rng, own.preview, len(axes))
        states = [1e-6 * rng.normal(size=axis.order) for axis in axes]
        shown = [axis.model.from_state @ x for axis, x in zip(own.axes, states, strict=True)]
        wanted, advance = points[1:], points[-1] - points[-2]
        ends = [wanted_state(axis) for axis in axes]
        end = np.concatenate(
            [f.on_position * wanted[-1, a] + f.on_advance * advance[a] for a, f in enumerate(ends)]
        )
        state = np.concatenate(states)
        tangents = tangents_of(points)
        exact = batch_input(axes, own.weights, own.terminal, tangents, state, wanted, end)
        controller = in_c(name)
        controller.call("reset", {"position": np.zeros(len(axes))})
        status, out = controller.call(
            "follow",
            {
                "position": np.array([x[0] for x in shown]),
                "hidden": np.concatenate([x[1:] for x in shown]),
                "reference": points.ravel(),
            },
        )
        assert (status, out["limited"]) == (Status.OK, 0)
        off = np.max(np.abs(np.asarray(out["command"]) - exact)) / np.max(np.abs(exact))
        worst = max(worst, float(off))
    assert worst < 1e-12


def wandering(rng: np.random.Generator, preview: int, axes: int) -> np.ndarray:
    """(N + 1, p) points 10 um apart in the plane, rising where there is a third axis."""
    angle = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(rng.normal(0.0, 0.3, preview + 1))
    ways = np.column_stack([np.cos(angle), np.sin(angle), rng.normal(0.0, 0.3, preview + 1)])
    points: np.ndarray = 1e-5 * np.cumsum(ways[:, :axes], axis=0)
    return points


def operations(name: str) -> int:
    """Floating-point operations of the worst step, comparisons and sign changes too."""
    found = count_emitted(package(name)).entry_points[f"{made(name).prefix}_step"].total()
    return found.add + found.mul + found.div + found.cmp + found.neg + found.convert


def test_a_step_is_a_tenth_of_what_the_dense_recursion_takes() -> None:
    """Range checks, filter and tangents included; the recursion alone is 25,630."""
    assert operations("II 64") == operations("II 32") <= 2600
    assert operations("IV 64") <= 2270
    assert operations("I 64") <= 600
    assert operations("table") <= 860


def two(design: ContourLqDesign) -> list[list[Call]]:
    return [list(contour_calls(design, np.random.default_rng(seed), 60)) for seed in (5, 6)]


@pytest.mark.parametrize("name", ["II 32", "table"])
def test_two_instances_in_dirty_memory_know_nothing_of_each_other(name: str) -> None:
    design = made(name)
    controllers = [in_c(name), in_c(name)]
    for controller in controllers:
        dirt = np.frombuffer(controller._ffi.buffer(controller.memory), dtype=np.uint8)
        dirt[:] = DIRT
        getattr(controller._lib, f"{controller.declaration.prefix}_init")(controller.memory)
    references = [ContourLq(design), ContourLq(design)]
    for pair in zip(*two(design), strict=True):
        for call, reference, controller in zip(pair, references, controllers, strict=True):
            status, out = reference.call(call.operation, call.inputs)
            told, given = controller.call(call.operation, call.inputs)
            assert told is status
            for port, value in out.items():
                np.testing.assert_array_equal(given[port], value)
