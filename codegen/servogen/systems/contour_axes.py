"""What makes a model an axis: one integrator, driven and seen, and every other mode decaying."""

from __future__ import annotations

import numpy as np

from servogen.controllers.errors import DesignError
from servogen.plants.statespace import Discrete, FloatArray

# An identified integrator drifts: so far below one it still is one, and by so much it may grow.
INTEGRATOR, GROWTH = 0.02, 1e-3
# What an input or an output has of the integrator, of its own size and the eigenvector's: rounding
# leaves less, a gain in a small unit more.
LEAST_SHARE = 1e-13
# Samples within which what is not the position has to decay by a factor of e.
SLOWEST_SAMPLES = 2000


def check_axis(plant: Discrete) -> None:
    """Judge the eigenvalues of a sampled axis.

    Raises:
        DesignError: by a, b or c, with the eigenvalue at fault.
    """
    values, right = np.linalg.eig(plant.a)
    integrator = int(np.argmin(np.abs(values - 1.0)))
    near = abs(values[integrator] - 1.0) <= INTEGRATOR
    if not (near and abs(values[integrator]) <= 1.0 + GROWTH):
        raise DesignError(
            "a",
            f"without an integrator, its eigenvalue nearest to 1 is {_told(values[integrator])}",
            f"an eigenvalue of 1, the position's (from {1.0 - INTEGRATOR:g} to {1.0 + GROWTH:g}): "
            "commands are velocities",
        )
    for k, value in enumerate(values.tolist()):
        if k != integrator and abs(value) > 1.0 - 1.0 / SLOWEST_SAMPLES:
            raise DesignError(
                "a",
                f"with a mode of eigenvalue {_told(value)} besides its integrator",
                "an axis of which every mode but its position's decays, by a factor of e within "
                f"{SLOWEST_SAMPLES} samples",
            )
    if _share(plant.c, right[:, integrator]) < LEAST_SHARE:
        raise DesignError(
            "c", plant.c.tolist(), "an output that shows the integrator, which is the position"
        )
    left_values, left = np.linalg.eig(plant.a.T)
    own = int(np.argmin(np.abs(left_values - values[integrator])))
    if _share(plant.b, left[:, own]) < LEAST_SHARE:
        raise DesignError(
            "b", plant.b.tolist(), "an input that moves the integrator, which is the position"
        )


def _share(of: FloatArray, vector: FloatArray) -> float:
    size = float(np.linalg.norm(of) * np.linalg.norm(vector))
    return float(abs(of @ vector)) / size if size > 0.0 else 0.0


def _told(value: complex) -> str:
    if abs(value.imag) < 1e-12:
        return f"{value.real:.9g}"
    return f"{value.real:.6g}{value.imag:+.6g}j"
