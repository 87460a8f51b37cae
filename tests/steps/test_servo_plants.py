"""Plain machines, from the file to the proof of their lookups, and what only they show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from servo_example import changed

from servogen.emit.package import emit_package
from servogen.precision import PRECISIONS
from servogen.progress import Silent
from servogen.project.servo_load import load_servo_project
from servogen.steps.servo_drive import prepare_servo

CART = """schema = 1
name = "cart"
system = "servo_drive"
[drive]
model = "matrices"
a = [[1.0, {t}], [0.0, 1.0]]
b = [{half}, {gain}]
c = [1.0, 0.0]
[axis]
encoder_resolution_deg = 0.001
turn_deg = {turn}
position_range_deg = 720.0
[sampling]
sample_time_s = {t}
current_sample_time_s = {t}
[controller.mpc]
prediction_horizon = {steps}
trajectory_horizon = {ahead}
control_horizon = {moves}
weight_error = {weights}
weight_change = {changes}
current_limit_ma = {limit}
{more}
[reference]
shape = "trapezoid"
stroke_deg = 40.0
speed_deg_per_s = 60.0
acceleration_deg_per_s2 = 300.0
[output]
precision = "float64"
"""
FREE = {
    "t": 0.001, "half": 1e-6, "gain": 0.002, "turn": 360, "steps": 20, "moves": 3, "weights": 1e4,
    "limit": 1000.0, "more": "", "ahead": 3, "changes": 1.0,
}  # fmt: skip
FEW = "position_bound_deg = [-1, 91]\nposition_bound_samples = [1, 10]"
CARTS = {
    # a law that half a tree answers by lies in the other half too
    "plain": FREE,
    # weights that differ from step to step, some of them zero
    "weights of steps": FREE
    | {"steps": 5, "weights": [1e4, 0.0, 2e4, 0.0, 1e3], "changes": [1.0, 5.0, 0.1]},
    # bounds of the program over states and inputs of 1e5, where a vertex is found to 1e-7
    "position": FREE | {"turn": 0, "moves": 2, "more": FEW},
    # laws of which one is a million times as steep as what another one's rounding is seen by
    "reference aside": FREE
    | {
        "t": 0.0005,
        "half": 1.6584294781451803e-07,
        "gain": 0.0006633717912580721,
        "turn": 0,
        "steps": 10,
        "moves": 1,
        "weights": 176.8,
        "limit": 267.0,
        "ahead": 1,
        "more": 'reference_extension = "zero_order"\n'
        "position_bound_deg = 166.1\nposition_bound_samples = [1, 5]",
    },
    # laws that differ by little beside one of a million times their size
    "position and steps": FREE
    | {"turn": 0, "steps": 10, "moves": 2, "more": f"current_step_limit_ma = 100\n{FEW}"},
}


@pytest.mark.parametrize("name", CARTS)
def test_a_cart_s_lookup_is_proved(name: str, tmp_path: Path) -> None:
    path = tmp_path / "servogen.toml"
    path.write_text(CART.format(**CARTS[name]), encoding="utf-8")
    own = prepare_servo(load_servo_project(path), Silent())
    packages = [
        emit_package(own.project.name, own.declarations(PRECISIONS[precision]))
        for precision in PRECISIONS
    ]
    for proof in own.proofs:
        claims = proof.prove(packages, Silent())
        assert claims
        assert [claim.name for claim in claims if not claim.holds] == []


def test_a_reference_limits_no_feasible_set(tmp_path: Path) -> None:
    """What cancels to rounding is zero, not a limit at 1e20 degrees."""
    path = tmp_path / "servogen.toml"
    path.write_text(CART.format(**CARTS["reference aside"]), encoding="utf-8")
    own = prepare_servo(load_servo_project(path), Silent())
    feasible = own.parts.lookup.feasible
    assert feasible is not None
    assert np.all(feasible.rows[:, own.parts.mpc.problem.layout.reference] == 0.0)
    assert np.all(np.any(feasible.rows != 0.0, axis=1))


def test_an_axis_that_is_lost_fails_without_a_limit_of_its_own(tmp_path: Path) -> None:
    """Half a turn behind it would go on the other way round."""
    none = ("tracking_error_limit_deg = 0.2", "")
    far = ("acceleration_deg_per_s2 = 1000.0", "acceleration_deg_per_s2 = 1e6")
    weak = ("current_limit_ma = 1000.0", "current_limit_ma = 20.0")
    fast = ("speed_deg_per_s = 360.0", "speed_deg_per_s = 4000.0")
    own = prepare_servo(load_servo_project(changed(tmp_path, none, far, weak, fast)), Silent())
    found = own.simulate(None, Silent())
    assert np.max([row.largest_error_deg for row in found.rows]) > 180.0
    assert not found.passed
    assert any("tracking error" in fault and "(axis.turn_deg)" in fault for fault in found.faults)
