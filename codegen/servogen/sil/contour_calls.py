"""Random calls of the contour controller: around its machine, on contours of every kind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servogen.controllers.contour_lq import ContourLq
from servogen.controllers.contour_lq_design import HIDDEN_BOUND, ContourLqDesign
from servogen.controllers.design import Value
from servogen.precision import FloatArray
from servogen.sil.harness import Call

# Samples between one reset and the next, and the share of inputs that are no use.
_STRETCH, _BAD = 40, 0.06
# Of the stretches, those in which the whole state is given; of the samples, those whose preview is
# that of somewhere else, and those at which the axis is.
_WHOLE, _JUMP = 0.4, 0.05


def contour_calls(
    design: ContourLqDesign, rng: np.random.Generator, count: int, bad: float = _BAD
) -> Iterator[Call]:
    """``count`` samples around the controller's own model, with jumps of encoders and of previews,
    and values of no use (``bad``: their share)."""
    own = ContourLq(design)
    models = [axis.model for axis in design.axes]
    states: list[FloatArray] = [np.zeros(m.order) for m in models]
    points: FloatArray = np.zeros((0, len(models)))
    whole = False
    for index in range(count):
        k = index % _STRETCH
        if k == 0:
            points = contour(design, rng, _STRETCH + design.preview + 1)
            states = [np.zeros(m.order) for m in models]
            for state, where in zip(states, points[0], strict=True):
                state[0] = where
            whole = bool(rng.random() < _WHOLE)
            yield _made(own, Call("reset", {"position": points[0]}))
        ahead = points[k : k + design.preview + 1]
        if rng.random() < _JUMP:
            ahead = contour(design, rng, len(ahead))
        position = np.array([state[0] for state in states])
        position = np.clip(position, -design.reach, design.reach)
        inputs: dict[str, Value] = {"position": position, "reference": ahead.ravel()}
        if whole and design.hidden:
            hidden = np.concatenate([state[1:] for state in states])
            inputs["hidden"] = np.clip(hidden, -HIDDEN_BOUND, HIDDEN_BOUND)
        if rng.random() < bad:
            _spoil(design, inputs, rng)
        call = Call("follow" if whole else "step", inputs)
        yield call
        _, out = own.call(call.operation, inputs)
        command = np.asarray(out["command"], dtype=np.float64)
        states = [m.a @ x + m.b * u for m, x, u in zip(models, states, command, strict=True)]


def arriving_calls(design: ContourLqDesign) -> Iterator[Call]:
    """A machine that stands: a motion comes into the preview point by point, and its end too; in a
    direction between the axes, and to both sides along each."""
    axes, ahead = len(design.axes), design.preview + 1
    ways = 4.0 * design.apart * np.vstack([np.arange(1.0, axes + 1.0), np.eye(axes), -np.eye(axes)])
    steps = np.concatenate([np.zeros(ahead + 2), np.ones(3), np.zeros(ahead + 2)])
    for way in ways:
        points = np.outer(np.cumsum(steps), way)
        yield Call("reset", {"position": np.zeros(axes)})
        for k in range(len(steps) - ahead):
            reference = points[k : k + ahead].ravel()
            yield Call("step", {"position": points[k], "reference": reference})


def contour(design: ContourLqDesign, rng: np.random.Generator, count: int) -> FloatArray:
    """(count, p) points somewhere in reach: curves, lines and polygons, at speeds from a creep to
    more than the axes have, with stops, repeated points and ways back."""
    axes = len(design.axes)
    fastest = min(float(np.max(np.abs(a.model.b[0] * a.model.input_limit))) for a in design.axes)
    fastest = max(fastest, design.apart)
    step = fastest * 10.0 ** rng.uniform(-4.0, 0.5)
    step = float(rng.choice([step, fastest * rng.uniform(0.1, 1.0), 2.0 * design.apart]))
    shapes = (_curve, _polygon, _line, _still)
    way = shapes[int(rng.choice(len(shapes), p=[0.4, 0.35, 0.2, 0.05]))](rng, count, axes) * step
    if rng.random() < 0.3:  # a stop
        first = int(rng.choice([0, int(rng.integers(count))]))
        way[first : first + int(rng.integers(1, 15))] = 0.0
    if rng.random() < 0.3:  # repeated points
        way[rng.random(count) < rng.uniform(0.1, 0.9)] = 0.0
    if rng.random() < 0.2:  # back by which it came
        first = int(rng.integers(count))
        back = way[first:]
        way[first : first + first] = -way[max(0, first - len(back)) : first][::-1]
    share = float(rng.choice([0.0, 0.3, 0.97]))
    start = rng.uniform(-share, share, axes) * design.reach
    points = start + np.cumsum(way, axis=0) - way[0]
    result: FloatArray = np.clip(points, -design.reach, design.reach)
    return result


def _curve(rng: np.random.Generator, count: int, axes: int) -> FloatArray:
    """Directions that turn, at most by two thirds of a right angle in a sample."""
    turn = float(rng.choice([-1.0, 1.0])) * 10.0 ** rng.uniform(-3.0, 0.0)
    angle = rng.uniform(0.0, 2.0 * np.pi) + turn * np.arange(count)
    rise = float(rng.uniform(-1.0, 1.0))
    way: FloatArray = np.full((count, axes), rise)
    way[:, 0], way[:, 1] = np.cos(angle), np.sin(angle)
    return way


def _polygon(rng: np.random.Generator, count: int, axes: int) -> FloatArray:
    """Sides of a few samples each; corners of any angle, right ones, and ways back."""
    sides = np.arange(count) // int(rng.integers(2, 15))
    kind = int(rng.integers(3))
    ways = rng.normal(size=(count, axes))
    if kind == 1:  # along the axes
        ways = np.sign(rng.normal(size=(count, axes)))
        ways[np.arange(count), rng.integers(axes, size=count)] = 0.0
    if kind == 2:  # to and fro
        ways = ways[0] * (-1.0) ** np.arange(count)[:, None]
    result: FloatArray = ways[sides]
    return result


def _line(rng: np.random.Generator, count: int, axes: int) -> FloatArray:
    way = rng.normal(size=axes)
    if rng.random() < 0.5:  # along an axis
        way[int(rng.integers(1, axes))] = 0.0
    result: FloatArray = np.ones((count, 1)) * way
    return result


def _still(_: np.random.Generator, count: int, axes: int) -> FloatArray:
    return np.zeros((count, axes))


def _spoil(design: ContourLqDesign, inputs: dict[str, Value], rng: np.random.Generator) -> None:
    """One value is no use, far away, or at the end of its range."""
    name = list(inputs)[int(rng.integers(len(inputs)))]
    bound = HIDDEN_BOUND if name == "hidden" else design.reach
    values = np.array(inputs[name], dtype=np.float64)
    values[int(rng.integers(values.size))] = float(
        rng.choice([np.nan, np.inf, -np.inf, 1.001 * bound, bound, -bound])
    )
    inputs[name] = values


def _made(own: ContourLq, call: Call) -> Call:
    own.call(call.operation, call.inputs)
    return call
