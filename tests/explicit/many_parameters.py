"""100,000 parameters of the servo drive with three moves."""

from __future__ import annotations

import numpy as np
from explicit_problems import LIMIT_MA

from servogen.explicit.pieces import hyperplanes
from servogen.explicit.solution import ExplicitSolution

THIRD = 34_000
HALF = np.array([100.0, 100.0, np.pi, np.pi, LIMIT_MA, 360.0, 360.0, 360.0])


def parameters(solution: ExplicitSolution) -> np.ndarray:
    """A third anywhere in the facts' box and about the origin, a third on or next to facets, a
    third up to a hundred boxes away."""
    generator = np.random.default_rng(20130101)
    p = HALF.size
    inside = generator.uniform(-1.0, 1.0, (THIRD, p)) * HALF
    near = generator.uniform(-3.0, 3.0, (THIRD // 2, 3))
    back = np.linalg.pinv(solution.image.matrix)
    inside[: THIRD // 2] = near @ back.T
    planes, _ = hyperplanes(solution)
    chosen = planes[generator.integers(0, len(planes), THIRD)]
    normals = chosen[:, :3] / np.linalg.norm(chosen[:, :3], axis=1, keepdims=True)
    heights = -chosen[:, 3] / np.linalg.norm(chosen[:, :3], axis=1)
    eta = generator.uniform(-4.0, 4.0, (THIRD, 3))
    beside = generator.choice([0.0, 1e-13, -1e-13, 1e-10, -1e-10, 1e-7, -1e-7], THIRD)
    eta += normals * (heights + beside - np.sum(normals * eta, axis=1))[:, None]
    far = generator.uniform(-1.0, 1.0, (THIRD, p)) * HALF
    far *= 10.0 ** generator.uniform(0.0, 2.0, (THIRD, 1))
    return np.vstack([inside, eta @ back.T, far])
