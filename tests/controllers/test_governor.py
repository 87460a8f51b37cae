"""The governor against (14) as the paper writes it, tried point by point on the whole set."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from core_designs import LIMITS, OTHER_LIMITS, Variant, admissible, design, slow_stage

from servogen.controllers.design import Status
from servogen.controllers.governor import Governor
from servogen.plants.statespace import discretise
from servogen.sil.random_calls import random_calls

VARIANTS = {
    "both ends": Variant(points=20),
    "as printed": Variant(points=20, both_ends=False),
    "axes differ": Variant(points=20, differing=True),
    "fourth order": Variant(points=20, order=4),
    "inter-sample rows": Variant(points=20, inter=2),
}


@cache
def plant_of(order: int, bandwidth: float):
    return discretise(slow_stage(order, bandwidth), 0.03)


def excess_of_eta(v: Variant, inputs, eta: int, keep: float) -> float:
    """Largest violation of (14b)-(14d), as a share of the bound, were eta points taken."""
    worst = -np.inf
    axes = [(45.0, LIMITS), (38.0, OTHER_LIMITS) if v.differing else (45.0, LIMITS)]
    names = ["position", "velocity", "acceleration", "state_3"][: v.order]
    for axis, (bandwidth, limits) in zip("xy", axes, strict=True):
        own = admissible(v.order, bandwidth, limits, v.inter)
        plant = plant_of(v.order, bandwidth)
        x = np.array([inputs[f"{axis}_{name}"] for name in names])
        path = np.append(inputs[f"last_{axis}"], inputs[f"points_{axis}"][:eta])
        r = path[-1]
        moving = own.h_r != 0.0  # rows without r are not the governor's to keep
        rows = own.h_x[moving] @ x + own.h_r[moving] * r
        worst = max(worst, np.max(rows / own.k[moving]) - keep)
        ends = [x[0]]
        if v.both_ends:
            ends.append((plant.a @ x + plant.b * r)[0])
        for end in ends:
            worst = max(worst, np.max(np.abs(path - end)) / limits.fast_range_m - keep)
    return worst


@pytest.mark.parametrize("name", VARIANTS)
def test_takes_what_brute_force_takes(name):
    v = VARIANTS[name]
    made = design(v)
    governor = Governor(made.governor)
    keep = 1.0 - made.governor.margin
    taken_counts, infeasible, decided = set(), 0, 0
    for call in random_calls(made.governor, 7, 250):
        status, outputs = governor.call("step", call.inputs)
        if status is Status.OUT_OF_RANGE:
            continue
        n = call.inputs["n_points"]
        taken = int(outputs["points_taken"])
        excess = [excess_of_eta(v, call.inputs, eta, keep) for eta in range(n + 1)]
        whole = excess_of_eta(v, call.inputs, 0, 1.0)
        if min(abs(e) for e in [whole, *excess]) < 1e-12:
            continue  # on the bound to rounding: either answer is right
        decided += 1
        allowed = [eta for eta in range(n + 1) if excess[eta] <= 0.0]
        assert taken == max(allowed, default=0)
        assert (status is Status.INFEASIBLE) == (not allowed and whole > 0.0)
        taken_counts.add(taken)
        infeasible += status is Status.INFEASIBLE
        for axis in "xy":
            path = np.append(call.inputs[f"last_{axis}"], call.inputs[f"points_{axis}"][:taken])
            assert outputs[f"reference_{axis}"] == path[-1]
            assert outputs[f"low_{axis}"] == path.min()
            assert outputs[f"high_{axis}"] == path.max()
    assert decided > 150
    assert len(taken_counts) > 5
    assert infeasible > 10


def test_search_is_not_fooled_by_a_gap():
    """kappa's predicate is not monotone: the first and the last points may be allowed where those
    between are not. The axis moves; points ahead of it are allowed, points behind it are not."""
    governor = Governor(design(Variant(points=20)).governor)

    def taken(points: np.ndarray, count: int = 20) -> int:
        inputs = still(20) | {"x_velocity": 0.5, "points_x": points, "n_points": count}
        return int(governor.call("step", inputs)[1]["points_taken"])

    grid = np.linspace(-0.034, 0.034, 137)
    allowed = np.array([taken(np.full(20, value)) == 20 for value in grid])
    good, bad = grid[allowed].min() + 1e-3, grid[~allowed & (grid > -0.01)].min()
    points = np.full(20, good)
    points[5:15] = bad
    assert taken(points) == 20
    assert taken(points, 15) == 5
    assert taken(points, 5) == 5
    assert taken(points, 16) == 16


def still(points: int):
    inputs = {
        f"{axis}_{name}": 0.0 for axis in "xy" for name in ("position", "velocity", "acceleration")
    }
    for axis in "xy":
        inputs |= {f"last_{axis}": 0.0, f"points_{axis}": np.zeros(points)}
    return inputs | {"n_points": points}


def test_a_point_out_of_range_is_refused_wherever_it_is():
    governor = Governor(design(Variant(points=20)).governor)
    inputs = still(20)
    inputs["n_points"] = 7
    status, outputs = governor.call("step", inputs)
    assert status is Status.OK
    assert outputs["points_taken"] == 7
    inputs["points_x"][19] = np.nan
    inputs["points_y"][7:] = 1e300
    status, outputs = governor.call("step", inputs)
    assert status is Status.OUT_OF_RANGE  # the worse of NaN in x and far out in y
    assert outputs["points_taken"] == 0
    assert outputs["reference_x"] == 0.0
