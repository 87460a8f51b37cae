"""Worst-case cost of a counted ``for`` loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pycparser import c_ast

from servogen.wcet.caps import affine_bound, cycle_bound
from servogen.wcet.constants import CAP_SUFFIX, Value
from servogen.wcet.counter import check_counter, check_values
from servogen.wcet.ctype import INT
from servogen.wcet.expressions import read, truth
from servogen.wcet.frame import Frame
from servogen.wcet.loops import (
    Header,
    assigned_names,
    counter_values,
    holds,
    leaves_early,
    read_header,
)
from servogen.wcet.operations import Cap, Cost
from servogen.wcet.refusal import refuse
from servogen.wcet.typed import LOGICAL

_FOLLOWED = 2_000  # iterations of a solver that are counted one by one
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

    def known(self) -> dict[str, Value]:
        """What is known of the variables that a turn may change."""
        values = self.frame.values
        return {name: values[name] for name in sorted(self.changed) if name in values}

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
    check_counter(frame, node, header)
    statement(frame, node.init, cost)
    changed = (assigned_names(node.stmt) | assigned_names(node.next)) - {header.counter}
    loop = _Loop(frame, node, header, statement, changed)
    at_entry = {name: frame.values[name] for name in changed if name in frame.values}
    frame.forget(changed)
    values, bound = counter_values(node, header, frame.decide)
    check_values(frame, node, header, values, bound)
    frame.note(node, len(values))
    outer_use = header.counter in frame.used
    frame.used.discard(header.counter)
    whole = Cost()
    if bound.cap is None:
        _counted(loop, values, whole)
    else:
        # A solver's loop may count its turns in a variable of its own, which then stays known; a
        # continue would join ways on which it differs.
        loop.followed = not holds([node.stmt], c_ast.Continue)
        if loop.followed:
            frame.values.update(at_entry)
        _capped(loop, values, bound, whole)
    frame.forget(changed)
    whole.add(loop.test(values[-1] + values.step if values else values.start))
    if leaves_early(node.stmt) or not _plain_test(node):
        whole.loosen()
    cost.add(whole)
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
    """A fixed part and a part per turn of the named bound."""
    assert bound.cap is not None
    if bound.number != len(values) or not values:
        raise refuse(
            loop.node,
            f"the loop does not run just as often as its {_kind(bound.cap)} '{bound.cap}' says",
        )
    cap = Cap(bound.cap, len(values))
    few = len(values) <= _FOLLOWED
    turns, cycle = (_each(loop, values), 0) if few else _until_they_repeat(loop)
    for turn in turns:
        if any(inner.name.endswith(CAP_SUFFIX) for inner in turn.per_iteration):
            raise refuse(loop.node, f"a loop up to an iteration cap inside one up to '{cap.name}'")
        turn.fold()
        cost.loose |= turn.loose
    lists = [turn.fixed for turn in turns]
    part = Cost()
    part.fixed, part.per_iteration[cap] = affine_bound(lists) if few else cycle_bound(lists, cycle)
    if few:
        part.loosen_above([sum(column) for column in zip(*lists, strict=True)])
    else:
        part.loosen()
    cost.add(part)


def _each(loop: _Loop, values: range) -> list[Cost]:
    """The turns one after another."""
    return [loop.turn(number) for number in values]


def _until_they_repeat(loop: _Loop) -> tuple[list[Cost], int]:
    """Turns of any number of iterations, and how many of the last ones go on for ever.

    What the counter holds is not made use of, so that a turn depends on nothing but what is known
    of the other variables when it begins: once that was seen before, the turns repeat.
    """
    turns: list[Cost] = []
    seen: list[dict[str, tuple[int | None, str | None]]] = []
    while len(turns) < _FOLLOWED:
        state = {n: (v.number, v.cap) for n, v in loop.known().items()}
        if state in seen:
            return turns, len(turns) - seen.index(state)
        seen.append(state)
        turns.append(loop.turn(None))
    raise refuse(loop.node, f"more than {_FOLLOWED} iterations that differ")


def _kind(name: str) -> str:
    return "iteration cap" if name.endswith(CAP_SUFFIX) else "tree depth"


def _plain_test(node: c_ast.For) -> bool:
    """True when the loop goes on as long as its counter says."""
    return isinstance(node.cond, c_ast.BinaryOp) and node.cond.op not in LOGICAL
