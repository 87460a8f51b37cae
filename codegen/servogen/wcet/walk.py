"""Worst-case cost of statements: branches by maximum, loops by their counts."""

from __future__ import annotations

from collections.abc import Sequence

from pycparser import c_ast

from servogen.wcet.ctype import Array, CType, Record, Scalar, elements
from servogen.wcet.expressions import convert, copy_record, read, truth
from servogen.wcet.frame import Frame
from servogen.wcet.iterate import count_loop
from servogen.wcet.loops import assigned_names, holds, leaves_early
from servogen.wcet.operations import Cost
from servogen.wcet.refusal import refuse


def count_body(frame: Frame, cost: Cost) -> None:
    """Add the cost of the frame's function."""
    items = frame.typed.node.body.block_items or []
    body = Cost()
    _block(frame, items, body)
    last = [items[-1]] if items and isinstance(items[-1], c_ast.Return) else []
    if holds(items[: len(items) - len(last)], c_ast.Return):
        body.loosen()  # what follows an early return, however deep, is not always run
    cost.add(body)


def _statement(frame: Frame, node: c_ast.Node, cost: Cost) -> bool:
    """Add the cost of one statement; True if what follows it in its block is never reached."""
    if isinstance(node, c_ast.Compound):
        return _block(frame, node.block_items or [], cost)
    if isinstance(node, c_ast.If):
        return _if(frame, node, [], cost)
    if isinstance(node, c_ast.For):
        count_loop(frame, node, cost, _statement)
    elif isinstance(node, c_ast.While):
        raise refuse(node, "a while loop has no bound")
    elif isinstance(node, c_ast.DoWhile):
        if frame.value(node.cond).number != 0 or not frame.typed.is_literal(node.cond):
            raise refuse(node, "a do loop has no bound")
        once = Cost()
        _statement(frame, node.stmt, once)
        if leaves_early(node.stmt):
            once.loosen()
        cost.add(once)
        frame.forget(assigned_names(node.stmt))
    elif isinstance(node, c_ast.Switch):
        _switch(frame, node, cost)
    elif isinstance(node, c_ast.DeclList):
        for declaration in node.decls:
            _declaration(frame, declaration, cost)
    elif isinstance(node, c_ast.Decl):
        _declaration(frame, node, cost)
    elif isinstance(node, c_ast.Return):
        _return(frame, node, cost)
        return True
    elif isinstance(node, c_ast.Break | c_ast.Continue):
        return True
    elif not isinstance(node, c_ast.EmptyStatement):
        read(frame, node, cost)
    return False


def _block(frame: Frame, items: Sequence[c_ast.Node], cost: Cost) -> bool:
    for position, item in enumerate(items):
        if isinstance(item, c_ast.If):
            rest = items[position + 1 :]
            if _leaves(item.iftrue) or _leaves(item.iffalse):
                return _if(frame, item, rest, cost)
        if _statement(frame, item, cost):
            return True
    return False


def _leaves(node: c_ast.Node | None) -> bool:
    """True when the statement ends in return, break or continue at its own level."""
    if isinstance(node, c_ast.Compound):
        return bool(node.block_items) and _leaves(node.block_items[-1])
    return isinstance(node, c_ast.Return | c_ast.Break | c_ast.Continue)


def _if(frame: Frame, node: c_ast.If, rest: Sequence[c_ast.Node], cost: Cost) -> bool:
    """A decision followed by ``rest``, which only a way that does not leave goes on to."""
    chosen = frame.decide(node.cond)
    truth(frame, node.cond, cost)
    if not frame.typed.is_literal(node.cond):
        cost.hit("branch")
    if chosen.number is not None:
        return _way(frame, node.iftrue if chosen.number else node.iffalse, rest, cost)
    before = dict(frame.values)
    then, other = Cost(), Cost()
    then_left = _way(frame, node.iftrue, rest if _leaves(node.iffalse) else [], then)
    after_then = frame.values
    frame.values = before
    other_left = _way(frame, node.iffalse, rest if _leaves(node.iftrue) else [], other)
    if then_left and not other_left:
        pass
    elif other_left and not then_left:
        frame.values = after_then
    else:
        frame.merge(after_then, frame.values)
    then.raise_to(other)
    cost.add(then)
    return then_left and other_left


def _way(frame: Frame, node: c_ast.Node | None, rest: Sequence[c_ast.Node], cost: Cost) -> bool:
    return (node is not None and _statement(frame, node, cost)) or _block(frame, rest, cost)


def _switch(frame: Frame, node: c_ast.Switch, cost: Cost) -> None:
    """The costliest entry, with what it falls through to; a comparison for each label."""
    if not isinstance(node.stmt, c_ast.Compound):
        raise refuse(node, "a switch without braces")
    read(frame, node.cond, cost)
    labels = node.stmt.block_items or []
    if not all(isinstance(x, c_ast.Case | c_ast.Default) for x in labels):
        raise refuse(node, "a switch with statements outside its labels")
    number = sum(isinstance(x, c_ast.Case) for x in labels)
    cost.hit("int_cmp", number)
    cost.hit("branch", number)
    frame.forget(assigned_names(node.stmt))
    before = dict(frame.values)
    worst = Cost()
    for entry in range(len(labels)):
        frame.values = dict(before)
        part = Cost()
        for label in labels[entry:]:
            if _block(frame, label.stmts or [], part):
                break
        worst.raise_to(part)
    frame.values = before
    worst.loosen()
    cost.add(worst)


def _declaration(frame: Frame, node: c_ast.Decl, cost: Cost) -> None:
    if node.init is None or "static" in node.storage:
        return
    kind = next(t for d, t in frame.typed.locals if d is node)
    if isinstance(kind, Array | Record):
        _initialise(frame, node.init, kind, cost)
        return
    read(frame, node.init, cost)
    convert(frame, node.init, kind, cost)
    if node.name in frame.typed.in_memory:
        cost.hit("store" if isinstance(kind, Scalar) and kind.is_real else "int_store")
    frame.assign(node.name, frame.value(node.init), kind)


def _initialise(frame: Frame, init: c_ast.Node, kind: CType, cost: Cost) -> None:
    """An array or structure set at its declaration: all of it is written."""
    if not isinstance(init, c_ast.InitList):
        read(frame, init, cost)
        copy_record(kind, cost)
        return
    reals, others = elements(kind)
    cost.hit("store", reals)
    cost.hit("int_store", others)
    _initial_values(frame, init, cost)


def _initial_values(frame: Frame, init: c_ast.InitList, cost: Cost) -> None:
    for item in init.exprs:
        value = item.expr if isinstance(item, c_ast.NamedInitializer) else item
        if isinstance(value, c_ast.InitList):
            _initial_values(frame, value, cost)
        elif frame.is_record(value):
            raise refuse(value, "a structure inside an initialiser")
        else:
            read(frame, value, cost)


def _return(frame: Frame, node: c_ast.Return, cost: Cost) -> None:
    if node.expr is None:
        return
    result = frame.typed.signature.result
    read(frame, node.expr, cost)
    convert(frame, node.expr, result, cost)
    if isinstance(result, Record):
        copy_record(result, cost)
