"""A run along a contour, judged: how close it was, what it took, what the controller said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.design import Status
from servogen.precision import FloatArray
from servogen.systems.contour_loop import ContourRun
from servogen.systems.contour_task import ContourTask

# Samples of a distance at a time: each is one pass over a few hundred pieces.
_CHUNK = 20_000


@dataclass(frozen=True)
class ContourErrors:
    """(K,) m of a whole run: to the point that was due, and to the contour."""

    tracking: FloatArray
    contour: FloatArray


@dataclass(frozen=True)
class ContourRow:
    """Errors in metres, RMS and largest of what counts; ``start_m`` and ``stop_m``: largest contour
    error before it, and distance left to the end at the last sample.

    Attributes:
        command_share: largest command of every axis over its limit.
        limited, refused, priming: samples with a command cut, an input refused, no direction known.
    """

    name: str
    tracking_rms_m: float
    tracking_max_m: float
    contour_rms_m: float
    contour_max_m: float
    start_m: float
    stop_m: float
    command_share: tuple[float, ...]
    limited: int
    refused: int
    priming: int
    samples: int


def errors_of(run: ContourRun, task: ContourTask) -> ContourErrors:
    """Of every sample of a run, which may have ended before its task."""
    tracking = np.linalg.norm(run.output - run.wanted, axis=1)
    parts = [
        task.motion.distance(run.output[start : start + _CHUNK], start)
        for start in range(0, len(run.output), _CHUNK)
    ]
    return ContourErrors(tracking, np.concatenate(parts))


def judge_contour(name: str, run: ContourRun, task: ContourTask, limits: FloatArray) -> ContourRow:
    """The row of a run to the end of its task; limits (p,) of the commands."""
    errors = errors_of(run, task)
    counted = slice(task.first, task.last)
    # a machine that is moving when the run begins finds its filters at rest: their start is no
    # part of a contour
    begun = slice(task.first if task.moving else 0, None)
    refused = (run.status != Status.OK) & (run.status != Status.PRIMING)
    return ContourRow(
        name=name,
        tracking_rms_m=_rms(errors.tracking[counted]),
        tracking_max_m=float(np.max(errors.tracking[counted])),
        contour_rms_m=_rms(errors.contour[counted]),
        contour_max_m=float(np.max(errors.contour[counted])),
        start_m=float(np.max(errors.contour[: task.first], initial=0.0)),
        stop_m=float(errors.tracking[-1]),
        command_share=tuple(float(v) for v in np.max(np.abs(run.command[begun]), axis=0) / limits),
        limited=int(np.count_nonzero(run.limited[begun])),
        refused=int(np.count_nonzero(refused)),
        priming=int(np.count_nonzero(run.status == Status.PRIMING)),
        samples=len(run.output),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
