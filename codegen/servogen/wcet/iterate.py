"""Worst-case cost of a counted ``for`` loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pycparser import c_ast

from servogen.wcet.caps import affine_bound
from servogen.wcet.constants import Value
from servogen.wcet.ctype import INT, Scalar
from servogen.wcet.expressions import read, truth
from servogen.wcet.frame import Frame
from servogen.wcet.loops import Header, assigned_names, counter_values, read_header
from servogen.wcet.operations import Cost
from servogen.wcet.refusal import refuse

_FOLLOWED = 2_000  # iterations of a solver; of more, each is taken to be the costliest
_MOST_ITERATIONS = 200_000  # of a loop whose iterations differ and are counted one by one

# Adds the cost of a statement; True if what follows it is never reached.
Statement = Callable[[Frame, c_ast.Node, Cost], bool]


@dataclass
class _Loop:
    """A loop being counted.

    Attributes:
        changed: variables, other than the counter, that an iteration may change.
        followed: iterations are counted one after another, each from where the last one ended.
    """

    frame: Frame
    node: c_ast.For
    header: Header
    statement: Statement
    changed: set[str]
    followed: bool = False

    def set_counter(self, number: int | None) -> None:
        counter = self.header.counter
        self.frame.assign(counter, Value(number, frozenset({counter})), INT)

    def test(self, number: int | None) -> Cost:
        """Cost of the condition."""
        cost = Cost()
        self.set_counter(number)
        truth(self.frame, self.node.cond, cost)
        cost.hit("branch")
        return cost

    def turn(self, number: int | None) -> Cost:
        """Cost of an iteration: condition, body, step."""
        cost = self.test(number)
        self.statement(self.frame, self.node.stmt, cost)
        if not self.followed:
            self.frame.forget(self.changed)
        self.set_counter(number)
        read(self.frame, self.node.next, cost)
        return cost


def count_loop(frame: Frame, node: c_ast.For, cost: Cost, statement: Statement) -> None:
    """Add the cost of the loop, every iteration of it, whatever leaves it early.

    Raises:
        CountRefused: no constant number of iterations.
    """
    header = read_header(node)
    _check_counter(frame, node, header)
    statement(frame, node.init, cost)
    changed = (assigned_names(node.stmt) | assigned_names(node.next)) - {header.counter}
    loop = _Loop(frame, node, header, statement, changed)
    at_entry = {name: frame.values[name] for name in changed if name in frame.values}
    frame.forget(changed)
    values, bound = counter_values(node, header, frame.decide)
    frame.note(node, len(values))
    outer_use = header.counter in frame.used
    frame.used.discard(header.counter)
    if bound.cap is None:
        _counted(loop, values, cost)
    else:
        # A solver's loop may count its turns in a variable of its own, which then stays known; a
        # continue would join ways on which it differs.
        loop.followed = len(values) <= _FOLLOWED and not _holds_continue(node.stmt)
        if loop.followed:
            frame.values.update(at_entry)
        _capped(loop, values, bound, cost)
    frame.forget(changed)
    cost.add(loop.test(values[-1] + values.step if values else values.start))
    frame.used.discard(header.counter)
    if outer_use:
        frame.used.add(header.counter)
    frame.forget(changed | {header.counter})


def _counted(loop: _Loop, values: range, cost: Cost) -> None:
    """The first iteration times their number, unless the counter decides the cost."""
    if not values:
        return
    first = loop.turn(values[0])
    if loop.header.counter not in loop.frame.used:
        cost.add(first, len(values))
        return
    if len(values) > _MOST_ITERATIONS:
        raise refuse(loop.node, f"more than {_MOST_ITERATIONS} iterations that differ")
    cost.add(first)
    for number in values[1:]:
        cost.add(loop.turn(number))


def _capped(loop: _Loop, values: range, bound: Value, cost: Cost) -> None:
    """A fixed part and a part per iteration of the named cap."""
    cap = bound.cap
    assert cap is not None
    if bound.number != len(values) or not values:
        raise refuse(
            loop.node, f"the loop does not run just as often as its iteration cap '{cap}' says"
        )
    numbers = values if len(values) <= _FOLLOWED else (None,)
    turns = [loop.turn(number) for number in numbers]
    if any(part.per_iteration for part in turns):
        raise refuse(loop.node, "a loop up to an iteration cap inside another")
    part = Cost()
    part.fixed, part.per_iteration[cap] = affine_bound([turn.fixed for turn in turns])
    cost.add(part)


def _holds_continue(node: c_ast.Node) -> bool:
    return isinstance(node, c_ast.Continue) or any(_holds_continue(c) for _, c in node.children())


def _check_counter(frame: Frame, node: c_ast.For, header: Header) -> None:
    if header.counter in frame.typed.in_memory:
        raise refuse(node, f"the address of the counter '{header.counter}' is taken")
    kinds = [(d.name, t) for d, t in frame.typed.locals]
    kinds += zip(frame.typed.parameters, frame.typed.signature.parameters, strict=False)
    unsigned = any(
        name == header.counter and isinstance(kind, Scalar) and not kind.signed
        for name, kind in kinds
    )
    if unsigned and header.op == ">=":
        raise refuse(node, f"the unsigned counter '{header.counter}' may pass below zero")
