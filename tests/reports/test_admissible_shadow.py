"""The shadow of the admissible set: corners lie on it, nothing of the set lies outside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servogen.reports import ReportData
from servogen.reports.set_figure import shadow
from servogen.sets.polyhedron import maximise


def test_shadow_is_the_projection(bare: ReportData) -> None:
    own = bare.machine.sets.x
    corners = shadow(own)
    assert len(corners) >= 4
    for angle in np.linspace(0.0, 2.0 * np.pi, 60):
        # directions weighted alike in both coordinates
        direction = np.array([np.cos(angle), np.sin(angle)]) / np.max(np.abs(corners), axis=0)
        objective = np.concatenate([direction, np.zeros(own.h_x.shape[1] - 2)])
        reach = maximise(own.h_x, own.k, objective).value
        assert abs(np.max(corners @ direction) - reach) < 1e-7


def test_a_set_without_inside_has_no_shadow(bare: ReportData) -> None:
    own = bare.machine.sets.x
    assert shadow(replace(own, h_x=own.h_x[:1], h_r=own.h_r[:1], k=own.k[:1])).shape == (0, 2)
