"""Closed loop of the finite-preview controller of Tomizuka and Whitney, the paper's baseline."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servogen.controllers.design import Status
from servogen.controllers.finite_preview import finite_preview
from servogen.plants.statespace import Discrete, FloatArray
from servogen.systems.contour_loop import ContourRun, moving_state
from servogen.systems.contour_task import ContourTask


def run_previewed(
    machine: Sequence[Discrete],
    task: ContourTask,
    tracking: float,
    control: float,
    preview: int,
    held: bool,
    limits: FloatArray,
) -> ContourRun:
    """Every axis by itself, its whole state known; see ``finite_preview`` for the other arguments.

    Args:
        limits: (p,) that its commands are cut to.
    """
    points = task.motion.points
    output = np.zeros((task.samples, len(machine)))
    command = np.zeros((task.samples, len(machine)))
    cut = np.zeros(task.samples, dtype=np.int64)
    for a, axis in enumerate(machine):
        law = finite_preview(axis, tracking, control, preview, held)
        along = np.asarray(points[:, a], dtype=np.float64)
        begun = along if task.moving else np.repeat(along[:1], 2)
        state: FloatArray = np.array(moving_state(axis, begun), dtype=np.float64)
        for k in range(task.samples):
            asked = law.command(state, along[k + 1 : k + 1 + preview])
            command[k, a] = np.clip(asked, -limits[a], limits[a])
            cut[k] += command[k, a] != asked
            output[k, a] = axis.c @ state
            state = axis.a @ state + axis.b * command[k, a]
    return ContourRun(
        task.motion,
        points[: task.samples],
        output,
        command,
        np.full(task.samples, int(Status.OK)),
        cut,
        np.full(task.samples, preview),
    )
