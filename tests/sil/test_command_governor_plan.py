"""Predicted indices in the C, which looks at a point a bounded number of times, against those of
the reference, which looks as often as it likes."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from core_designs import temporary_folder
from governor_designs import SHAPES, governor, package, swap

from servogen.controllers.command_governor_path import Reach, predicted_indices

FLAGS = ("-std=c99", "-O0", "-ffp-contract=off", "-fPIC", "-w")
INTERVALS, WINDOW, M = 6, 51, 10
PROBE = """
#include "{p}.c"
void probe(const double *x, const double *y, int n, const double *reach, const int32_t *planned,
           int32_t *indices)
{{
    static {p}_t self;
    static {p}_step_in in;
    self.last_x = x[0];
    self.last_y = y[0];
    in.n_points = n;
    for (int i = 0; i < n; i++) {{
        in.points_x[i] = x[i + 1];
        in.points_y[i] = y[i + 1];
    }}
    for (int i = 0; i < {P}_INTERVALS; i++) {{
        self.least_x[i] = self.least_on_x[i] = reach[i];
        self.greatest_x[i] = self.greatest_on_x[i] = reach[{P}_INTERVALS + i];
        self.least_y[i] = self.least_on_y[i] = reach[2 * {P}_INTERVALS + i];
        self.greatest_y[i] = self.greatest_on_y[i] = reach[3 * {P}_INTERVALS + i];
        self.planned[i] = planned[i];
    }}
    {p}_plan(&self, &in, n);
    for (int i = 0; i < {P}_INTERVALS; i++) {{
        indices[i] = self.indices[i];
    }}
}}
"""


@cache
def axes() -> list[str]:
    """What the governor calls, compiled once."""
    made, folder = package(governor(SHAPES["float64"])), temporary_folder("probe-axes")
    made.write(folder)
    files = [f"g64_{axis}" for axis in "xy"]
    for file in files:
        subprocess.run(
            ["gcc", *FLAGS, "-c", f"{file}.c", "-o", f"{file}.o"], cwd=folder, check=True
        )
    return [str(folder / f"{file}.o") for file in files]


def probe(change: Callable[[str], str] = lambda text: text) -> Callable[..., np.ndarray]:
    """The planning of the C alone, given what is in reach."""
    made, folder = package(governor(SHAPES["float64"])), temporary_folder("probe")
    made.write(folder)
    (folder / "g64.c").write_text(change(made.files["g64.c"]), encoding="utf-8")
    (folder / "probe.c").write_text(PROBE.format(p="g64", P="G64"), encoding="utf-8")
    command = ["gcc", *FLAGS, "-shared", f"-I{folder}", "-o", "probe.so", "probe.c", *axes()]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(Path(folder) / "probe.so"))

    def plan(points: list[np.ndarray], reach: np.ndarray, planned: np.ndarray) -> np.ndarray:
        indices = np.zeros(INTERVALS, dtype=np.int32)
        own = planned.astype(np.int32)
        arrays = (points[0], points[1], points[0].size - 1, reach, own, indices)
        library.probe(*(a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else a
                        for a in arrays))  # fmt: skip
        return indices

    return plan


def problem(rng: np.random.Generator) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    """Path, reaches (4, intervals) that let it pass, stop it or send it back, and a plan before."""
    size = int(rng.choice([0, 1, int(rng.integers(2, WINDOW + 1)), WINDOW]))
    step = rng.choice([0.02, 0.1, 0.4])
    points = [np.cumsum(np.append(0.0, rng.uniform(-step, step, size))) for _ in range(2)]
    reach = np.empty((4, INTERVALS))
    for i, own in enumerate(points):
        middle = own[np.sort(rng.integers(0, size + 1, INTERVALS))] + rng.normal(0, 0.2, INTERVALS)
        wide = rng.choice([0.2, 0.6, 1.5]) * rng.uniform(0.3, 1.5, INTERVALS)
        reach[2 * i], reach[2 * i + 1] = middle - wide, middle + wide
    steps = rng.integers(0, int(rng.choice([1, 3, M + 1])), INTERVALS)
    planned = np.minimum(np.cumsum(np.append(0, steps[1:])), size)
    return points, reach, planned


def disagreements(plan: Callable[..., np.ndarray], count: int) -> int:
    rng, wrong = np.random.default_rng(9), 0
    for _ in range(count):
        points, reach, planned = problem(rng)
        expected = predicted_indices(
            (points[0], points[1]), (Reach(*reach[:2]), Reach(*reach[2:])), planned, M
        )
        wrong += not np.array_equal(plan(points, reach, planned), expected)
    return wrong


def test_indices_are_those_of_the_reference_which_looks_at_every_point_again() -> None:
    assert disagreements(probe(), 6000) == 0


PLANNING: dict[str, Callable[[str], str]] = {
    "a round too few": swap("round < G64_ROUNDS", "round < (G64_ROUNDS - 1)"),
    "one point less": swap("k < (G64_POINTS + 1)", "k < G64_POINTS"),
    "planned points are asked again": swap("(number > given) ?", "(number > begin) ?"),
    "planned points do not end an interval": swap("(number <= after) ? 1 : good", "good"),
    "the first that is good": swap("(good == 1) ? number", "((good == 1) && (ends < 0)) ? number"),
    "nothing is narrowed": swap("g64_narrow(self, next);", ""),
    "y is not narrowed": swap("self->least_on_y[i] = sg_max", "(void)sg_max"),
    "waits at what was planned": swap("(before > planned) ? before : planned", "before"),
    "a part is asked for ever": swap("parts -= 1;", "parts = 0;"),
    "waits at the end alone": swap("g64_wait(self, part, interval, ends);", ""),
    "rejoins from the beginning": swap("from = i + 1;", "from = 0;"),
    "y is never in reach": swap("if (y > box->greatest_y)", "if (y > box->greatest_x)"),
    "the last point": swap("if (number <= count)", "if (number < count)"),
}


@pytest.mark.parametrize("name", PLANNING)
def test_every_mutant_of_the_planning_is_found(name: str) -> None:
    assert disagreements(probe(PLANNING[name]), 1500) > 0
