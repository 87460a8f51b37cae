"""The small servo axes of tests/sil on the bench that the checks work on."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from servo_designs import Axis, package, parts

from servogen.emit.package import CPackage
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.coverage import Covered, cover
from servogen.evidence.coverage_list import reviewed
from servogen.precision import PRECISIONS
from servogen.sil.player import Play
from servogen.sil.recorder import Recorder
from servogen.sil.servo_scenarios import servo_suite
from servogen.steps.counted import count_emitted

SEED = 11
# Between them they make every line of the templates of a servo axis.
AXES = {
    "headstock": Axis("ev64", moves=2),
    "slide": Axis("es32", "slide", "float32", notch=False),
    "pair": Axis("ep64", "pair"),
}
STEPS = 400


def loop(axis: Axis, samples: int) -> Play:
    """The MPC's reference around its own model, on a swing that its current limit cuts."""
    own, mpc = parts(axis), parts(axis).mpc
    recorder = Recorder(own.controller())
    plant, taken = mpc.problem.plant, mpc.problem.horizons.trajectory
    time = np.arange(samples + taken + 1) / 50.0
    path = np.outer(5.0 * np.sin(2.0 * np.pi * time), np.ones(plant.outputs))
    state: np.ndarray = np.zeros(plant.order)
    scalar = plant.outputs == 1

    def told(values: np.ndarray) -> np.ndarray:
        return np.mod(values, mpc.turn) if mpc.turn else values

    recorder.call("reset", {"position": 0.0 if scalar else np.zeros(plant.outputs)})
    for k in range(samples):
        position = told(plant.c @ state)
        _, out = recorder.call(
            "step",
            {
                "position": float(position[0]) if scalar else position,
                "reference": told(path[k + 1 : k + 1 + taken]).ravel(),
            },
        )
        current = np.atleast_1d(np.asarray(out["current"], dtype=float))
        state = plant.a @ state + plant.b @ current
    return recorder.play("closed loop")


def subject(axis: Axis, made: CPackage | None = None) -> Subject:
    """An axis as a subject; ``made`` stands in for its package where a fault is planted."""

    def plays(count: int) -> list[Play]:
        return [
            Play(case.name, case.reference().declaration.prefix, tuple(case.calls))
            for case in servo_suite(parts(axis), SEED, count)
        ]

    return Subject(
        made or package(axis),
        PRECISIONS[axis.precision],
        counts(axis),
        plays,
        lambda samples: [loop(axis, samples or 400)],
    )


@cache
def counts(axis: Axis):
    return count_emitted(package(axis))


@cache
def covered(name: str) -> Covered:
    """What the suite and the closed loop reach of one of ``AXES``."""
    one = subject(AXES[name])
    return cover(one, [*one.suite(STEPS), *one.closed_loops(None)], reviewed())


def bench(axis: Axis) -> Bench:
    """The axis in both precisions, its own first."""
    other = "float32" if axis.precision == "float64" else "float64"
    return Bench(axis.prefix, (subject(axis), subject(replace(axis, precision=other))))
