"""A position bound from the project file to the C, and what is refused of one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from servo_example import changed, system

from servogen.errors import InputError
from servogen.progress import Silent
from servogen.project.systems import load_any_project
from servogen.steps.equivalence import equivalence
from servogen.steps.prepare import Prepared, prepare
from servogen.systems.servo_drive import tracking_problem
from servogen.systems.servo_loop import track_ideal

pytestmark = pytest.mark.xdist_group("servo_drive")
HELD = (
    ("turn_deg = 360 ", "turn_deg = 0 "),
    ("position_range_deg = 36000.0", "position_range_deg = 360.0"),
    ("[controller.estimator]", "position_bound_deg = 1.0\n[controller.estimator]"),
)
FEW = ("position_bound_deg = 1.0", "position_bound_deg = 1.0\nposition_bound_samples = [1, 10]")
SMALL = ("control_horizon = 3", "control_horizon = 2")
SHORT = ("stroke_deg = 270.0", "stroke_deg = 0.9")


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Prepared:
    path = changed(tmp_path_factory.mktemp("bounded"), *HELD, FEW, SMALL, SHORT)
    return prepare(load_any_project(path), Silent())


def test_a_bound_at_a_few_samples_is_built_proved_and_equal(prepared: Prepared) -> None:
    own = prepared.system
    problem = own.parts.mpc.problem.qp
    assert problem.rows.shape == (4, 2)
    assert own.parts.lookup.feasible is not None
    found = equivalence(prepared, 30, Silent())
    assert found.passed, found.lines()


def test_motion_is_held_at_the_bound(prepared: Prepared) -> None:
    """A reference that goes beyond: the axis stops at the bound and stays there."""
    own = prepared.system
    problem, plant = tracking_problem(own.servo), own.servo.plant
    run = track_ideal(problem, plant, lambda t: np.minimum(20.0 * t, 1.5), 250)
    assert np.max(run.output) <= 1.0 + 1e-9
    assert np.min(run.output[200:]) > 0.97
    assert np.max(run.reference) == 1.5
    given = own.parts.controller()
    assert given.call("reset", {"position": 0.0})[0] == 0
    state, seen, statuses = np.zeros(plant.order), [], set()
    for k in range(250):
        ahead = np.minimum(20.0 * (k + 1 + np.arange(3)) * plant.sample_time_s, 1.5)
        output = float((plant.c @ state)[0])
        status, out = given.call("step", {"position": output, "reference": ahead})
        statuses.add(int(status))
        state = plant.a @ state + plant.b[:, 0] * float(np.asarray(out["current"]))
        seen.append(output)
    # the filter's estimate and float32 leave a hair
    assert np.max(seen) <= 1.0 + 2e-3
    assert np.min(seen[200:]) > 0.9


@pytest.mark.parametrize(
    ("more", "key", "told"),
    [
        ((), "controller.mpc", "fewer samples than the 50 they hold at"),
        ((("= 50", "= 4"),), "controller.lookup.max_nodes", "such as [1, 4]"),
        ((FEW, ("[1, 10]", "[10, 1]")), "controller.mpc.position_bound_samples", "ascending"),
        ((FEW, ("[1, 10]", "[0, 10]")), "controller.mpc.position_bound_samples", "from 1 to"),
        ((FEW, ("position_bound_deg = 1.0\n", "")), "controller.mpc.position_bound_samples",
         "none without position_bound_deg"),
    ],
)  # fmt: skip
def test_a_bound_that_is_too_much_is_one_sentence(
    tmp_path: Path, more: tuple[tuple[str, str], ...], key: str, told: str
) -> None:
    with pytest.raises(InputError) as caught:
        system(tmp_path, *HELD, *more)
    text = str(caught.value)
    assert text.startswith(f"{tmp_path / 'servogen.toml'}: {key} ")
    assert told in text
    assert "\n" not in text
