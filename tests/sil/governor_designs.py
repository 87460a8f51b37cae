"""Small extended command governors and their compiled packages, each made once."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from servogen.controllers.command_governor import CommandGovernor
from servogen.controllers.command_governor_declaration import AXES, declare_governor_parts
from servogen.controllers.command_governor_design import (
    AxisGovernorDesign,
    CommandGovernorDesign,
    GovernorSettings,
)
from servogen.controllers.command_governor_program import GovernorWeights
from servogen.controllers.design import Value
from servogen.emit.package import CPackage, emit_package
from servogen.precision import PRECISIONS
from servogen.sil.harness import Call

sys.path.insert(0, str(Path(__file__).parents[1] / "controllers"))

from governed_machine import machine


@dataclass(frozen=True)
class Shape:
    """What may differ between the governors under test."""

    prefix: str
    precision: str = "float64"
    horizon: int = 4
    points: int = 10
    cap: int = 60
    sub_step: bool = False
    margin: float = 0.0
    after: bool = True
    sub_samples: int = 3
    ahead: int | None = None
    reference: float = 0.01


SHAPES = {
    "float64": Shape("g64"),
    "float32": Shape("g32", "float32"),
    "at the cap": Shape("cap64", cap=1),
    "at the cap, float32": Shape("cap32", "float32", cap=1),
    "rows between the samples": Shape("sub", sub_step=True, margin=0.001, after=False),
    "one period": Shape("one", "float32", horizon=1, points=1, sub_samples=1),
    "blocks that are left over": Shape("left", horizon=6, points=3),
    "fewer points ahead": Shape("few", "float32", ahead=23),
}


@cache
def governor(shape: Shape) -> CommandGovernorDesign:
    """Of the machine of paper 4."""
    chosen = GovernorSettings(
        weights=GovernorWeights(reference=shape.reference),
        cap=shape.cap,
        sub_step_stroke=shape.sub_step,
        stroke_margin_m=shape.margin,
        after=shape.after,
        points_ahead=shape.ahead,
    )
    made: CommandGovernorDesign = machine(
        shape.horizon, chosen, shape.points, shape.sub_samples, PRECISIONS[shape.precision]
    )
    x, y = (replace(a, prefix=f"{shape.prefix}_{n}") for n, a in zip("xy", made.axes, strict=True))
    return replace(made, prefix=shape.prefix, axes=(x, y))


def axis(shape: Shape) -> AxisGovernorDesign:
    return governor(shape).axes[0]


def alike(design: CommandGovernorDesign) -> CommandGovernorDesign:
    """Both axes on the same tables, as where they are the same machine."""
    return replace(design, axes=(design.axes[0], design.axes[0]))


def standing_calls(design: CommandGovernorDesign, more: int = 10) -> list[Call]:
    """Stages at rest whose points are out of reach and whose reference is on another side in every
    period, until their patience ends and ``more``; then without points, then with some in reach."""
    own, where, stroke = CommandGovernor(design), 0.12, design.axes[0].program.stroke_m
    names = [port.name for port in own.declaration.operation("step").inputs]
    made = [Call("reset", {f"position_{a}": where for a in AXES})]
    own.call("reset", made[0].inputs)
    for k in range(design.axes[0].patience + more + 2):
        ended = max(0, k + 1 - design.axes[0].patience - more)
        side = 1.0 if k % 2 else -1.0
        inputs: dict[str, Value] = {"n_points": 0 if ended == 1 else design.window}
        for axis, name in zip(own.axes, AXES, strict=True):
            n = axis.design.plant.order
            mine = [port for port in names[: 2 * n] if port.startswith(f"{name}_")]
            inputs |= dict(zip(mine, axis.predicted.tolist(), strict=True))
            point = where if ended else where + 2.4 * stroke
            inputs[f"points_{name}"] = np.full(design.window, point)
            inputs[f"slow_{name}"] = np.full(design.window, where + side * stroke)
        made.append(Call("step", inputs))
        own.call("step", inputs)
    return made


def package(design: CommandGovernorDesign) -> CPackage:
    """Of both axes and what they share."""
    return emit_package(f"{design.prefix}p", declare_governor_parts(design))


def swap(old: str, new: str) -> Callable[[str], str]:
    """A mutant: the first ``old`` becomes ``new``."""

    def change(text: str) -> str:
        assert text.count(old) >= 1, old
        return text.replace(old, new, 1)

    return change
