"""Worst-case cost of an expression.

The model: scalar locals and parameters live in registers and cost nothing to read or write. An
element of an array or structure, a global, and a local whose address is taken live in memory: a
read is a load, a write a store, a structure copied by value a load and a store per element.
Address arithmetic is counted where it is written (``m[i * n + j]``: one multiplication, one
addition, one load), not where the subscript implies it. What every compiler folds (literals,
enumeration constants, sizeof, and operators on nothing else) is free.
"""

from __future__ import annotations

from pycparser import c_ast

from servogen.wcet.constants import Value
from servogen.wcet.ctype import CType, Record, Scalar, arithmetic, decay, elements
from servogen.wcet.frame import Frame
from servogen.wcet.loops import assigned_names
from servogen.wcet.operations import Cost
from servogen.wcet.refusal import refuse
from servogen.wcet.typed import COMPARISONS, LOGICAL, MATH_CLASSES, MEMORY_FUNCTIONS

# operator -> (class for scalars, class for integers)
OPERATOR_CLASSES = {
    "+": ("add", "int_add"),
    "-": ("add", "int_add"),
    "*": ("mul", "int_mul"),
    "/": ("div", "int_div"),
    "%": ("div", "int_div"),
    **dict.fromkeys(("<<", ">>", "&", "|", "^"), ("add", "int_add")),
}


def read(frame: Frame, node: c_ast.Node, cost: Cost) -> None:
    """Add the cost of evaluating ``node`` for its value."""
    if frame.typed.is_literal(node):
        return
    if isinstance(node, c_ast.ID | c_ast.ArrayRef | c_ast.StructRef):
        _load(frame, node, cost)
    elif isinstance(node, c_ast.UnaryOp):
        _unary(frame, node, cost)
    elif isinstance(node, c_ast.BinaryOp):
        _binary(frame, node, cost)
    elif isinstance(node, c_ast.Assignment):
        _assignment(frame, node, cost)
    elif isinstance(node, c_ast.TernaryOp):
        _ternary(frame, node, cost)
    elif isinstance(node, c_ast.Cast):
        read(frame, node.expr, cost)
        convert(frame, node.expr, frame.typed.type_of(node), cost)
    elif isinstance(node, c_ast.FuncCall):
        _call(frame, node, cost)
    elif isinstance(node, c_ast.ExprList):
        for item in node.exprs:
            read(frame, item, cost)
    else:
        raise refuse(node, f"a {type(node).__name__} in an expression")


def truth(frame: Frame, node: c_ast.Node, cost: Cost) -> None:
    """Add the cost of ``node`` as a condition: a scalar is compared with zero."""
    read(frame, node, cost)
    if frame.is_real(node) and not frame.typed.is_literal(node):
        cost.hit("cmp")


def convert(frame: Frame, node: c_ast.Node, to: CType, cost: Cost) -> None:
    """Add the conversion of ``node``'s value to type ``to``, if it is one at run time."""
    kind = frame.typed.type_of(node)
    if not isinstance(kind, Scalar) or not isinstance(to, Scalar) or to.kind == "void":
        return
    _check_precision(frame, node, to)
    if kind.kind != to.kind and not frame.typed.is_literal(node):
        cost.hit("convert")


def copy_record(kind: CType, cost: Cost) -> None:
    """Add the loads and stores of a structure copied by value."""
    reals, others = elements(kind)
    for prefix, number in (("", reals), ("int_", others)):
        cost.hit(prefix + "load", number)
        cost.hit(prefix + "store", number)


def address(frame: Frame, node: c_ast.Node, cost: Cost) -> None:
    """Add the cost of finding the lvalue ``node``, without reading it."""
    if isinstance(node, c_ast.ArrayRef):
        read(frame, node.name, cost)
        read(frame, node.subscript, cost)
    elif isinstance(node, c_ast.StructRef):
        (read if node.type == "->" else address)(frame, node.name, cost)
    elif isinstance(node, c_ast.UnaryOp) and node.op == "*":
        read(frame, node.expr, cost)
    elif not isinstance(node, c_ast.ID):
        read(frame, node, cost)


def access(frame: Frame, node: c_ast.Node, what: str, cost: Cost) -> None:
    """Count a ``load`` or ``store`` of the scalar ``node`` if it lives in memory."""
    kind = frame.typed.type_of(node)
    in_memory = frame.typed.reads_memory(node)
    if in_memory and kind is decay(kind) and not isinstance(kind, Record):
        cost.hit(what if frame.is_real(node) else f"int_{what}")


def _load(frame: Frame, node: c_ast.Node, cost: Cost) -> None:
    address(frame, node, cost)
    access(frame, node, "load", cost)


def _unary(frame: Frame, node: c_ast.UnaryOp, cost: Cost) -> None:
    if node.op == "*":
        _load(frame, node, cost)
    elif node.op == "&":
        address(frame, node.expr, cost)
    elif node.op == "!":
        read(frame, node.expr, cost)
        cost.hit("cmp" if frame.is_real(node.expr) else "int_cmp")
    elif node.op in ("++", "--", "p++", "p--"):
        _load(frame, node.expr, cost)
        _operate(frame, node, "+", frame.typed.type_of(node), cost)
        access(frame, node.expr, "store", cost)
        if isinstance(node.expr, c_ast.ID):
            before = frame.value(node.expr)
            delta = 1 if "++" in node.op else -1
            after = None if before.number is None else before.number + delta
            frame.assign(node.expr.name, Value(after, before.deps), frame.typed.type_of(node))
    else:
        read(frame, node.expr, cost)
        if node.op == "-" and frame.is_real(node):
            _check_precision(frame, node, frame.typed.type_of(node))
            cost.hit("neg")
        elif node.op != "+":
            cost.hit("int_add")


def _binary(frame: Frame, node: c_ast.BinaryOp, cost: Cost) -> None:
    if node.op in LOGICAL:
        truth(frame, node.left, cost)
        right = Cost()
        truth(frame, node.right, right)
        right.loosen()  # run only if the left side leaves it open
        cost.add(right)
        cost.hit("branch")
        frame.forget(assigned_names(node.right))
        return
    read(frame, node.left, cost)
    read(frame, node.right, cost)
    common = arithmetic(frame.typed.type_of(node.left), frame.typed.type_of(node.right))
    convert(frame, node.left, common, cost)
    convert(frame, node.right, common, cost)
    _operate(frame, node, node.op, common, cost)


def _operate(frame: Frame, node: c_ast.Node, op: str, kind: CType, cost: Cost) -> None:
    real = isinstance(kind, Scalar) and kind.is_real
    if real:
        _check_precision(frame, node, kind)
    if op in COMPARISONS:
        cost.hit("cmp" if real else "int_cmp")
    else:
        cost.hit(OPERATOR_CLASSES[op][0 if real else 1])


def _assignment(frame: Frame, node: c_ast.Assignment, cost: Cost) -> None:
    kind = frame.typed.type_of(node.lvalue)
    read(frame, node.rvalue, cost)
    if isinstance(kind, Record):
        address(frame, node.lvalue, cost)
        copy_record(kind, cost)
        return
    convert(frame, node.rvalue, kind, cost)
    address(frame, node.lvalue, cost)
    value = frame.value(node.rvalue)
    if node.op != "=":
        access(frame, node.lvalue, "load", cost)
        _operate(frame, node, node.op[:-1], kind, cost)
        value = frame.combined(node)
    access(frame, node.lvalue, "store", cost)
    if isinstance(node.lvalue, c_ast.ID):
        frame.assign(node.lvalue.name, value, kind)


def _ternary(frame: Frame, node: c_ast.TernaryOp, cost: Cost) -> None:
    chosen = frame.decide(node.cond)
    truth(frame, node.cond, cost)
    if not frame.typed.is_literal(node.cond):
        cost.hit("branch")
    kind = frame.typed.type_of(node)
    ways = []
    for number, way in ((1, node.iftrue), (0, node.iffalse)):
        if chosen.number is None or bool(chosen.number) == bool(number):
            part = Cost()
            read(frame, way, part)
            convert(frame, way, kind, part)
            ways.append(part)
    frame.forget(assigned_names(node.iftrue) | assigned_names(node.iffalse))
    worst = ways[0]
    for part in ways[1:]:
        worst.raise_to(part)
    cost.add(worst)


def _call(frame: Frame, node: c_ast.FuncCall, cost: Cost) -> None:
    name = node.name.name
    arguments = node.args.exprs if node.args is not None else []
    wanted = frame.typed.unit.prototypes[name].parameters
    for argument, kind in zip(arguments, wanted, strict=False):
        read(frame, argument, cost)
        convert(frame, argument, kind, cost)
        if isinstance(kind, Record):
            copy_record(kind, cost)
    for argument in arguments[len(wanted) :]:
        read(frame, argument, cost)
    if frame.typed.is_library(name):
        if name in MATH_CLASSES:
            cost.hit(MATH_CLASSES[name])
        else:
            loads, stores = memory_words(frame, node)
            cost.hit("int_load", loads)
            cost.hit("int_store", stores)
            cost.hit("call")
        return
    values = [frame.value(a) for a in arguments]
    called = frame.callee(node, name, values)
    for position in called.decisive:
        frame.used |= values[position].deps
    cost.hit("call")
    cost.add(called.cost)


def memory_words(frame: Frame, node: c_ast.FuncCall) -> tuple[int, int]:
    """Words that a call of memset or memcpy reads and writes.

    Raises:
        CountRefused: its size is not a constant.
    """
    size = frame.decide(node.args.exprs[-1]).number
    if size is None:
        raise refuse(node, f"the size given to '{node.name.name}' is not a constant")
    loads, stores = MEMORY_FUNCTIONS[node.name.name]
    words = -(-size // 4)
    return loads * words, stores * words


def _check_precision(frame: Frame, node: c_ast.Node, kind: CType) -> None:
    """A double in a float package costs a library call on many targets: never by accident."""
    if isinstance(kind, Scalar) and kind.is_real and kind.kind != frame.real_kind:
        raise refuse(node, f"arithmetic in {kind.kind} where sg_real is {frame.real_kind}")
