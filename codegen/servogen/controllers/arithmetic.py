"""Scalar helpers of the reference steps; each has its twin in ``c_runtime/sg_kernels.h``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from servogen.controllers.design import Port, Status, Value
from servogen.precision import FloatArray, Precision

Scalar = Any  # float for float64, numpy.float32 for float32


def scalar_type(precision: Precision) -> Callable[[Any], Scalar]:
    """Constructor of a scalar that computes like the C type."""
    return np.float32 if precision.is_float32 else float


def cast(values: object, precision: Precision) -> FloatArray:
    """A contiguous read-only array in the target precision."""
    array = np.ascontiguousarray(values, dtype=precision.dtype)
    array.flags.writeable = False
    return array


def check_port(port: Port, value: Value, precision: Precision) -> Status:
    """NOT_FINITE, OUT_OF_RANGE or OK for one input, as ``sg_check`` does.

    Finiteness is tested against the largest finite number, which a NaN fails too.
    """
    if port.low is None or port.high is None:
        return Status.OK
    array = np.atleast_1d(np.asarray(value))
    if port.integer:
        inside = np.all((array >= port.low) & (array <= port.high))
        return Status.OK if inside else Status.OUT_OF_RANGE
    array = array.astype(precision.dtype)
    limit = precision.dtype.type(precision.max)
    if not np.all((array >= -limit) & (array <= limit)):
        return Status.NOT_FINITE
    low, high = precision.dtype.type(port.low), precision.dtype.type(port.high)
    if not np.all((array >= low) & (array <= high)):
        return Status.OUT_OF_RANGE
    return Status.OK
