"""Loops up to a named bound whose turns can be seen while the C runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pycparser import c_ast

from servogen.wcet.constants import named_bound
from servogen.wcet.loops import read_header
from servogen.wcet.refusal import CountRefused
from servogen.wcet.unit import Unit


@dataclass(frozen=True)
class Turn:
    """``for (counter = start; counter < bound; counter++)`` with a named bound."""

    counter: str
    start: c_ast.Node
    bound: str


def turn_of(node: c_ast.For) -> Turn | None:
    """The loop as such a one; None for any other."""
    try:
        header = read_header(node)
    except CountRefused:
        return None
    upwards = header.op == "<" and header.step is None and header.sign > 0
    named = isinstance(header.bound, c_ast.ID) and named_bound(header.bound.name)
    return Turn(header.counter, header.start, header.bound.name) if upwards and named else None


def watched_bounds(units: Sequence[Unit]) -> tuple[str, ...]:
    """Named bounds that are met by such loops only, in alphabetical order.

    One that is handed on (an argument, a variable) may bound loops that do not name it: how many
    turns these do is not known, and the bound is left out.
    """
    met: set[str] = set()
    handed_on: set[str] = set()
    for unit in units:
        for function in unit.functions.values():
            for node in _nodes(function.body):
                turn = turn_of(node) if isinstance(node, c_ast.For) else None
                if turn is not None:
                    met.add(turn.bound)
                elif isinstance(node, c_ast.For) and isinstance(node.cond, c_ast.BinaryOp):
                    handed_on |= _names(node.cond.right) | _names(node.cond.left)
                handed_on |= _handed_on(node)
    return tuple(sorted(met - handed_on))


def _handed_on(node: c_ast.Node) -> set[str]:
    """Named bounds that leave an expression as its value."""
    if isinstance(node, c_ast.FuncCall):
        return _names(node.args)
    if isinstance(node, c_ast.Decl):
        return _names(node.init)
    if isinstance(node, c_ast.Assignment):
        return _names(node.rvalue)
    if isinstance(node, c_ast.Return):
        return _names(node.expr)
    return set()


def _names(node: c_ast.Node | None) -> set[str]:
    found = () if node is None else _nodes(node)
    return {n.name for n in found if isinstance(n, c_ast.ID) and named_bound(n.name)}


def _nodes(node: c_ast.Node) -> Iterator[c_ast.Node]:
    yield node
    for _, child in node.children():
        yield from _nodes(child)
