"""100,000 parameters of the servo drive with three moves."""

from __future__ import annotations

import numpy as np
from explicit_problems import LIMIT_MA

from servogen.explicit.cones import cone_of
from servogen.explicit.pieces import hyperplanes
from servogen.explicit.solution import ExplicitSolution

THIRD = 34_000
HALF = np.array([100.0, 100.0, np.pi, np.pi, LIMIT_MA, 360.0, 360.0, 360.0])
THIRDS = {
    "inside": slice(0, THIRD),
    "facets": slice(THIRD, 2 * THIRD),
    "far": slice(2 * THIRD, 3 * THIRD),
}
# What the terms that eta is summed from may come to, in bounds of 1000 mA. A rounding of such a sum
# is 1e-16 of it, 1e-7 mA here, and there are a dozen: not much farther out no float64 holds a first
# move to 1e-6 mA, whoever computes it. A law's own coefficients are known to a few roundings, which
# eta multiplies: it goes ten times less far.
TERMS = 1e6


def parameters(solution: ExplicitSolution) -> np.ndarray:
    """A third anywhere in the facts' box and about the origin, a third on or next to facets, a
    third far outside any box."""
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
    return np.vstack([inside, eta @ back.T, _far(solution, generator)])


def _far(solution: ExplicitSolution, generator: np.random.Generator) -> np.ndarray:
    """From within the regions to where they go on without an end, two of three in regions whose
    first move is free, and farther in directions that do not show in eta: 1e2 to 1e6 boxes."""
    size = solution.image.size
    columns = np.max(np.abs(solution.image.matrix), axis=0)  # terms of a parameter of one
    unseen = np.linalg.svd(solution.image.matrix / columns)[2][size:]
    back = np.linalg.pinv(solution.image.matrix / columns)
    free = [i for i, law in enumerate(solution.law_of) if np.any(solution.laws.gains[law])]
    regions = np.where(
        generator.random(THIRD) < 2 / 3,
        generator.choice(free, THIRD),
        generator.integers(0, len(solution.regions), THIRD),
    )
    cones = [cone_of(region.h, region.k).rays for region in solution.regions]
    eta = np.empty((THIRD, size))
    for i, region in enumerate(regions):
        rays = cones[region]
        away = rays[:, -1] < 1e-9
        corners = rays[~away, :-1] / rays[~away, -1:]
        eta[i] = generator.dirichlet(np.ones(len(corners))) @ corners
        if np.any(away):
            along = generator.dirichlet(np.ones(np.count_nonzero(away))) @ rays[away, :-1]
            most = min(TERMS / np.sum(np.abs(back @ along)), 0.1 * TERMS / np.max(np.abs(along)))
            eta[i] += 10.0 ** generator.uniform(-2.0, 0.0) * most * along
    seen = eta @ back.T
    beside = generator.normal(size=(THIRD, len(unseen))) @ unseen
    beside *= 10.0 ** generator.uniform(4.0, np.log10(TERMS), (THIRD, 1)) / np.sum(
        np.abs(beside), axis=1, keepdims=True
    )
    far: np.ndarray = (seen + beside) / columns
    return far
