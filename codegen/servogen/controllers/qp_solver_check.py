"""What a quadratic program must be before it becomes C: every fault is one sentence."""

from __future__ import annotations

import numpy as np

from servogen.identifiers import MAX_LENGTH, is_free_prefix
from servogen.precision import FloatArray, Precision
from servogen.qp.arguments import matrix, whole
from servogen.qp.errors import ProgramError
from servogen.qp.row_tables import StageRows
from servogen.qp.tolerances import CONVEXITY, LARGE, SYMMETRY

# No input is beyond it: what is made of them stays below LARGE, and squares are numbers. For a
# bound that is not there a thousandth is far enough, and is seen to be in range without a look at
# every input.
LARGEST = {"float64": 1e90, "float32": 1e9}
# Of the largest number that there is: sums of numbers below it are numbers.
ROOM = 1e-3
MOST_ITERATIONS = 100_000
NEARER = "variables scaled nearer to one"


def check_options(prefix: object, precision: object, cap: object, accept: object) -> float:
    """The name in C, the iterations and the violation accepted, which is returned.

    Raises:
        ProgramError: one of them cannot be used.
    """
    if not (isinstance(prefix, str) and is_free_prefix(prefix)):
        expected = f"a C identifier of at most {MAX_LENGTH} characters that is free in C"
        raise ProgramError("prefix", repr(prefix), expected)
    if not isinstance(precision, Precision):
        expected = "one of servogen.precision: FLOAT32, FLOAT64"
        raise ProgramError("precision", repr(precision), expected)
    whole("cap", cap, 1, MOST_ITERATIONS)
    number = isinstance(accept, int | float | np.integer | np.floating)
    if not number or isinstance(accept, bool) or not 0.0 < float(accept) < np.inf:  # type: ignore[arg-type]
        raise ProgramError("accept", accept, "a finite number above zero")
    return float(accept)  # type: ignore[arg-type]


def check_accept(accept: float, scale: FloatArray, precision: Precision) -> None:
    """The violation accepted, against bounds of size one: ``scale`` (m,) is what the tables have
    of such a bound.

    Raises:
        ProgramError: the precision cannot tell it from nothing, or it is larger than the bounds.
    """
    least = float(np.finfo(precision.dtype).eps * np.min(scale))
    most = float(np.max(scale))
    if not least <= accept <= most:
        told = f"from {least:.1e} to {most:.1e}: from what {precision.name} leaves of a bound of"
        raise ProgramError("accept", f"{accept:g}", f"{told} size one to the bound itself")


def metric(hessian: object, precision: Precision) -> tuple[FloatArray, FloatArray]:
    """H (N, N) as it was given, and H^-1.

    Raises:
        ProgramError: H is not square, finite, symmetric and definite enough for the precision, or
            H^-1 has numbers that the precision does not.
    """
    h = matrix("hessian", hessian)
    if h.shape[0] != h.shape[1]:
        raise ProgramError("hessian", f"of shape {h.shape}", "a square matrix")
    diagonal = np.diag(h)
    if not np.all(diagonal > 0.0):
        raise ProgramError("hessian", None, "a positive definite matrix: a positive diagonal")
    with np.errstate(all="ignore"):  # what is no number is refused below
        unit = 1.0 / np.sqrt(diagonal)
        scaled = h * unit[:, None] * unit
        if not np.all(np.abs(scaled) <= 2.0):  # beyond one, H is not definite
            raise ProgramError("hessian", None, "a positive definite matrix")
        if not np.all(np.abs(scaled - scaled.T) <= SYMMETRY):
            raise ProgramError("hessian", "not symmetric", "a symmetric matrix")
        values, least = np.linalg.eigvalsh(scaled), CONVEXITY[precision.name]
        if not values[0] > least * values[-1]:
            share = f"of smallest eigenvalue {values[0] / values[-1]:.1e} of the largest"
            expected = f"a positive definite matrix, above {least:g} in {precision.name}"
            raise ProgramError("hessian", f"with a unit diagonal {share}", expected)
        inverse: FloatArray = np.linalg.inv(scaled) * unit[:, None] * unit
        reach = np.max(np.sum(np.abs(inverse), axis=1)) * LARGEST[precision.name]
    if not reach < ROOM * precision.max:
        said = f"so small that f of {LARGEST[precision.name]:g} leads beyond {precision.name}"
        raise ProgramError("hessian", said, NEARER)
    real = np.finfo(precision.dtype)
    if not np.min(np.diag(inverse)) > real.tiny / real.eps:
        raise ProgramError(
            "hessian", f"so large that its inverse is none in {precision.name}", NEARER
        )
    return h, inverse


def check_reach(rows: FloatArray, inverse: FloatArray, precision: Precision) -> None:
    """The rows (m, N) as they are written, at the points that the inputs can lead to.

    Raises:
        ProgramError: some value is none in the precision.
    """
    far, top = LARGEST[precision.name], ROOM * precision.max
    with np.errstate(all="ignore"):
        size = np.abs(rows)
        reach = np.max(size @ (np.sum(np.abs(inverse), axis=1) * far))
        # of two rows, with a multiplier at its bound, summed over a set
        pull = np.max(np.sum((size @ np.abs(inverse)) * size, axis=1)) * LARGE[precision.name]
    if not max(reach, pull * len(inverse)) < top:
        said = f"such that rows at the optimum for f of {far:g} lead beyond {precision.name}"
        raise ProgramError("hessian", said, NEARER)


def check_scale(norm: FloatArray, precision: Precision) -> None:
    """The rows' lengths (m,) in the metric of H, by which the bounds are divided.

    Raises:
        ProgramError: a row is zero, or a bound by its length is no number in the precision.
    """
    real, far = np.finfo(precision.dtype), LARGEST[precision.name]
    with np.errstate(all="ignore"):
        scale = 1.0 / norm
        fits = (scale * far < ROOM * precision.max) & (scale > real.tiny / real.eps)
    if not np.all(fits):
        i = int(np.flatnonzero(~fits)[0])
        said = f"of length {norm[i]:.1e}, sqrt(a'H^-1 a)"
        raise ProgramError(f"rows[{i}]", said, "rows and variables scaled nearer to one")


def check_layout(
    shape: tuple[int, int], per_step: int, staying: int, bounds: int, inputs: int
) -> None:
    """What is said of rows (m, N): which are bounds, and which row becomes which.

    Raises:
        ProgramError: it is out of range, or not of one horizon.
    """
    m, n = shape
    whole("bounds", bounds, 0, min(m, n))
    whole("staying", staying, 0, m - bounds)
    whole("per_step", per_step, 0, m - bounds - staying)
    whole("inputs", inputs, 0, n)
    moving = m - bounds - staying
    if per_step and moving % per_step:
        raise ProgramError("per_step", per_step, f"a divisor of the {moving} rows that move")
    if inputs and n % inputs:
        raise ProgramError("inputs", inputs, f"a divisor of the {n} variables")
    if inputs and per_step and moving // per_step != n // inputs:
        said = f"{per_step}: {moving // per_step} steps"
        raise ProgramError("per_step", said, f"the {n // inputs} steps of the inputs")


def check_plant(rows: object, variables: int, precision: Precision) -> None:
    """Rows made by ``stage_rows``, of so many variables.

    Raises:
        ProgramError: they are of another program, or of another precision.
    """
    if not isinstance(rows, StageRows):
        raise ProgramError("rows", f"of type {type(rows).__name__}", "rows made by stage_rows")
    if rows.variables != variables:
        raise ProgramError("rows", f"of {rows.variables} variables", f"{variables}, as H")
    if rows.stage.dtype != precision.dtype:
        raise ProgramError("rows", f"in {rows.stage.dtype}", f"{precision.name}, as the program")
