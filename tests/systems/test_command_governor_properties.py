"""Properties (a), (b) and (c) of the extended command governor: on 10,000 points of the paper's
P-tilde by its rows, and in the emitted C, which falls back on the moved plan all the time."""

import sys
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

from governed_machine import CENTRE, STROKE, T_S, admissible, figures, least_motion, machine, stage

from servogen.controllers.command_governor_declaration import declare_governor_parts
from servogen.controllers.command_governor_design import CommandGovernorDesign, GovernorSettings
from servogen.controllers.command_governor_program import SETTLED, GovernorWeights
from servogen.controllers.design import Status
from servogen.emit.package import emit_package
from servogen.plants.statespace import discretise
from servogen.sets.extended import ExtendedSet
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.systems.command_governor_loop import excess, run_governed

PLANT = discretise(stage(), T_S)
HORIZON, M = 12, 48
PATH = figures(3, 5, 400)
# What rows left out as implied may be passed by.
ROUNDING = 1e-8


@cache
def points(horizon: int, chains: int, rounds: int, standing: bool) -> np.ndarray:
    """(chains, dim) of P-tilde in the coordinates of its rows, hit and run from its middle; every
    second one on its boundary. ``standing``: of those whose plan is one command for ever."""
    target = admissible(horizon)
    rows = target.rows[:, _free(target, standing)]
    generator = np.random.default_rng(horizon)
    found = np.zeros((chains, rows.shape[1]))
    scale = 1.0 / np.max(np.abs(rows), axis=0)
    for index in range(rounds):
        way = generator.normal(size=found.shape) * scale
        at, along = found @ rows.T, way @ rows.T
        with np.errstate(divide="ignore"):
            most = np.min(np.where(along > 0, (1 - at) / along, (-1 - at) / along), axis=1)
            least = np.max(np.where(along > 0, (-1 - at) / along, (1 - at) / along), axis=1)
        share = generator.uniform(0.02, 0.98, chains)
        if index == rounds - 1:
            share[::2] = 1.0
        found += (least + share * (most - least))[:, None] * way
    whole = np.zeros((chains, target.rows.shape[1]))
    whole[:, _free(target, standing)] = found
    return whole


def _free(target: ExtendedSet, standing: bool) -> np.ndarray:
    n, total = target.h_x.shape[1], target.rows.shape[1]
    return np.array([*range(n), total - 1]) if standing else np.arange(total)


def moved_on(target: ExtendedSet, points: np.ndarray, shifted: bool = True) -> np.ndarray:
    """One period later with the same rho; the register shifted, or left as (b) is printed."""
    n = target.h_x.shape[1]
    state, register, rho = points[:, :n], points[:, n:-1], points[:, -1:]
    # the set's position is counted from its middle, the stage has unit gain
    ahead = state @ PLANT.a.T + (register[:, :1] + rho) * PLANT.b
    after = np.hstack([register[:, 1:], np.zeros_like(rho)]) if shifted else register
    return np.hstack([ahead, after, rho])


def over(target: ExtendedSet, points: np.ndarray) -> float:
    return float(np.max(np.abs(points @ target.rows.T)) - 1.0)


def test_ten_thousand_points_of_the_paper_s_set_stay_in_it() -> None:
    """(b), and with it (a): from every point the moved one is in the set, again and again."""
    target = admissible(40)
    found = points(40, 10_000, 20, standing=False)
    assert abs(over(target, found[::2])) < 1e-9
    assert np.std(found, axis=0).min() > 0.0
    for _ in range(3):
        found = moved_on(target, found)
        assert over(target, found) <= ROUNDING
        for state in at_instants(found[:, :3], found[:, 3] + found[:, -1]):
            assert np.max(np.abs(state[:, 1])) <= 0.1 * (1 + ROUNDING)
            assert np.max(np.abs(state[:, 2])) <= 10.0 * (1 + ROUNDING)


def at_instants(state: np.ndarray, command: np.ndarray) -> list[np.ndarray]:
    """(K, 3) states at the N = 3 instants of a period under a command each, its beginning first."""
    part, found = discretise(stage(), T_S / 3), [state]
    for _ in range(2):
        found.append(found[-1] @ part.a.T + command[:, None] * part.b)
    return found


def test_property_b_as_printed_does_not_hold() -> None:
    """With the register not shifted the next point is far outside."""
    target = admissible(40)
    printed = moved_on(target, points(40, 10_000, 20, standing=False), shifted=False)
    assert over(target, printed) > 0.1


@pytest.fixture(scope="module")
def starved() -> Iterator[tuple[CommandGovernorDesign, CompiledController, CompiledController]]:
    """The C with one iteration: an axis and the whole."""
    yield from _compiled(GovernorSettings(cap=1))


@pytest.fixture(scope="module")
def fed() -> Iterator[tuple[CommandGovernorDesign, CompiledController, CompiledController]]:
    """The C as it is."""
    yield from _compiled(GovernorSettings())


def _compiled(
    settings: GovernorSettings,
) -> Iterator[tuple[CommandGovernorDesign, CompiledController, CompiledController]]:
    design = machine(HORIZON, settings, M)
    package = emit_package(design.prefix, declare_governor_parts(design))
    with built(package) as module:
        axis, both = package.declarations[0], package.declarations[-1]
        yield design, CompiledController(module, axis), CompiledController(module, both)


def bounds(axis: CompiledController) -> dict[str, np.ndarray]:
    """No points: the stroke asks for nothing."""
    ports = {port.name: port for port in axis.declaration.operation("step").inputs}
    low, high = ports["low"], ports["high"]
    assert low.low is not None
    assert high.high is not None
    return {"low": np.full(low.size, low.low), "high": np.full(high.size, high.high)}


def test_the_c_has_a_plan_from_every_feasible_state_whatever_is_asked(starved, fed) -> None:  # type: ignore[no-untyped-def]
    """(b): the C is put on 10,000 points of P-tilde with a moving plan, half of them on its
    boundary, the stage goes on by one period of it, then three periods each of references anywhere
    in the range; never INFEASIBLE, every limit kept. With one iteration, and as it is."""
    told = {Status.OK: 0, Status.BACKUP: 0}
    found = points(HORIZON, 10_000, 40, standing=False)
    found = found * (1 - 2e-6)  # off the boundary by the margin of the program's bounds
    for index, (axis, share) in enumerate(
        ((starved[1], slice(0, 7_000)), (fed[1], slice(7_000, None)))
    ):
        ended = from_points(axis, found[share], np.random.default_rng(index))
        for status, count in ended.items():
            told[status] += count
        assert ended[Status.BACKUP] > 0 if axis is starved[1] else ended[Status.OK] > 0
    assert told[Status.BACKUP] > 10_000
    assert told[Status.OK] > 5_000


def from_points(
    axis: CompiledController, found: np.ndarray, generator: np.random.Generator
) -> dict[Status, int]:
    """How three periods of each end; limits are asserted."""
    told = {Status.OK: 0, Status.BACKUP: 0}
    names = [port.name for port in axis.declaration.operation("predict").inputs]
    wished = generator.uniform(0.0, 0.25, (len(found), 3, HORIZON + 1))
    low_high = bounds(axis)
    held = np.frombuffer(axis._ffi.buffer(axis.memory), np.float64)[: HORIZON + 1]
    for point, asked in zip(found, wished, strict=True):
        state, rho = point[:3], point[-1]
        axis.call("reset", {"position": rho + CENTRE})
        assert set(held) == {rho + CENTRE}  # its plan: n commands and rho
        held[:-1] += point[3:-1]
        state = PLANT.a @ state + PLANT.b * (held[0] - CENTRE)
        for reference in asked:
            given = dict(zip(names, [state[0] + CENTRE, *state[1:]], strict=True))
            status, out = axis.call("step", {**given, "reference": reference, **low_high})
            told[status] += 1  # KeyError: neither OK nor BACKUP
            state = PLANT.a @ state + PLANT.b * (float(np.asarray(out["command"])) - CENTRE)
            assert abs(state[0]) <= 0.125 * (1 + ROUNDING)
            assert abs(state[1]) <= 0.1 * (1 + ROUNDING)
            assert abs(state[2]) <= 10.0 * (1 + ROUNDING)
    return told


@pytest.fixture(scope="module")
def close() -> Iterator[tuple[CommandGovernorDesign, CompiledController, CompiledController]]:
    """One iteration, and the stroke at all instants."""
    yield from _compiled(GovernorSettings(cap=1, sub_step_stroke=True))


def test_the_c_keeps_the_stroke_of_points_that_its_plan_reaches(close) -> None:  # type: ignore[no-untyped-def]
    """(b) with the rows of the stroke: in every interval a point is chosen that the moved plan has
    in reach, every other time one at the end of that reach. Never INFEASIBLE, and every limit and
    the stroke kept at the three instants of the period and at its end."""
    axis, rng = close[1], np.random.default_rng(12)
    names = [port.name for port in axis.declaration.operation("predict").inputs]
    held = np.frombuffer(axis._ffi.buffer(axis.memory), np.float64)[: HORIZON + 1]
    found = points(HORIZON, 10_000, 40, standing=False)[:2_000] * (1 - 2e-6)
    told = {Status.OK: 0, Status.BACKUP: 0}
    before, after, wanted = [], [], []
    for number, point in enumerate(found):
        axis.call("reset", {"position": point[-1] + CENTRE})
        held[:-1] += point[3:-1]
        state = PLANT.a @ point[:3] + PLANT.b * (held[0] - CENTRE)
        for _ in range(2):
            given = dict(zip(names, [state[0] + CENTRE, *state[1:]], strict=True))
            _, seen = axis.call("foresee", given)
            least, greatest = np.asarray(seen["least"]), np.asarray(seen["greatest"])
            assert np.all(least < greatest)
            share = rng.uniform(0.0, 1.0, least.size)
            chosen = least + (np.round(share) if number % 2 else share) * (greatest - least)
            asked = {
                "reference": rng.uniform(0.0, 0.25, HORIZON + 1),
                "low": chosen - STROKE,
                "high": chosen + STROKE,
            }
            status, out = axis.call("step", {**given, **asked})
            told[status] += 1  # KeyError: neither OK nor BACKUP
            command = float(np.asarray(out["command"])) - CENTRE
            before.append(state)
            after.append(command)
            wanted.append(chosen[0] - CENTRE)
            state = PLANT.a @ state + PLANT.b * command
    states = at_instants(np.array(before), np.array(after))
    states.append(np.array(before) @ PLANT.a.T + np.array(after)[:, None] * PLANT.b)
    for instant in states:
        assert np.max(np.abs(instant[:, 0] - np.array(wanted))) <= STROKE * (1 + ROUNDING)
        assert np.max(np.abs(instant[:, 1])) <= 0.1 * (1 + ROUNDING)
        assert np.max(np.abs(instant[:, 2])) <= 10.0 * (1 + ROUNDING)
    assert told[Status.BACKUP] > 1_000


@pytest.mark.parametrize("pattern", [False, True], ids=["minimal motion", "pattern"])
def test_the_c_keeps_every_limit_of_a_path_on_backups(starved, pattern: bool) -> None:  # type: ignore[no-untyped-def]
    """(a) and (b) over a path at one iteration."""
    design, _, both = starved
    reference = PATH if pattern else least_motion(PATH)
    done = run_governed(design, (stage(), stage()), PATH, reference, both, 150)
    assert set(done.status_axis.ravel()) <= {Status.OK, Status.BACKUP}
    assert np.count_nonzero(done.status_axis == Status.BACKUP) > 20
    kept, ends = excess(design, done, M // 3), excess(design, done, M)
    assert max(kept.position, kept.velocity, kept.acceleration, ends.stroke) <= 1e-9


@pytest.mark.parametrize("wished", [0.1, 0.3, -0.2])
def test_the_c_converges_to_the_nearest_steady_command(fed, wished: float) -> None:  # type: ignore[no-untyped-def]
    """(c): after finitely many periods the command is the nearest one in V', and stays it."""
    axis = fed[1]
    end = float(np.clip(wished, CENTRE - 0.995 * 0.125, CENTRE + 0.995 * 0.125))
    names = [port.name for port in axis.declaration.operation("predict").inputs]
    axis.call("reset", {"position": 0.2})
    state, commands = np.array([0.2, 0.0, 0.0]), []
    asked = {"reference": np.full(HORIZON + 1, wished), **bounds(axis)}
    for _ in range(150):
        status, out = axis.call("step", {**dict(zip(names, state, strict=True)), **asked})
        assert status is Status.OK
        commands.append(float(np.asarray(out["command"])))
        state = PLANT.a @ state + PLANT.b * commands[-1]
    reached = int(np.flatnonzero(np.abs(np.array(commands) - end) > 1e-7)[-1]) + 1
    assert 5 < reached < 130


def test_no_cap_is_a_deadlock() -> None:
    """A path at two iterations a period with weights at which every one was at the cap for ever."""
    weights = GovernorWeights(reference=100.0)
    corners = np.array([[0.02, 0.2], [0.15, 0.03], [0.1, 0.1]])
    path = np.vstack([np.linspace(a, b, 10) for a, b in pairwise(corners)])
    for design, _, both in _compiled(GovernorSettings(cap=2, weights=weights)):
        done = run_governed(design, (stage(), stage()), path, path, both, 400)
        assert done.complete
        assert np.count_nonzero(done.status_axis == Status.BACKUP) > 20


def test_rho_keeps_away_from_the_strokes_end_what_a_stage_may_lack() -> None:
    """``settle_m`` is the largest |p - rho| of P-tilde at the instants after those with rows, by
    programs of their own: the first 20 in a row that are within ``SETTLED`` of the stroke."""
    target, subs = admissible(HORIZON), 3
    scale = 1.0 / np.max(np.abs(target.rows), axis=0)
    inside = np.vstack([target.rows, -target.rows]) * scale
    part, size = discretise(stage(), T_S / subs), target.rows.shape[1]
    # what each coordinate alone does: state, entries of the register, rho
    state, lacks, allowed = np.eye(3, size), list[float](), SETTLED * 0.025
    for instant in range(1, (HORIZON + 1) * subs + 90):
        command = np.zeros(size)
        command[-1] = 1.0
        period = (instant - 1) // subs
        if period < HORIZON:
            command[3 + period] = 1.0
        state = part.a @ state + np.outer(part.b, command)
        if instant > (HORIZON + 1) * subs:
            error = (state[0] - np.eye(size)[-1]) * scale / allowed
            ends = linprog(-error, A_ub=inside, b_ub=np.ones(len(inside)), bounds=(None, None))
            lacks.append(-allowed * float(ends.fun))
    first = int(np.flatnonzero(np.array(lacks) > allowed)[-1]) + 1
    settle = machine(HORIZON).axes[0].program.settle_m
    assert settle == pytest.approx(max(lacks[first : first + 20]), rel=1e-6)
    assert settle > 2.0 * lacks[first + 19]
