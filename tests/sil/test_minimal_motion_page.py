"""docs/minimal-motion.md is a program: it runs as it stands, and does what the page says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servogen.controllers.motion_window import MotionWindow
from servogen.sil.build import built
from servogen.sil.compiled import CompiledController
from servogen.sil.harness import compare
from servogen.sil.motion_calls import motion_window_calls

PAGE = Path(__file__).parents[2] / "docs" / "minimal-motion.md"


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """What the page's program leaves behind."""
    names: dict[str, Any] = {}
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        exec(block, names)
    return names


def test_the_whole_path_moves_less_than_its_pattern(page: dict[str, Any]) -> None:
    pattern, motion = page["pattern"], page["motion"]
    np.testing.assert_array_equal(motion[[0, -1]], pattern[[0, -1]])
    assert np.all(np.abs(motion - pattern) <= 0.024 + 1e-15)
    np.testing.assert_array_equal(page["x"], motion[:, 0])
    travelled = np.abs(np.diff(motion, axis=0)).sum()
    assert travelled < 0.5 * np.abs(np.diff(pattern, axis=0)).sum()


def test_what_is_streamed_is_in_the_tube_and_the_whole_paths(page: dict[str, Any]) -> None:
    x, y, pattern = page["x"], page["y"], page["pattern"][:, 0]
    assert page["status"].name == "FINISHED"
    assert y.size == pattern.size
    assert np.all(np.abs(y - pattern) <= 0.024 + 1e-15)
    assert page["ahead"] <= page["design"].window
    np.testing.assert_allclose(y, x, rtol=0.0, atol=1e-14)


def test_the_c_is_the_reference(page: dict[str, Any]) -> None:
    reference = MotionWindow(page["design"])
    calls = list(motion_window_calls(page["design"], np.random.default_rng(0), 40))
    with built(page["package"]) as module:
        agreement = compare(reference, CompiledController(module, reference.declaration), calls)
    assert agreement.passed, agreement.difference
    assert agreement.worst == 0.0
    assert "OK" in agreement.statuses
