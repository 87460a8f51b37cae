"""What makes the counter of a loop one whose values are known for certain."""

from __future__ import annotations

from pycparser import c_ast

from servogen.wcet.constants import Value, fits
from servogen.wcet.ctype import Scalar, arithmetic
from servogen.wcet.frame import Frame
from servogen.wcet.loops import Header
from servogen.wcet.refusal import refuse


def check_counter(frame: Frame, node: c_ast.For, header: Header) -> None:
    """An integer of this function that nobody else can change.

    Raises:
        CountRefused: anything else.
    """
    name, kind = header.counter, frame.typed.type_of(header.use)
    static = any(d.name == name and "static" in d.storage for d, _ in frame.typed.locals)
    if static or not frame.typed.is_local(name):
        raise refuse(node, f"the counter '{name}' is not a variable of this function")
    if not isinstance(kind, Scalar) or kind.kind != "int":
        raise refuse(node, f"the counter '{name}' is no integer")
    if name in frame.typed.in_memory:
        raise refuse(node, f"the counter '{name}' is volatile or its address is taken")
    if not kind.signed and header.op == ">=":
        raise refuse(node, f"the unsigned counter '{name}' may pass below zero")


def check_values(
    frame: Frame, node: c_ast.For, header: Header, values: range, bound: Value
) -> None:
    """The counter's type holds every value up to the one that ends the loop, and the comparison
    means what it says: one that wraps around, or becomes unsigned there, may never end.

    Raises:
        CountRefused: it does not.
    """
    kind = frame.typed.type_of(header.use)
    reached = (values.start, values[-1] + values.step if values else values.start)
    for number in reached:
        if not fits(number, kind):
            raise refuse(node, f"the counter '{header.counter}' does not hold {number}")
    compared = arithmetic(kind, frame.typed.type_of(header.bound))
    for known in (*reached, bound.number):
        if not fits(known, compared):
            raise refuse(
                node,
                f"the counter '{header.counter}' is compared as unsigned, which {known} is not",
            )
