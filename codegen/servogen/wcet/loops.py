"""Counted ``for`` loops: counter, bound and step read from the header."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import UnionType

from pycparser import c_ast

from servogen.wcet.constants import Value
from servogen.wcet.refusal import refuse

_MIRROR = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "!=": "!="}


@dataclass(frozen=True)
class Header:
    """``for (counter = start; counter op bound; counter += sign * step)``.

    ``step`` is None for ``++`` and ``--``; ``use`` is the counter where it is compared.
    """

    counter: str
    start: c_ast.Node
    op: str
    bound: c_ast.Node
    step: c_ast.Node | None
    sign: int
    use: c_ast.Node


def read_header(node: c_ast.For) -> Header:
    """Header of a counted loop.

    Raises:
        CountRefused: anything else, or a counter that the body changes.
    """
    counter, start = _start(node)
    op, bound, use = _bound(node, counter)
    step, sign = _step(node, counter)
    if counter in assigned_names(node.stmt) | assigned_names(node.cond):
        raise refuse(node, f"the loop changes its own counter '{counter}'")
    return Header(counter, start, op, bound, step, sign, use)


def counter_values(
    node: c_ast.For, header: Header, evaluate: Callable[[c_ast.Node], Value]
) -> tuple[range, Value]:
    """Values the counter takes, and the value of the bound.

    Raises:
        CountRefused: start, bound or step is not a constant at this call, or the loop has no end.
    """
    start, bound = evaluate(header.start), evaluate(header.bound)
    step = Value(1) if header.step is None else evaluate(header.step)
    for what, value in (("start", start), ("bound", bound), ("step", step)):
        if value.number is None:
            raise refuse(node, f"the {what} of the loop over '{header.counter}' is not a constant")
    assert start.number is not None
    assert bound.number is not None
    assert step.number is not None
    stride = header.sign * step.number
    ends = {"<": stride > 0, "<=": stride > 0, ">": stride < 0, ">=": stride < 0}
    if header.op == "!=":
        rest = bound.number - start.number
        if stride == 0 or rest % stride or rest // stride < 0:
            raise refuse(node, f"the loop over '{header.counter}' steps over its end")
    elif not ends[header.op]:
        raise refuse(node, f"the loop over '{header.counter}' counts away from its bound")
    last = bound.number + ({"<=": 1, ">=": -1}.get(header.op, 0))
    return range(start.number, last, stride), bound


def assigned_names(node: c_ast.Node) -> set[str]:
    """Names of variables that a statement or expression may change or declare."""
    names: set[str] = set()
    pending = [node]
    while pending:
        item = pending.pop()
        target = None
        if isinstance(item, c_ast.Assignment):
            target = item.lvalue
        elif isinstance(item, c_ast.UnaryOp) and item.op in ("++", "--", "p++", "p--", "&"):
            target = item.expr
        elif isinstance(item, c_ast.Decl):
            names.add(item.name)
        if isinstance(target, c_ast.ID):
            names.add(target.name)
        pending.extend(child for _, child in item.children())
    return names


def holds(nodes: Sequence[c_ast.Node], kind: type | UnionType) -> bool:
    """True when a node of this kind is among them or inside one of them."""
    pending = list(nodes)
    while pending:
        item = pending.pop()
        if isinstance(item, kind):
            return True
        pending.extend(child for _, child in item.children())
    return False


def leaves_early(body: c_ast.Node | None) -> bool:
    """True when a turn of the loop with this body may skip the rest of it, or of the loop."""
    if body is None:
        return False
    if isinstance(body, c_ast.For | c_ast.DoWhile):  # its own break and continue stay inside
        return holds([body], c_ast.Return)
    if isinstance(body, c_ast.Switch):
        return holds([body], c_ast.Return | c_ast.Continue)
    if isinstance(body, c_ast.Return | c_ast.Break | c_ast.Continue):
        return True
    return any(leaves_early(child) for _, child in body.children())


def _start(node: c_ast.For) -> tuple[str, c_ast.Node]:
    init = node.init
    if isinstance(init, c_ast.DeclList) and len(init.decls) == 1 and init.decls[0].init is not None:
        return init.decls[0].name, init.decls[0].init
    if isinstance(init, c_ast.Assignment) and init.op == "=" and isinstance(init.lvalue, c_ast.ID):
        return init.lvalue.name, init.rvalue
    raise refuse(node, "the loop does not start by setting one counter")


def _bound(node: c_ast.For, counter: str) -> tuple[str, c_ast.Node, c_ast.Node]:
    """Comparison of the counter, bound and counter; of ``a && b`` the first operand that is one."""
    pending = [node.cond]
    while pending:
        test = pending.pop(0)
        if isinstance(test, c_ast.BinaryOp) and test.op == "&&":
            pending = [test.left, test.right, *pending]
        elif isinstance(test, c_ast.BinaryOp) and test.op in _MIRROR:
            if _is(test.left, counter):
                return test.op, test.right, test.left
            if _is(test.right, counter):
                return _MIRROR[test.op], test.left, test.right
    raise refuse(node, f"the loop has no bound on its counter '{counter}'")


def _step(node: c_ast.For, counter: str) -> tuple[c_ast.Node | None, int]:
    step = node.next
    if isinstance(step, c_ast.UnaryOp) and _is(step.expr, counter):
        if step.op in ("++", "p++"):
            return None, 1
        if step.op in ("--", "p--"):
            return None, -1
    if isinstance(step, c_ast.Assignment) and _is(step.lvalue, counter):
        if step.op in ("+=", "-="):
            return step.rvalue, 1 if step.op == "+=" else -1
        sum_ = step.rvalue
        if isinstance(sum_, c_ast.BinaryOp) and sum_.op in ("+", "-") and _is(sum_.left, counter):
            return sum_.right, 1 if sum_.op == "+" else -1
    raise refuse(node, f"the loop does not step its counter '{counter}' by a constant")


def _is(node: c_ast.Node, name: str) -> bool:
    return isinstance(node, c_ast.ID) and node.name == name
