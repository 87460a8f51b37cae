"""The bundled drawing and the samples: read, timed, the same every time."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from drawings import LIMITS, PERIOD_S, SETTINGS, peak_acceleration, peak_velocity
from numpy.testing import assert_allclose

from servogen.paths.load import load_tool_path
from servogen.paths.timing import TimedPath, time_path
from servogen.project.load import load_project
from servogen.systems.judgement import timed_path

EXAMPLE = Path(__file__).parents[2] / "examples" / "two_stage"
SAMPLES = Path(__file__).parent / "samples"


@pytest.fixture(scope="module")
def bundled() -> TimedPath:
    return timed_path(load_project(EXAMPLE / "servogen.toml"))


def test_the_drawing_is_what_its_script_draws(tmp_path: Path) -> None:
    for seed in ("0", "1"):
        drawn = tmp_path / f"{seed}.dxf"
        script = [sys.executable, str(EXAMPLE / "make_drawing.py"), str(drawn)]
        subprocess.run(script, check=True, env={**os.environ, "PYTHONHASHSEED": seed})
        assert drawn.read_bytes() == (EXAMPLE / "batch.dxf").read_bytes()


def test_the_timed_path_has_the_papers_size(bundled: TimedPath) -> None:
    assert len(bundled.points) - 1 == 232_100
    assert bundled.duration_s == pytest.approx(46.42, abs=1e-9)


def test_the_timed_path_keeps_the_ideal_machines_limits(bundled: TimedPath) -> None:
    fast = load_project(EXAMPLE / "servogen.toml").machine.x.fast
    assert peak_acceleration(bundled) <= fast.acceleration_limit_m_per_s2 * (1 + 1e-9)
    assert peak_velocity(bundled) <= fast.velocity_limit_m_per_s * (1 + 1e-9)
    assert np.abs(bundled.points).max() <= 0.36


def test_the_bundled_path_is_the_same_again(bundled: TimedPath) -> None:
    again = timed_path(load_project(EXAMPLE / "servogen.toml"))
    assert again.points.tobytes() == bundled.points.tobytes()
    assert again.tool_path.labels == bundled.tool_path.labels


@pytest.mark.parametrize(
    ("name", "begin", "end", "label"),
    [
        ("plate.svg", (-0.015, 0.0), None, "circle #hole"),
        ("plate.nc", (-0.03, -0.02), (0.01635, -0.00635), "line 6"),
        ("plate.csv", (-0.03, -0.02), (-0.03, -0.02), "line 3"),
    ],
)
def test_samples_of_the_other_formats(
    name: str, begin: tuple[float, float], end: tuple[float, float] | None, label: str
) -> None:
    path = load_tool_path(SETTINGS, SAMPLES / name)
    assert path.labels[0] == label
    assert_allclose(path.points[0], begin, atol=1e-12)
    if end is not None:
        assert_allclose(path.points[-1], end, atol=1e-12)
    timed = time_path(path, LIMITS, PERIOD_S)
    assert peak_acceleration(timed) <= 49.05 * (1 + 1e-9)
    assert np.abs(timed.points).max() < 0.05
    again = time_path(load_tool_path(SETTINGS, SAMPLES / name), LIMITS, PERIOD_S)
    assert again.points.tobytes() == timed.points.tobytes()
