"""Programs whose rows nearly depend and whose z_unc is far away, each with a point that keeps them.

For the tests and for ``benchmarks/near_rows.py``, which counts how they end.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from servogen.controllers.qp_solver_design import QpSolverDesign, design_qp_solver
from servogen.precision import PRECISIONS

Array = np.ndarray
CAP = 200
# Powers of ten: H's eigenvalues, and by how much a row stands off from another one.
WORST = {"float64": 11.0, "float32": 3.5}
APART = {"float64": (-5.0, -1.0), "float32": (-3.0, -0.5)}
TURNS = 10


class Turn(NamedTuple):
    """``point`` (n,) of size one keeps low <= A z <= high to a rounding; f, low and high are in the
    precision."""

    point: Array
    linear: Array
    low: Array
    high: Array


def near_program(
    seed: int, precision: str, apart: tuple[float, float] | None = None
) -> tuple[Array, Array, Iterator[Turn]]:
    """H, A, and ``TURNS`` times f and bounds, of which every tenth row has two that are equal."""
    rng = np.random.default_rng(seed)
    real = PRECISIONS[precision].dtype
    n = int(rng.integers(2, 12))
    m = int(rng.integers(n, 3 * n + 1))
    worst = rng.uniform(0.0, WORST[precision])
    base = np.linalg.qr(rng.normal(size=(n, n)))[0]
    values = 10.0 ** rng.uniform(-worst, 0.0, n)
    values[0], values[-1] = 1.0, 10.0**-worst
    hessian = (base * values) @ base.T
    hessian = 0.5 * (hessian + hessian.T)
    rows = rng.normal(size=(m, n))
    for i in range(1, m):
        if rng.random() < 0.5:
            other = rows[int(rng.integers(0, i))] * rng.choice([-1, 1])
            rows[i] = other + 10.0 ** rng.uniform(*(apart or APART[precision])) * rng.normal(size=n)
    size = np.sqrt(np.einsum("ij,ij->i", rows, np.linalg.solve(hessian, rows.T).T))

    def turns() -> Iterator[Turn]:
        for _ in range(TURNS):
            point = rng.normal(size=n)
            linear = -hessian @ (rng.normal(size=n) * 10.0 ** rng.uniform(-1.0, 3.0))
            width = 10.0 ** rng.uniform(-3.0, 1.0, m) * size * (rng.random(m) > 0.1)
            part, middle = rng.random(m), rows @ point
            low, high = middle - width * part, middle + width * (1.0 - part)
            yield Turn(point, *(x.astype(real) for x in (linear, low, high)))

    return hessian, rows, turns()


def near_design(
    seed: int, precision: str, accept: float, apart: tuple[float, float] | None = None
) -> QpSolverDesign:
    """The solver of one of them."""
    hessian, rows, _ = near_program(seed, precision, apart)
    return design_qp_solver(f"near_{seed}", PRECISIONS[precision], hessian, rows, CAP, accept)
