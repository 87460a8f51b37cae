"""What the stroke's margin and a stage that has stopped leave of the stroke and of the reserve."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servogen.errors import InputError
from servogen.project.governor_load import GovernorProject, load_governor_project
from servogen.systems.command_governor import governor_design, governor_machine
from servogen.systems.command_governor_faults import check_settling
from servogen.systems.command_governor_motion import slow_motion_of

SMALL = Path(__file__).parents[2] / "examples/command_governor/small.toml"


@cache
def small() -> GovernorProject:
    return load_governor_project(SMALL)


def changed(section: str, **values: Any) -> GovernorProject:
    project = small()
    part = getattr(project.controller, section).model_copy(update=values)
    return replace(project, controller=project.controller.model_copy(update={section: part}))


def test_the_motion_keeps_the_stroke_s_margin_and_the_reserve() -> None:
    margin, project = 0.004, changed("governor", stroke_margin_m=0.004)
    x = 0.1 + 0.03 * np.sin(np.linspace(0.0, 9.0, 300))
    away = np.abs(slow_motion_of(project, np.stack([x, x], axis=1))[:, 0] - x)
    allowed = 0.025 - margin - project.controller.motion.stroke_reserve_m
    assert np.max(away) == pytest.approx(allowed, rel=1e-9)


def test_the_reserve_is_more_than_a_stage_may_lack_and_stand_for() -> None:
    design = governor_design(governor_machine(small()))
    needed = max(
        own.program.settle_m + own.tol.margin * own.program.scale_m + own.standing_m
        for own in design.axes
    )
    check_settling(changed("motion", stroke_reserve_m=1.01 * needed), design)
    for share in (0.99, 0.6):
        with pytest.raises(InputError, match="stroke_reserve_m"):
            check_settling(changed("motion", stroke_reserve_m=share * needed), design)
