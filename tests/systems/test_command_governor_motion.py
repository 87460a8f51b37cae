"""The motion that a streaming machine has is that of the C that it runs."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from servogen.controllers.motion_window import MotionWindow
from servogen.controllers.motion_window_design import MotionWindowDesign
from servogen.errors import InputError
from servogen.paths.minimal_motion import pattern_motion
from servogen.precision import FLOAT32, FLOAT64, FloatArray
from servogen.progress import Silent
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import compare
from servogen.steps.governor import prepare_governor
from servogen.steps.prepare import Prepared
from servogen.steps.system import Findings
from servogen.systems import command_governor_motion
from servogen.systems.closed_loop import Stalled
from servogen.systems.command_governor_motion import motion_designs, streamed_motion
from servogen.systems.command_governor_stream import StreamedReference

sys.path.insert(0, str(Path(__file__).parents[1] / "steps"))

from governor_example import small_project

STREAMED = ("stroke_reserve_m = 0.001 ", "streamed_window = 400\nstroke_reserve_m = 0.001 ")


def stepwise(points: FloatArray, design: MotionWindowDesign) -> FloatArray:
    """(n,) of the reference, block after block."""
    own, parts, at = MotionWindow(design), [], 0
    own.call("reset", {"start": points[0]})
    while sum(part.size for part in parts) < points.size:
        block = np.zeros(design.block)
        given = points[at : at + design.block]
        block[: given.size], at = given, at + given.size
        ended = int(at == points.size)
        _, out = own.call("step", {"points": block, "n_points": given.size, "ended": ended})
        parts.append(np.asarray(out["reference"])[: int(np.asarray(out["n_references"]))])
    return np.concatenate(parts)


@pytest.mark.parametrize("compiler", [True, False])
@pytest.mark.parametrize(("size", "window", "block"), [(1, 5, 3), (200, 40, 7), (300, 12, 50)])
def test_it_is_that_of_the_reference_bit_for_bit(
    monkeypatch: pytest.MonkeyPatch, size: int, window: int, block: int, compiler: bool
) -> None:
    if not compiler:
        monkeypatch.setattr(command_governor_motion, "has_compiler", lambda: False)
    points = 0.1 + np.cumsum(np.random.default_rng(size).normal(0.0, 0.01, size))
    design = MotionWindowDesign("m", FLOAT64, window, block, 0.02, 5.0, 0.1)
    np.testing.assert_array_equal(streamed_motion(points, design), stepwise(points, design))
    motion = streamed_motion(points, design)
    assert np.max(np.abs(motion - points)) <= 0.02 + 1e-15


def test_a_window_over_the_whole_path_has_the_motion_of_the_whole_path() -> None:
    points = 0.1 + np.cumsum(np.random.default_rng(3).normal(0.0, 0.01, 300))
    whole = pattern_motion(points[:, None], 0.02)[:, 0]
    far = MotionWindowDesign("m", FLOAT64, 300, 50, 0.02, 5.0, 0.1)
    near = MotionWindowDesign("m", FLOAT64, 5, 5, 0.02, 5.0, 0.1)
    np.testing.assert_allclose(streamed_motion(points, far), whole, rtol=0, atol=1e-15)
    seen = streamed_motion(points, near)
    assert np.max(np.abs(seen - whole)) > 1e-3
    assert np.sum(np.abs(np.diff(seen))) >= np.sum(np.abs(np.diff(whole))) - 1e-12


def test_a_project_that_streams_has_the_c_of_both_axes_and_is_sent_where_it_says(
    tmp_path: Path,
) -> None:
    project = small_project(tmp_path, STREAMED)
    system = prepare_governor(project, Silent())
    names = [d.prefix for d in system.declarations(FLOAT64)]
    assert names == ["etcher_motion_x", "etcher_motion_y", "etcher_axis", "etcher"]
    x, y = motion_designs(project, FLOAT64)
    assert (x.window, x.block, x.reach_m, y.prefix) == (400, 50, 0.024, "etcher_motion_y")
    machine = system.machine
    np.testing.assert_array_equal(machine.motion[:, 1], streamed_motion(machine.points[:, 1], y))
    assert np.any(machine.motion != pattern_motion(machine.points, 0.025, 0.001))
    assert system.simulate(None, Silent()).passed
    with built(Prepared(system).package_in(FLOAT32)) as module:
        tried = list(system.scenarios(FLOAT32, 1, 30))[:4]
        assert [case.name.split(":")[0] for case in tried[::2]] == names[:2]
        for case in tried:
            own = case.reference()
            assert compare(own, CompiledController(module, own.declaration), case.calls, 0.0).passed


def test_the_pattern_is_not_streamed(tmp_path: Path) -> None:
    pattern = ('"minimal_motion"', '"pattern"')
    told = r'streamed_window is 400, expected 0 with reference = "pattern"'
    with pytest.raises(InputError, match=told):
        small_project(tmp_path, STREAMED, pattern)


def test_the_stream_gives_what_the_windows_give_a_call_a_period() -> None:
    rng = np.random.default_rng(7)
    points = 0.1 + np.cumsum(rng.normal(0.0, 0.01, (200, 2)), axis=0)
    designs = [MotionWindowDesign(f"m_{a}", FLOAT64, 30, 7, 0.02, 5.0, 0.1) for a in "xy"]
    stream = StreamedReference((MotionWindow(designs[0]), MotionWindow(designs[1])), points)
    whole = np.stack([streamed_motion(points[:, i], designs[i]) for i in range(2)], axis=1)
    first = 0
    while first < len(points) - 1:
        count = min(20, len(points) - 1 - first)
        np.testing.assert_array_equal(stream(first + 1, count), whole[first + 1 :][:count])
        first += int(rng.integers(0, 8))
    assert stream.steps[0] == -(-(30 + 21) // 7)
    assert set(stream.steps[1:]) == {0, 1}


def test_a_motion_that_refuses_its_points_ends_the_loop() -> None:
    points = np.full((20, 2), 0.1)
    points[9, 1] = 6.0
    designs = [MotionWindowDesign(f"m_{a}", FLOAT64, 3, 7, 0.02, 5.0, 0.1) for a in "xy"]
    stream = StreamedReference((MotionWindow(designs[0]), MotionWindow(designs[1])), points)
    with pytest.raises(Stalled, match="m_y says OUT_OF_RANGE at point 13"):
        stream(1, 10)


def test_the_closed_loop_runs_the_c_of_the_motion(tmp_path: Path) -> None:
    """Where it is sent comes from the C alone: what was made beforehand may be anything."""
    system = prepare_governor(small_project(tmp_path, STREAMED), Silent())
    spoilt = replace(system, machine=replace(system.machine, motion=system.machine.points))
    package = Prepared(system).package
    inside = spoilt.simulate(package, Silent())
    assert inside.passed
    assert inside.row.time_s != spoilt.simulate(None, Silent()).row.time_s
    assert inside.row == system.simulate(None, Silent()).row
    page = system.page(Findings(inside, {"passed": True, "design_hash": package.hash}))
    assert "from another design" not in page
