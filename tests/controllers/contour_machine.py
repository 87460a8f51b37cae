"""The machining centre of paper 2 under the contour controller, and the oracle of its law."""

from collections.abc import Sequence

import numpy as np

from servogen.controllers.contour_lq_design import AxisData, ContourLqDesign, design_contour_lq
from servogen.controllers.contour_recursion import Machine, end_weight
from servogen.controllers.contour_weights import ContourWeights, Terminal
from servogen.plants.machining_centre import machining_centre
from servogen.plants.statespace import Discrete
from servogen.precision import FLOAT64, Precision

OUTPUT, STATIONARY = Terminal.OUTPUT, Terminal.STATIONARY
CONTROL = 2e-9
# Cases I to IV of the paper's table: terminal choice, alpha, beta.
CASES = {
    "I": (OUTPUT, 8.0, 0.0),
    "II": (OUTPUT, 1.2, 20.0),
    "III": (STATIONARY, 3.0, 0.0),
    "IV": (STATIONARY, 0.25, 15.0),
}


def weights(tracking: float, contour: float) -> ContourWeights:
    return ContourWeights(tracking, contour, CONTROL)


def axis_data(plant: Discrete) -> AxisData:
    return AxisData(plant, input_limit=20.0, reach=0.05, disturbance=0.01, count=0.8e-6)


def design(
    tracking: float,
    contour: float,
    terminal: Terminal,
    preview: int = 10,
    precision: Precision = FLOAT64,
    axes: Sequence[Discrete] = (),
) -> ContourLqDesign:
    data = [axis_data(plant) for plant in axes or machining_centre()]
    asked = weights(tracking, contour)
    return design_contour_lq("contour", precision, data, asked, terminal, preview)


def of_case(name: str, precision: Precision = FLOAT64) -> ContourLqDesign:
    terminal, tracking, contour = CASES[name]
    return design(tracking, contour, terminal, precision=precision)


def batch_input(
    axes: Sequence[Discrete],
    asked: ContourWeights,
    terminal: Terminal,
    tangents: np.ndarray,
    state: np.ndarray,
    wanted: np.ndarray,
    wanted_end: np.ndarray | None,
) -> np.ndarray:
    """(p,) first input of the least squares over all inputs at once, by numpy.

    tangents, wanted: (N, p) of points 1..N; wanted_end: (n,) x_d(N) with H_s.
    """
    machine, count = Machine.of(axes), len(wanted)
    n, p = machine.a.shape[0], len(axes)
    rows, right = [], []
    free, driven = state, np.zeros((n, count * p))
    for j in range(count):
        driven = machine.a @ driven
        driven[:, j * p : (j + 1) * p] += machine.b
        free = machine.a @ free
        last = j == count - 1
        q = asked.output_weight(tangents[j])
        if last and terminal is STATIONARY:
            values, vectors = np.linalg.eigh(end_weight(axes, asked, terminal, q))
            root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
            assert wanted_end is not None
            rows.append(root @ driven)
            right.append(root @ (wanted_end - free))
        else:
            values, vectors = np.linalg.eigh(q)
            root = np.sqrt(values)[:, None] * vectors.T
            rows.append(root @ machine.c @ driven)
            right.append(root @ (wanted[j] - machine.c @ free))
    rows.append(np.sqrt(asked.control) * np.eye(count * p))
    right.append(np.zeros(count * p))
    found: np.ndarray = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    return found[:p]
