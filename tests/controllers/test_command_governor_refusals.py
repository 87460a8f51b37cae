"""One axis of the extended command governor: what it is given wrongly, told and survived."""

import numpy as np
import pytest
from governed_machine import CENTRE, LIMITS, T_S, admissible, machine, stage

from servogen.controllers.command_governor_axis import AxisGovernor
from servogen.controllers.command_governor_design import GovernorSettings
from servogen.controllers.command_governor_program import GovernorWeights, governor_program
from servogen.controllers.design import Status
from servogen.controllers.errors import DesignError
from servogen.sets.auxiliary import laguerre
from servogen.sets.extended import extended_set

HORIZON = 12
WIDE = np.full(HORIZON + 2, 9.0)


def governor() -> AxisGovernor:
    return AxisGovernor(machine(HORIZON, GovernorSettings()).axes[0])


def test_a_push_gives_a_status_and_a_held_command() -> None:
    """Thrown out of the set: INFEASIBLE, the plan goes on; once back, OK."""
    axis = governor()
    axis.reset(0.1)
    reference = np.full(HORIZON + 1, 0.11)
    assert axis.step(np.array([0.1, 0.0, 0.0]), reference, -WIDE, WIDE)[0] is Status.OK
    for velocity in (0.3, -0.3):
        moved, thrown = axis.moved(), np.array([0.1, velocity, 0.0])
        assert axis.step(thrown, reference, -WIDE, WIDE)[0] is Status.INFEASIBLE
        np.testing.assert_array_equal(axis.plan, moved)
    assert axis.step(np.array([0.1, 0.0, 0.0]), reference, -WIDE, WIDE)[0] is Status.OK


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 1e3])
def test_bad_inputs_get_the_moved_plan(bad: float) -> None:
    axis = governor()
    inputs = {
        "position": 0.1, "velocity": 0.0, "acceleration": 0.0,
        "reference": np.full(HORIZON + 1, 0.12), "low": -WIDE * 0.02, "high": WIDE * 0.02,
    }  # fmt: skip
    assert axis.call("step", inputs)[0] is Status.NOT_READY
    assert axis.call("reset", {"position": 0.1})[0] is Status.OK
    assert axis.call("step", inputs)[0] is Status.OK
    for name in ("velocity", "reference"):
        moved = axis.moved()
        value = np.full(HORIZON + 1, bad) if name == "reference" else bad
        status, out = axis.call("step", {**inputs, name: value})
        assert status in (Status.NOT_FINITE, Status.OUT_OF_RANGE)
        np.testing.assert_array_equal(axis.plan, moved)
        assert (out["command"], out["iterations"]) == (axis.plan[0], 0)
    assert axis.call("reset", {"position": bad})[0] is not Status.OK
    assert axis.call("step", inputs)[0] is Status.NOT_READY


def test_designs_that_cannot_be_made() -> None:
    target = admissible(HORIZON)
    dtype = np.dtype(np.float64)
    sequences = extended_set(stage(), T_S, laguerre(3, 0.5), 1, LIMITS, CENTRE, 0.02)
    with pytest.raises(DesignError, match="shift register"):
        governor_program(stage(), sequences, GovernorWeights(), False, 0.0, dtype)
    for weights in (GovernorWeights(0.0), GovernorWeights(1.0, -1.0)):
        with pytest.raises(DesignError, match="weights"):
            governor_program(stage(), target, weights, False, 0.0, dtype)
    for margin in (-1e-3, 0.025):
        with pytest.raises(DesignError, match="stroke_margin_m"):
            governor_program(stage(), target, GovernorWeights(), False, margin, dtype)
