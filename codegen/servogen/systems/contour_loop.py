"""Closed loop of the contour controller on its machine: identified axes, encoders, a timed contour.

Errors are those of the paper: of tracking, to the point of the contour that was due, and of the
contour, to the nearest one, which a motion tells by its own ``distance``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from servogen.controllers.contour_estimate import wanted_state
from servogen.controllers.contour_lq_design import ContourLqDesign
from servogen.controllers.design import Reference, Status
from servogen.plants.statespace import Discrete
from servogen.precision import FloatArray, IntArray
from servogen.systems.contour_motion import ContourMotion


@dataclass(frozen=True)
class ContourRun:
    """K samples: wanted, output, command (K, p); status, limited, known (K,)."""

    motion: ContourMotion
    wanted: FloatArray
    output: FloatArray
    command: FloatArray
    status: IntArray
    limited: IntArray
    known: IntArray

    def tracking_rms_m(self, last: int) -> float:
        """Over the last samples."""
        off = self.output[-last:] - self.wanted[-last:]
        return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))

    def contour_rms_m(self, last: int) -> float:
        """Likewise."""
        first = len(self.output) - last
        return float(np.sqrt(np.mean(self.motion.distance(self.output[first:], first) ** 2)))


@dataclass(frozen=True)
class Trouble:
    """What keeps a machine from doing as it is told, the controller not knowing.

    Attributes:
        axis: it stands still in samples ``begin`` to ``end``, the last one excluded.
        limits: (p,) that the drives cut commands to.
    """

    axis: int
    begin: int
    end: int
    limits: FloatArray


def moving_state(axis: Discrete, points: FloatArray) -> FloatArray:
    """(n,) state that has been following a motion at the velocity between its first two points."""
    found = wanted_state(axis)
    result: FloatArray = found.on_position * points[0] + found.on_advance * (points[1] - points[0])
    return result


def run_contour(
    design: ContourLqDesign,
    controller: Reference,
    machine: Sequence[Discrete],
    motion: ContourMotion,
    samples: int,
    encoder_m: float | FloatArray | None = None,
    moving: bool = True,
    advance: Callable[[], None] | None = None,
    trouble: Trouble | None = None,
) -> ContourRun:
    """``controller`` of ``design`` on ``machine``, already moving with the contour or at rest.

    Args:
        machine: the axes as they are; those of the design where the model is right. States of the
            controller are in the design's coordinates, so orders have to agree without an encoder.
        encoder_m: its count, or (p,) of each axis; None: the whole state is known.
        advance: told of every sample. trouble: of the machine.
    """
    first = motion.points[:2] if moving else np.repeat(motion.points[:1], 2, axis=0)
    states = [moving_state(axis, first[:, a]) for a, axis in enumerate(machine)]
    controller.call("reset", {"position": motion.points[0]})
    outputs, commands, told = [], [], []
    for k in range(samples):
        position = np.array([axis.c @ x for axis, x in zip(machine, states, strict=True)])
        ahead = motion.points[k : k + design.preview + 1].ravel()
        if encoder_m is None:
            hidden = [
                axis.model.from_state[1:] @ x for axis, x in zip(design.axes, states, strict=True)
            ]
            given = {"position": position, "hidden": np.concatenate(hidden), "reference": ahead}
            status, out = controller.call("follow", given)
        else:
            counted = np.round(position / encoder_m) * encoder_m
            status, out = controller.call("step", {"position": counted, "reference": ahead})
        command = np.asarray(out["command"], dtype=np.float64)
        outputs.append(position)
        commands.append(command)
        told.append([int(status), int(np.asarray(out["limited"])), int(np.asarray(out["known"]))])
        taken = command if trouble is None else np.clip(command, -trouble.limits, trouble.limits)
        states = [
            axis.a @ x + axis.b * u for axis, x, u in zip(machine, states, taken, strict=True)
        ]
        if trouble is not None and trouble.begin <= k < trouble.end:
            held = trouble.axis
            states[held] = moving_state(machine[held], np.repeat(position[held], 2))
        if advance is not None:
            advance()
    answers = np.array(told)
    return ContourRun(
        motion,
        motion.points[:samples],
        np.array(outputs),
        np.array(commands),
        answers[:, 0],
        answers[:, 1],
        answers[:, 2],
    )


def worst_status(run: ContourRun) -> Status:
    """Of the whole run."""
    return Status(int(np.max(run.status)))
