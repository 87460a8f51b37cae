"""The tracking problem (7), (10)-(12) as a parametric program in absolute inputs.

The program's variables are the inputs U = (u(0|k), ..., u(H_u-1|k)) themselves rather than their
changes: bounds on inputs alone then make it a box. The output enters as references less the output,
so that the numbers stay small on an axis that turns on for ever: at 36,000 degrees a float32 has
steps of 0.004 degrees, and a first move of some 2e4 mA per degree of each reference would make
about 100 mA of their rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from servogen.controllers.errors import DesignError
from servogen.controllers.prediction import Extension, Horizons, extension, predict
from servogen.plants.sampled import Sampled
from servogen.plants.statespace import read_only
from servogen.precision import FloatArray
from servogen.qp.parametric import ParametricQP, parameter_box, parametric_qp


@dataclass(frozen=True)
class Bounds:
    """lower <= value <= upper, each (k,); infinite where there is none.

    Raises:
        DesignError: shapes that differ, a NaN, or a lower bound that is not below its upper one.
    """

    lower: FloatArray
    upper: FloatArray

    def __post_init__(self) -> None:
        for name in ("lower", "upper"):
            object.__setattr__(self, name, read_only(np.atleast_1d(getattr(self, name))))
        if self.lower.shape != self.upper.shape or self.lower.ndim != 1:
            raise DesignError("lower", f"of shape {self.lower.shape}", "as many as upper bounds")
        if not np.all(self.lower < self.upper):
            raise DesignError("lower", list(self.lower), f"below {list(self.upper)}")

    @staticmethod
    def symmetric(limit: npt.ArrayLike) -> Bounds:
        """|value| <= limit."""
        most = np.atleast_1d(np.asarray(limit, dtype=np.float64))
        return Bounds(-most, most)


@dataclass(frozen=True)
class SignalBounds:
    """Bounds (12) on signals ``rows`` x_p, (p, n), at samples 1..``steps`` or ``samples`` alone.

    With the plant's own c these are outputs; with rows of an identity, states.
    """

    rows: FloatArray
    bounds: Bounds
    steps: int
    samples: tuple[int, ...] = ()


@dataclass(frozen=True)
class Constraints:
    """(10) on the inputs, (11) on their changes from sample to sample, (12) on signals."""

    input: Bounds | None = None
    change: Bounds | None = None
    signal: SignalBounds | None = None


@dataclass(frozen=True)
class Weights:
    """Diagonals of Q(i), (H_p, m), i = 1..H_p, and R(i), (H_u, l), i = 0..H_u-1.

    Raises:
        DesignError: a Q(i) that is negative, or an R(i) that is not positive.
    """

    output: FloatArray
    change: FloatArray

    def __post_init__(self) -> None:
        for name in ("output", "change"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        if not np.all((self.output >= 0.0) & np.isfinite(self.output)):
            raise DesignError("output", "negative or not finite", "weights of zero or more")
        if not np.all((self.change > 0.0) & np.isfinite(self.change)):
            raise DesignError("change", "not positive and finite", "weights above zero")

    @staticmethod
    def constant(
        output: npt.ArrayLike, change: npt.ArrayLike, plant: Sampled, horizons: Horizons
    ) -> Weights:
        """The same at every step; a number or one per output and input."""
        q = np.broadcast_to(np.asarray(output, float), (horizons.prediction, plant.outputs))
        r = np.broadcast_to(np.asarray(change, float), (horizons.control, plant.inputs))
        return Weights(q, r)


@dataclass(frozen=True)
class Layout:
    """Where the parts of theta stand: dx_p (n), u(k-1) (l), r(1|k) - y .. r(H_t|k) - y (H_t m),
    and the signals of (12) at k (p), if there are any."""

    increment: slice
    previous: slice
    reference: slice
    signal: slice

    @property
    def size(self) -> int:
        """Length of theta."""
        return int(self.signal.stop)


@dataclass(frozen=True)
class TrackingQp:
    """The program, what its parameter is made of, and what it was made from.

    Bounds (10) on the inputs are bounds of its variables, (11) and (12) rows; those of (12) that no
    input reaches yet limit theta alone and are its domain.
    """

    qp: ParametricQP
    layout: Layout
    plant: Sampled
    horizons: Horizons
    constraints: Constraints


def tracking_qp(
    plant: Sampled,
    horizons: Horizons,
    extend: Extension,
    weights: Weights,
    constraints: Constraints,
    box: Bounds | None = None,
) -> TrackingQp:
    """(9) and (13) in absolute inputs and relative outputs.

    Args:
        box: bounds on theta, in the order of ``Layout``, all finite, or None for the whole space.

    Raises:
        DesignError: horizons, weights and bounds that do not fit the plant or each other.
        ProgramError: weights between which numbers are lost: a Hessian that is as good as singular.
    """
    _check_shapes(plant, horizons, weights, constraints)
    layout = _layout(plant, horizons, constraints)
    ahead = predict(plant, horizons.prediction, horizons.control)
    difference, start = change_of_inputs(plant.inputs, horizons.control)
    on_inputs = ahead.on_change @ difference
    q, r = weights.output.ravel(), weights.change.ravel()
    hessian = 2.0 * (difference.T * r) @ difference + 2.0 * (on_inputs.T * q) @ on_inputs
    linear = np.zeros((hessian.shape[0], layout.size))
    linear[:, layout.increment] = 2.0 * (on_inputs.T * q) @ ahead.on_increment
    linear[:, layout.previous] = -2.0 * (difference.T * r) @ start
    linear[:, layout.previous] -= 2.0 * (on_inputs.T * q) @ (ahead.on_change @ start)
    references = extension(horizons, extend, plant.outputs)
    linear[:, layout.reference] = -2.0 * (on_inputs.T * q) @ references
    g, w, s = _rows(plant, horizons, constraints, layout)
    if box is not None and box.lower.size != layout.size:
        raise DesignError("box", f"of {box.lower.size} bounds", f"{layout.size}, as theta has")
    limits = (None, None) if box is None else parameter_box(box.lower, box.upper)
    program = parametric_qp(
        0.5 * (hessian + hessian.T),
        linear,
        rows=g,
        bounds=w,
        bounds_parameter=s,
        domain_rows=limits[0],
        domain_bounds=limits[1],
        first_move=plant.inputs,
    )
    return TrackingQp(program, layout, plant, horizons, constraints)


def change_of_inputs(inputs: int, control: int) -> tuple[FloatArray, FloatArray]:
    """Changes of the inputs are ``difference`` U - ``start`` u(k-1): (H_u l, H_u l), (H_u l, l)."""
    steps = np.eye(control) - np.eye(control, k=-1)
    first = np.eye(control)[:, :1]
    return np.kron(steps, np.eye(inputs)), np.kron(first, np.eye(inputs))


def _layout(plant: Sampled, horizons: Horizons, constraints: Constraints) -> Layout:
    signals = 0 if constraints.signal is None else constraints.signal.rows.shape[0]
    sizes = (plant.order, plant.inputs, horizons.trajectory * plant.outputs, signals)
    ends = np.cumsum(sizes).tolist()
    parts = [slice(end - size, end) for size, end in zip(sizes, ends, strict=True)]
    return Layout(*parts)


def _rows(
    plant: Sampled, horizons: Horizons, constraints: Constraints, layout: Layout
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """G, w, S of (13): rows of (10), of (11), of (12); infinite bounds leave none."""
    control, size = horizons.control, horizons.control * plant.inputs
    difference, start = change_of_inputs(plant.inputs, control)
    parts = []
    if constraints.input is not None:
        no_theta = np.zeros((size, layout.size))
        parts.append(_pairs(np.eye(size), no_theta, _repeated(constraints.input, control)))
    if constraints.change is not None:
        on_theta = np.zeros((size, layout.size))
        on_theta[:, layout.previous] = -start
        parts.append(_pairs(difference, on_theta, _repeated(constraints.change, control)))
    if constraints.signal is not None:
        signal = constraints.signal
        seen = Sampled(plant.a, plant.b, read_only(signal.rows), plant.sample_time_s)
        ahead = predict(seen, signal.steps, control)
        on_theta = np.zeros((ahead.on_change.shape[0], layout.size))
        on_theta[:, layout.increment] = ahead.on_increment
        on_theta[:, layout.previous] = -ahead.on_change @ start
        on_theta[:, layout.signal] = np.kron(np.ones((signal.steps, 1)), np.eye(seen.outputs))
        taken = signal.samples or range(1, signal.steps + 1)
        kept = np.add.outer((np.array(taken) - 1) * seen.outputs, np.arange(seen.outputs)).ravel()
        on_inputs = (ahead.on_change @ difference)[kept]
        parts.append(_pairs(on_inputs, on_theta[kept], _repeated(signal.bounds, len(taken))))
    if not parts:
        return np.zeros((0, size)), np.zeros(0), np.zeros((0, layout.size))
    g, w, s = (np.concatenate(part) for part in zip(*parts, strict=True))
    return g, w, s


def _repeated(bounds: Bounds, times: int) -> Bounds:
    return Bounds(np.tile(bounds.lower, times), np.tile(bounds.upper, times))


def _pairs(
    on_inputs: FloatArray, on_theta: FloatArray, bounds: Bounds
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """lower <= on_inputs U + on_theta theta <= upper as rows, upper bounds first."""
    above, below = np.isfinite(bounds.upper), np.isfinite(bounds.lower)
    return (
        np.vstack([on_inputs[above], -on_inputs[below]]),
        np.concatenate([bounds.upper[above], -bounds.lower[below]]),
        np.vstack([-on_theta[above], on_theta[below]]),
    )


def _check_shapes(
    plant: Sampled, horizons: Horizons, weights: Weights, constraints: Constraints
) -> None:
    expected = {
        "output": (horizons.prediction, plant.outputs),
        "change": (horizons.control, plant.inputs),
    }
    for key, shape in expected.items():
        found = getattr(weights, key).shape
        if found != shape:
            raise DesignError(key, f"of shape {found}", f"weights of shape {shape}")
    for key in ("input", "change"):
        bounds = getattr(constraints, key)
        if bounds is not None and bounds.lower.size != plant.inputs:
            raise DesignError(key, f"{bounds.lower.size} bounds", f"{plant.inputs}, one per input")
    signal = constraints.signal
    if signal is None:
        return
    if signal.rows.ndim != 2 or signal.rows.shape != (signal.bounds.lower.size, plant.order):
        shape = (signal.bounds.lower.size, plant.order)
        raise DesignError("signal", f"rows of shape {signal.rows.shape}", f"shape {shape}")
    if not 1 <= signal.steps <= horizons.prediction:
        raise DesignError("steps", signal.steps, f"from 1 to {horizons.prediction}")
    if any(not 1 <= sample <= signal.steps for sample in signal.samples):
        raise DesignError("samples", list(signal.samples), f"each from 1 to {signal.steps}")
