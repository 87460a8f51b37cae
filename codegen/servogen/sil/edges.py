"""Calls at the edges of what a controller declares, one input at a time.

Everything is read from the declaration: a new controller has its edges tried without a line here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from servogen.controllers.design import Declaration, Port, Value
from servogen.sil.harness import Call

INT32 = np.iinfo(np.int32)


def edge_calls(declaration: Declaration) -> Iterator[Call]:
    """Every operation before reset, then every edge of every input, each followed by a call with
    inputs in range (does it recover?), then a second reset."""
    for op in declaration.operations:
        if op.name != "reset":
            yield Call(op.name, resting_inputs(declaration, op.name))
    for op in declaration.operations:
        for port in op.inputs:
            yield from _resets(declaration)
            for value in edge_values(port, declaration):
                yield from _around(declaration, op.name, port, value)
    yield from _resets(declaration)
    yield from _resets(declaration)
    for op in declaration.operations:
        yield Call(op.name, resting_inputs(declaration, op.name))


def _resets(declaration: Declaration) -> Iterator[Call]:
    if any(op.name == "reset" for op in declaration.operations):
        yield Call("reset", resting_inputs(declaration, "reset"))


def _around(d: Declaration, operation: str, port: Port, value: Value) -> Iterator[Call]:
    rest = resting_inputs(d, operation)
    yield Call(operation, {**rest, port.name: value})
    if operation == "reset":
        for op in d.operations:
            if op.name != "reset":
                yield Call(op.name, resting_inputs(d, op.name))
    yield Call(operation, rest)
    for op in d.operations:  # what a bad input left behind shows in the other operations
        if not op.inputs:
            yield Call(op.name)


def resting_inputs(declaration: Declaration, operation: str) -> dict[str, Value]:
    """All zero: the machine stands at the middle, and the path stays there."""
    inputs: dict[str, Value] = {}
    for port in declaration.operation(operation).inputs:
        if port.size:
            inputs[port.name] = np.zeros(port.size)
        else:
            inputs[port.name] = int(port.high or 0) if port.integer else 0.0
    return inputs


def edge_values(port: Port, declaration: Declaration) -> Iterator[Value]:
    """Values of one port: not finite, huge, tiny, on its bounds and just beyond them.

    An array gets each at its first and at its last element.
    """
    if port.integer:
        low, high = int(port.low or 0), int(port.high or 0)
        yield from (low - 1, low, low + 1, high - 1, high, high + 1, INT32.min, INT32.max)
        return
    for value in _reals(port, declaration):
        if not port.size:
            yield value
            continue
        for index in sorted({0, port.size - 1}):
            array = np.zeros(port.size)
            array[index] = value
            yield array


def _reals(port: Port, declaration: Declaration) -> list[float]:
    dtype = declaration.precision.dtype.type
    largest = float(declaration.precision.max)
    tiny = float(np.finfo(dtype).smallest_subnormal)
    values = [float("nan"), float("inf"), float("-inf"), largest, -largest, tiny, -tiny, -0.0]
    for bound in (port.low, port.high):
        if bound is not None:
            here = dtype(bound)
            values += [float(here), float(np.nextafter(here, dtype(np.copysign(np.inf, here))))]
    return values


def random_inputs(
    declaration: Declaration, operation: str, rng: np.random.Generator, share: float = 1.0
) -> Mapping[str, Value]:
    """Uniform in ``share`` of every declared range; ports without one get numbers of order one."""
    inputs: dict[str, Value] = {}
    for port in declaration.operation(operation).inputs:
        low = -1.0 if port.low is None else port.low
        high = 1.0 if port.high is None else port.high
        if port.integer:
            inputs[port.name] = int(rng.integers(int(low), int(high) + 1))
        elif port.size:
            inputs[port.name] = share * rng.uniform(low, high, port.size)
        else:
            inputs[port.name] = float(share * rng.uniform(low, high))
    return inputs
