"""What the contour controller declares: names, sizes, tables, ports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servogen.controllers.contour_lq_design import HIDDEN_BOUND, ContourAxis, ContourLqDesign
from servogen.controllers.contour_slide_bounds import slide_bounds
from servogen.controllers.design import (
    Constant,
    Declaration,
    Dimension,
    Map,
    Operation,
    Port,
    StateField,
    Table,
)

# Of a direction: its largest component is one, but for rounding.
LEAST_SQUARE = Constant("least_square", 0.5, "no direction's square is below, nor that of two")


def contour_inputs(design: ContourLqDesign) -> tuple[Port, tuple[Port, ...], Port]:
    """position, hidden (none where every axis is an integrator alone), reference."""
    reach, axes = design.reach, len(design.axes)
    hidden = (
        Port(
            "hidden",
            "1",
            "other states of every axis, axis after axis, in shares of their largest",
            size=design.hidden,
            low=-HIDDEN_BOUND,
            high=HIDDEN_BOUND,
        ),
    )
    position = Port("position", "m", "of every axis, now", size=axes, low=-reach, high=reach)
    reference = Port(
        "reference",
        "m",
        "the present point and the N_p ahead of it, the axes of one together",
        size=axes * (design.preview + 1),
        low=-reach,
        high=reach,
    )
    return position, hidden if design.hidden else (), reference


def contour_outputs(design: ContourLqDesign) -> tuple[Port, ...]:
    """command, limited, known."""
    axes = len(design.axes)
    most = max(axis.model.input_limit for axis in design.axes)
    return (
        Port(
            "command",
            "1",
            "of every axis, in the unit of its input; zero where an input cannot be used",
            size=axes,
            low=-most,
            high=most,
        ),
        Port("limited", "1", "axes whose command was cut", integer=True, low=0, high=axes),
        Port(
            "known",
            "1",
            "points ahead with a direction; without one every error counts as one of contour",
            integer=True,
            low=0,
            high=design.preview,
        ),
    )


def _law_tables(name: str, axis: ContourAxis, slides: bool) -> tuple[Table, ...]:
    tables = axis.tables
    first = Table(f"first_{name}", tables.first, "(d_1..d_N, y, xi) to the first input")
    if not slides:
        return (first,)
    return (
        first,
        Table(f"error_{name}", tables.error.T, "the same to errors left, transposed"),
        Table(f"slide_{name}", tables.slide, "first input per slide"),
        Table(f"stiffness_{name}", tables.stiffness, "errors left per slide"),
    )


def _axis_tables(name: str, axis: ContourAxis, slides: bool) -> tuple[Table, ...]:
    model, observer = axis.model, axis.observer
    hidden = model.a[1:, 1:]
    seen: tuple[Table, ...] = ()
    if model.hidden:
        seen = (
            Table(f"on_hidden_{name}", hidden.T, "A, hidden to hidden, transposed"),
            Table(f"hidden_moves_{name}", model.a[0, 1:], "position by the hidden states"),
            Table(f"hidden_drift_{name}", model.drift[1:], "hidden states by the position"),
            Table(f"hidden_drive_{name}", model.b[1:], "hidden states by the input"),
            Table(f"hidden_gain_{name}", observer.on_hidden, "Kalman gain of them"),
        )
    return (*_law_tables(name, axis, slides), *seen)


def _axis_constants(name: str, axis: ContourAxis) -> tuple[Constant, ...]:
    model = axis.model
    return (
        Constant(f"limit_{name}", model.input_limit, "largest command"),
        Constant(f"drift_{name}", float(model.drift[0]), "position by the position, less one"),
        Constant(f"drive_{name}", float(model.b[0]), "position by the input"),
        Constant(f"gain_{name}", axis.observer.on_position, "Kalman gain of it, less one"),
    )


def _slides(design: ContourLqDesign) -> bool:
    return design.count > 0 and design.table is None


def _form_dimensions(design: ContourLqDesign) -> tuple[Dimension, ...]:
    if design.table is not None:
        return (
            Dimension("ANGLES", design.table.entries, "directions over half a turn"),
            Dimension("AT", design.table.at, "point ahead whose direction counts"),
        )
    if design.count:
        return (Dimension("SLIDES", design.count, "S, points whose reference may slide"),)
    return ()


def _form_constants(design: ContourLqDesign) -> tuple[Constant, ...]:
    if design.table is not None:
        entries = float(design.table.entries)
        return (
            Constant("angles", entries, "as above"),
            Constant("half_angles", 0.5 * entries, "of them in a quarter turn"),
            LEAST_SQUARE,
        )
    if design.count:
        bounds = slide_bounds(design)
        return (
            LEAST_SQUARE,
            Constant("share", design.share, "beta / (alpha + beta)"),
            Constant("least_price", design.least_price, "alpha / (alpha + beta), below any pivot"),
            Constant("stiffest", bounds.stiffest, "nothing left of the slides' matrix is beyond"),
            Constant("farthest", bounds.farthest, "m: no slide is, nor what becomes one"),
        )
    return ()


@dataclass(frozen=True)
class AxisPlace:
    """Where an axis is in what holds all of them: number, first of its hidden states and how many,
    first of (d, y, xi) and how many."""

    name: str
    number: int
    first_hidden: int
    hidden: int
    first_given: int
    given: int


def axis_places(design: ContourLqDesign) -> tuple[AxisPlace, ...]:
    """Of all axes, in their order."""
    places, hidden, given = [], 0, 0
    for number, (name, axis) in enumerate(zip(design.names, design.axes, strict=True)):
        own = design.preview + axis.model.order
        places.append(AxisPlace(name, number, hidden, axis.model.hidden, given, own))
        hidden, given = hidden + axis.model.hidden, given + own
    return tuple(places)


def _given_dimensions(places: tuple[AxisPlace, ...]) -> tuple[Dimension, ...]:
    each = (Dimension(f"GIVEN_{a.name.upper()}", a.given, f"of {a.name}") for a in places)
    total = sum(a.given for a in places)
    return (Dimension("GIVEN", total, "references, position, hidden states of all axes"), *each)


def _angle_tables(design: ContourLqDesign) -> tuple[Table, ...]:
    """A direction after the other, in it an input after the other, in it the axes."""
    if design.table is None:
        return ()
    gains = np.swapaxes(design.table.gains, 1, 2)
    flat = gains.reshape(-1, len(design.axes))
    return (Table("gains", flat, "(d, y, xi) of all axes to commands, per direction"),)


def declare_contour_lq(design: ContourLqDesign) -> Declaration:
    """Names, sizes, tables and ports; tables of the axis ``a`` end in ``_a``."""
    named = list(zip(design.names, design.axes, strict=True))
    position, hidden, reference = contour_inputs(design)
    outputs = contour_outputs(design)
    slides, places = _slides(design), axis_places(design)
    return Declaration(
        kind="contour_lq",
        prefix=design.prefix,
        summary="Receding-horizon LQ contour control (11)-(13), gains computed on line",
        precision=design.precision,
        sample_time_s=design.sample_time_s,
        dimensions=(
            Dimension("AXES", len(named), "p"),
            Dimension("PREVIEW", design.preview, "N_p, points ahead"),
            *_form_dimensions(design),
            Dimension("HIDDEN", design.hidden, "states but the positions, all axes"),
            *(Dimension(f"HIDDEN_{n.upper()}", a.model.hidden, f"of {n}") for n, a in named),
            *_given_dimensions(places),
        ),
        constants=(
            Constant("apart", design.apart, "m: points nearer than this make no direction"),
            *_form_constants(design),
            *(Constant("hidden_bound", HIDDEN_BOUND, "largest hidden state") for _ in hidden),
            Constant("twice_reach", 2.0 * design.reach, "two positions are not farther apart"),
            *(constant for n, a in named for constant in _axis_constants(n, a)),
        ),
        tables=(
            *(table for n, a in named for table in _axis_tables(n, a, slides)),
            *_angle_tables(design),
        ),
        state=(
            StateField("last", "last usable measurement", "AXES"),
            StateField("ahead", "position expected at the next sample, less that", "AXES"),
            *(StateField("hidden", "hidden states expected at it", "HIDDEN") for _ in hidden),
            StateField("point", "last distinct point of the contour", "AXES"),
            StateField("direction", "by which it was reached, or zeros", "AXES"),
            StateField("begun", "whether a reference has been taken", type="int32_t"),
            StateField("ready", "whether reset has been called", type="int32_t"),
        ),
        operations=(
            Operation("reset", "The axes stand at a position.", (position,)),
            Operation(
                "step",
                "One sample by the encoders: estimate, tangents, slides, command; then predict.",
                (position, reference),
                outputs,
                period_s=design.sample_time_s,
            ),
            Operation(
                "follow",
                "One sample with the whole state given, in place of step.",
                (position, *hidden, reference),
                outputs,
            ),
        ),
        facts={
            "form": "angles" if design.table else "slides" if design.count else "known",
            "mirrors": (design.table.at if design.table else design.count) == design.preview,
            "hidden": bool(hidden),
            "axes": places,
        },
        maps=tuple(_hidden_map(name, axis) for name, axis in named if axis.model.hidden),
    )


def _hidden_map(name: str, axis: ContourAxis) -> Map:
    """For ``follow``, whose caller knows the state of his own model."""
    states = axis.model.from_state[1:]
    return Map(f"hidden_{name}", states, f"of {name}: hidden states of the model's x, as it is")
