"""The machine of paper 4 at its own sizes: M = 500, 40 periods, three instants in each."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

from governed_machine import EPSILON, STROKE, admissible, figures, least_motion, machine, stage

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.design import Status
from servogen.systems.command_governor_loop import check_drawing, excess, run_governed

M, HORIZON = 500, 40
PATH = figures(1, 4, 6000)


@pytest.mark.parametrize("pattern", [False, True], ids=["minimal motion", "pattern"])
def test_a_drawing_at_the_sizes_of_the_paper(pattern: bool) -> None:
    """Facts of the machine: every limit at the instants, 0.28 % of velocity between them and the
    stroke kept there too by a quiet reference, some 1 % and a quarter of a millimetre by the
    pattern itself, which is faster."""
    chosen = machine(HORIZON, None, M)
    assert 2 * len(admissible(HORIZON).h_x) == 544
    assert (chosen.window, chosen.axes[0].program.variables) == (20501, 41)
    reference = PATH if pattern else least_motion(PATH, 25)
    check_drawing(chosen, PATH, reference, EPSILON)
    done = run_governed(chosen, (stage(), stage()), PATH, reference, CommandGovernor(chosen))
    assert done.complete
    assert set(done.status_axis.ravel()) <= {Status.OK, Status.BACKUP}
    # the instants are not fast samples: 500 is no multiple of 3
    at_ends, between = excess(chosen, done, M), excess(chosen, done, 1)
    assert max(at_ends.position, at_ends.velocity, at_ends.acceleration, at_ends.stroke) <= 1e-9
    assert 0.0 < between.velocity < (0.025 if pattern else 0.005)
    assert between.stroke < (0.00025 / STROKE if pattern else 0.0)
    ideal = (len(PATH) - 1) / M * done.period_s
    assert ideal < done.time_s < (2.0 if pattern else 4.0) * ideal
    assert np.max(done.iterations) < chosen.axes[0].solver.cap
