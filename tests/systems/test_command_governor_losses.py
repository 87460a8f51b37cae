"""Measurements and points that are lost for some periods: the extended command governor waits and
goes on; a path that it cannot follow is told and not followed."""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

from governed_machine import figures, least_motion, machine, stage

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_declaration import declare_governor_parts
from servogen.controllers.command_governor_design import GovernorSettings
from servogen.controllers.design import Declaration, Status, Value
from servogen.emit.package import emit_package
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import Call, compare
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor_loop import excess, run_governed

HORIZON, M = 12, 48
PATH = figures(3, 5, 400)
# Two places 45 mm apart: the next point's reference is where the tool is out of reach of the stage.
APART = np.repeat([[0.1, 0.1], [0.145, 0.1]], 150, axis=0)
PATHS = {
    "minimal motion": (PATH, least_motion(PATH)),
    "pattern": (PATH, PATH),
    "two places": (APART, APART),
}
STAGES = (stage(), stage())
DESIGN = machine(HORIZON, GovernorSettings(), M)
# What a plan may miss of a limit at its instants: nothing, but for the sums of two simulations.
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def in_c() -> Iterator[CompiledController]:
    package = emit_package(DESIGN.prefix, declare_governor_parts(DESIGN))
    with built(package) as module:
        yield CompiledController(module, package.declarations[-1])


@dataclass
class Losing:
    """A governor that is told nothing of use for some periods; keeps what it was asked and said."""

    governor: CompiledController
    what: str
    first: int
    periods: int

    def __post_init__(self) -> None:
        self.calls: list[Call] = []
        self.told: list[Status] = []
        self.taken: list[int] = []

    @property
    def declaration(self) -> Declaration:
        return self.governor.declaration

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        given = dict(inputs or {})
        if operation == "step":
            # the loop fills its window again and again
            given |= {k: v.copy() for k, v in given.items() if isinstance(v, np.ndarray)}
            if self.lost(len(self.told)):
                self.spoil(given)
        self.calls.append(Call(operation, given))
        status, out = self.governor.call(operation, given)
        if operation == "step":
            self.told.append(status)
            self.taken.append(int(np.asarray(out["points_taken"])))
        return status, out

    def lost(self, period: int) -> bool:
        return self.first <= period < self.first + self.periods

    def spoil(self, given: dict[str, Value]) -> None:
        match self.what:
            case "measurement":
                given["x_velocity"] = np.nan
            case "both measurements":
                given["x_velocity"] = given["y_position"] = np.inf
            case "points":
                points = np.array(given["points_x"])
                points[0] = np.nan
                given["points_x"] = points


def loses(in_c: CompiledController, path: str, what: str, first: int, periods: int) -> Losing:
    """The path is finished, every limit kept at its instants, the statuses as documented."""
    points, reference = PATHS[path]
    losing = Losing(in_c, what, first, periods)
    done = run_governed(DESIGN, STAGES, points, reference, losing)
    assert done.complete
    at_instants, at_ends = excess(DESIGN, done, M // 3), excess(DESIGN, done, M)
    limits = (at_instants.position, at_instants.velocity, at_instants.acceleration)
    assert max(*limits, at_ends.stroke) <= ROUNDING
    for period, (status, taken) in enumerate(zip(losing.told, losing.taken, strict=True)):
        if losing.lost(period):
            assert (status, taken) == (Status.NOT_FINITE, 0)
        else:
            assert status in (Status.OK, Status.BACKUP, Status.INFEASIBLE)
            assert status is not Status.INFEASIBLE or taken == 0
    return losing


@pytest.mark.parametrize("what", ["measurement", "both measurements", "points"])
@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("periods", [1, 3, 8, 20])
def test_lost_periods_do_not_stop_the_machine(
    in_c: CompiledController, path: str, what: str, periods: int
) -> None:
    starts = [2] if path == "two places" else [1, 7, 31, 55, 61, 88]
    for first in starts:
        loses(in_c, path, what, first, periods)


@pytest.mark.parametrize("path", PATHS)
def test_what_the_c_does_meanwhile_is_what_the_reference_does(
    in_c: CompiledController, path: str
) -> None:
    losing = loses(in_c, path, "measurement", 2, 5)
    agreement = compare(CommandGovernor(DESIGN), in_c, losing.calls[:60])
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("first", [3, 5, 9])
def test_a_stage_that_is_not_where_it_was_planned_comes_back_to_the_tool(
    in_c: CompiledController, path: str, first: int
) -> None:
    """A measurement beyond the stroke for 20 periods: the moved plan runs to its end, away from the
    tool. INFEASIBLE until that is in reach for ever, then on."""
    points, reference = PATHS[path]

    class Thrown(Losing):
        def spoil(self, given: dict[str, Value]) -> None:
            given["x_position"] = float(np.asarray(given["x_position"])) + 0.03

    thrown = Thrown(in_c, "", first, 20)
    assert run_governed(DESIGN, STAGES, points, reference, thrown).complete
    lost = np.flatnonzero(np.array(thrown.told) == Status.INFEASIBLE)
    assert lost.size >= 2
    assert not np.any(np.array(thrown.taken)[lost])
    agreement = compare(CommandGovernor(DESIGN), in_c, thrown.calls[:60])
    assert agreement.passed, agreement.difference


def test_a_path_that_cannot_be_followed_is_told(in_c: CompiledController) -> None:
    """60 mm to the next point: the stage stands where the last one is in reach, UNREACHABLE; with
    points that it can follow it goes on."""
    points = APART.copy()
    points[150:, 0] += 0.015
    told = Losing(in_c, "", 0, 0)
    with pytest.raises(Stalled):
        run_governed(DESIGN, STAGES, points, points, told)
    first = told.told.index(Status.UNREACHABLE)
    assert set(told.told[:first]) == {Status.OK}
    assert set(told.told[first:]) == {Status.UNREACHABLE}
    assert first < 50
    assert not any(told.taken[first:])
    back = dict(told.calls[-1].inputs)
    for axis, where in zip("xy", points[149], strict=True):
        back[f"points_{axis}"] = back[f"slow_{axis}"] = np.full(DESIGN.window, where)
    status, out = in_c.call("step", back)
    assert (status, out["points_taken"]) == (Status.OK, M)


@pytest.mark.parametrize("path", PATHS)
def test_a_clean_run_is_never_told_so(in_c: CompiledController, path: str) -> None:
    """Although there are periods without a point."""
    told = loses(in_c, path, "", 0, 0)
    assert set(told.told) == {Status.OK}
    assert 0 in told.taken
