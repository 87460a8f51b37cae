"""Rewrite parsed C so that it counts its own operations (macros of sg_counting.h)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

from pycparser import c_ast, c_generator

from servogen.wcet.constants import evaluate
from servogen.wcet.ctype import Array, CType, Record, Scalar, elements
from servogen.wcet.operations import CLASSES
from servogen.wcet.refusal import refuse
from servogen.wcet.turns import turn_of
from servogen.wcet.typed import LOGICAL, MATH_CLASSES, MEMORY_FUNCTIONS, TypedFunction
from servogen.wcet.unit import Unit

_MACROS = {
    "+": "SG_ADD",
    "-": "SG_ADD",
    "*": "SG_MUL",
    "/": "SG_DIV",
    "%": "SG_DIV",
    **dict.fromkeys(("<<", ">>", "&", "|", "^"), "SG_ADD"),
}
_TESTS = {
    "<": "SG_LT",
    "<=": "SG_LE",
    ">": "SG_GT",
    ">=": "SG_GE",
    "==": "SG_EQ",
    "!=": "SG_NE",
}


def prelude(watched: Sequence[str] = ()) -> str:
    """C constants ahead of sg_counting.h: the classes in the order of ``CLASSES``, and the named
    bounds whose turns are watched."""
    names = [f"SG_N_{name.upper()} = {i}" for i, name in enumerate(CLASSES)]
    names += [f"SG_N_CLASSES = {len(CLASSES)}"]
    names += [f"{_turn_name(name)} = {i}" for i, name in enumerate(watched)]
    names += [f"SG_N_TURNS = {len(watched)}"]
    return f"enum {{ {', '.join(names)} }};\n"


def instrument(unit: Unit, watched: Sequence[str] = ()) -> str:
    """C text of the unit with counting in every function; the tree is changed in place.

    Args:
        unit: what to rewrite.
        watched: named bounds (see ``turns.watched_bounds``): the turns done are kept as well.

    Raises:
        CountRefused: what the static count refuses by form (goto, pointer calls, odd types).
    """
    for node in unit.functions.values():
        _Rewriter(TypedFunction(unit, node), watched).body()
    text: str = c_generator.CGenerator().visit(unit.tree)
    return prelude(watched) + '#include "sg_counting.h"\n' + text


def _turn_name(bound: str) -> str:
    return f"SG_TURNS_{bound}"


class _Rewriter:
    def __init__(self, typed: TypedFunction, watched: Sequence[str]) -> None:
        self.typed = typed
        self.watched = watched

    def body(self) -> None:
        self.statement(self.typed.node.body)

    # -- statements ------------------------------------------------------------------------

    def statement(self, node: c_ast.Node | None) -> c_ast.Node | None:
        """The statement that replaces ``node``."""
        if isinstance(node, c_ast.Compound):
            node.block_items = self._block(node.block_items or [])
        elif isinstance(node, c_ast.If):
            node.cond = self._decision(node.cond)
            node.iftrue = self.statement(node.iftrue)
            node.iffalse = self.statement(node.iffalse)
        elif isinstance(node, c_ast.For):
            told = self._turn(node)
            node.init = self.statement(node.init)
            node.cond = _macro("SG_IF", self._truth(node.cond))
            node.next = self._value(node.next)
            node.stmt = self.statement(node.stmt)
            if told is not None:
                node.stmt = c_ast.Compound([told, node.stmt])
        elif isinstance(node, c_ast.DoWhile):
            node.stmt = self.statement(node.stmt)
        elif isinstance(node, c_ast.Switch):
            self._switch(node)
        elif isinstance(node, c_ast.DeclList):
            for declaration in node.decls:
                self._declaration(declaration)
        elif isinstance(node, c_ast.Decl):
            self._declaration(node)
        elif isinstance(node, c_ast.Return):
            self._return(node)
        elif isinstance(node, c_ast.While):
            raise refuse(node, "a while loop has no bound")
        elif node is not None and not isinstance(
            node, c_ast.Break | c_ast.Continue | c_ast.EmptyStatement
        ):
            return self._value(node)
        return node

    def _turn(self, node: c_ast.For) -> c_ast.Node | None:
        """The statement that says which turn of a loop up to a watched bound this is."""
        turn = turn_of(node)
        if turn is None or turn.bound not in self.watched:
            return None
        number = c_ast.BinaryOp("-", c_ast.ID(turn.counter), turn.start)
        return _macro("sg_turn", c_ast.ID(_turn_name(turn.bound)), number)

    def _block(self, items: list[c_ast.Node]) -> list[c_ast.Node]:
        done = []
        for item in items:
            if isinstance(item, c_ast.Decl) and item.init is not None:
                done.extend(self._stores_ahead(item))
            done.append(self.statement(item))
        return done

    def _stores_ahead(self, node: c_ast.Decl) -> list[c_ast.Node]:
        """The stores of an object in memory set at its declaration, as statements before it."""
        kind = self._local_type(node)
        whole = isinstance(kind, Array | Record)
        if "static" in node.storage or not (whole or node.name in self.typed.in_memory):
            return []
        reals, others = elements(kind)
        stores = [("SG_N_STORE", reals), ("SG_N_INT_STORE", others)]
        if whole and not isinstance(node.init, c_ast.InitList):
            stores += [("SG_N_LOAD", reals), ("SG_N_INT_LOAD", others)]
        return [_macro("sg_hit", c_ast.ID(name), _int(number)) for name, number in stores]

    def _declaration(self, node: c_ast.Decl) -> None:
        if node.init is None or "static" in node.storage:
            return
        kind = self._local_type(node)
        if isinstance(node.init, c_ast.InitList):
            self._initialiser(node.init)
        elif isinstance(kind, Record):
            node.init = self._value(node.init)
        else:
            node.init = self._converted(node.init, kind)

    def _initialiser(self, node: c_ast.InitList) -> None:
        for position, item in enumerate(node.exprs):
            named = isinstance(item, c_ast.NamedInitializer)
            value = item.expr if named else item
            if isinstance(value, c_ast.InitList):
                self._initialiser(value)
            elif named:
                item.expr = self._value(value)
            else:
                node.exprs[position] = self._value(value)

    def _local_type(self, node: c_ast.Decl) -> CType:
        return next(kind for d, kind in self.typed.locals if d is node)

    def _switch(self, node: c_ast.Switch) -> None:
        labels = node.stmt.block_items or []
        number = sum(isinstance(label, c_ast.Case) for label in labels)
        node.cond = _macro("SG_SWITCH", _int(number), self._value(node.cond))
        for label in labels:
            label.stmts = self._block(label.stmts or [])

    def _return(self, node: c_ast.Return) -> None:
        if node.expr is None:
            return
        result = self.typed.signature.result
        if isinstance(result, Record):
            node.expr = _copy(result, self._value(node.expr))
        else:
            node.expr = self._converted(node.expr, result)

    # -- expressions -----------------------------------------------------------------------

    def _decision(self, node: c_ast.Node) -> c_ast.Node:
        if self.typed.is_literal(node):
            return node
        return _macro("SG_IF", self._truth(node))

    def _truth(self, node: c_ast.Node) -> c_ast.Node:
        if self.typed.is_literal(node):
            return node
        return _macro("SG_TRUTH", self._value(node))

    def _converted(self, node: c_ast.Node, to: CType) -> c_ast.Node:
        kind = self.typed.type_of(node)
        value = self._value(node)
        if isinstance(kind, Scalar) and isinstance(to, Scalar) and to.kind != "void":
            changes = kind.kind != to.kind and not self.typed.is_literal(node)
            return _macro("SG_COUNT", c_ast.ID("SG_N_CONVERT"), value) if changes else value
        return value

    def _value(self, node: c_ast.Node) -> c_ast.Node:
        """The expression that replaces ``node`` where its value is wanted."""
        if self.typed.is_literal(node):
            return node
        if isinstance(node, c_ast.ID | c_ast.ArrayRef | c_ast.StructRef):
            return self._load(node)
        if isinstance(node, c_ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, c_ast.BinaryOp):
            return self._binary(node)
        if isinstance(node, c_ast.Assignment):
            return self._assignment(node)
        if isinstance(node, c_ast.TernaryOp):
            kind = self.typed.type_of(node)
            ways = self._converted(node.iftrue, kind), self._converted(node.iffalse, kind)
            return c_ast.TernaryOp(self._decision(node.cond), *ways)
        if isinstance(node, c_ast.Cast):
            return c_ast.Cast(node.to_type, self._converted(node.expr, self.typed.type_of(node)))
        if isinstance(node, c_ast.FuncCall):
            return self._call(node)
        if isinstance(node, c_ast.ExprList):
            return c_ast.ExprList([self._value(item) for item in node.exprs])
        raise refuse(node, f"a {type(node).__name__} in an expression")

    def _place(self, node: c_ast.Node) -> c_ast.Node:
        """The lvalue that replaces ``node`` where it is written or its address is taken."""
        if isinstance(node, c_ast.ArrayRef):
            return c_ast.ArrayRef(self._value(node.name), self._value(node.subscript))
        if isinstance(node, c_ast.StructRef):
            base = self._value(node.name) if node.type == "->" else self._place(node.name)
            return c_ast.StructRef(base, node.type, node.field)
        if isinstance(node, c_ast.UnaryOp) and node.op == "*":
            return c_ast.UnaryOp("*", self._value(node.expr))
        return node if isinstance(node, c_ast.ID) else self._value(node)

    def _counts_access(self, node: c_ast.Node) -> bool:
        kind = self.typed.type_of(node)
        return self.typed.reads_memory(node) and not isinstance(kind, Array | Record)

    def _load(self, node: c_ast.Node) -> c_ast.Node:
        place = self._place(node)
        return _macro("SG_LOAD", place) if self._counts_access(node) else place

    def _unary(self, node: c_ast.UnaryOp) -> c_ast.Node:
        if node.op == "*":
            return self._load(node)
        if node.op == "&":
            return c_ast.UnaryOp("&", self._place(node.expr))
        if node.op == "!":
            return _macro("SG_NOT", self._value(node.expr))
        if node.op in ("++", "--", "p++", "p--"):
            changed = c_ast.UnaryOp(node.op, self._place(node.expr))
            return self._changing(node.expr, "SG_ADD", changed)
        result = c_ast.UnaryOp(node.op, self._value(node.expr))
        return result if node.op == "+" else _macro("SG_NEG", result)

    def _changing(self, target: c_ast.Node, macro: str, change: c_ast.Node) -> c_ast.Node:
        """``a op= b``: its value passes through the macros of the load, operation and store."""
        result = _macro(macro, change)
        if self._counts_access(target):
            result = _macro("SG_STORE", _macro("SG_LOAD", result))
        return result

    def _binary(self, node: c_ast.BinaryOp) -> c_ast.Node:
        if node.op in LOGICAL:
            name = "SG_AND" if node.op == "&&" else "SG_OR"
            return _macro(name, self._truth(node.left), self._truth(node.right))
        left, right = self._operand(node.left, node.right), self._operand(node.right, node.left)
        if node.op in _TESTS:
            return _macro(_TESTS[node.op], left, right)
        return _macro(_MACROS[node.op], c_ast.BinaryOp(node.op, left, right))

    def _operand(self, node: c_ast.Node, partner: c_ast.Node) -> c_ast.Node:
        """An operand; an integer beside a real is converted."""
        other = self.typed.type_of(partner)
        mixed = isinstance(other, Scalar) and other.is_real
        return self._converted(node, other) if mixed else self._value(node)

    def _assignment(self, node: c_ast.Assignment) -> c_ast.Node:
        kind = self.typed.type_of(node.lvalue)
        place = self._place(node.lvalue)
        if isinstance(kind, Record):
            return _copy(kind, c_ast.Assignment("=", place, self._value(node.rvalue)))
        value = self._converted(node.rvalue, kind)
        change = c_ast.Assignment(node.op, place, value)
        if node.op != "=":
            return self._changing(node.lvalue, _MACROS[node.op[:-1]], change)
        return _macro("SG_STORE", change) if self._counts_access(node.lvalue) else change

    def _call(self, node: c_ast.FuncCall) -> c_ast.Node:
        name = node.name.name
        given = node.args.exprs if node.args is not None else []
        wanted = self.typed.unit.prototypes[name].parameters
        arguments = []
        for argument, kind in zip_longest(given, wanted[: len(given)]):
            if isinstance(kind, Record):
                arguments.append(_copy(kind, self._value(argument)))
            elif kind is None:
                arguments.append(self._value(argument))
            else:
                arguments.append(self._converted(argument, kind))
        if self.typed.is_library(name) and name in MEMORY_FUNCTIONS:
            loads, stores = MEMORY_FUNCTIONS[name]
            size = self._size(given[-1])
            return _macro("SG_WORDS", _int(loads), _int(stores), size, _macro(name, *arguments))
        if self.typed.is_library(name):
            # isfinite and its like are macros of the real math.h; the compiler knows them so.
            called = _macro(f"__builtin_{name}", *arguments)
            what = c_ast.ID(f"SG_N_{MATH_CLASSES[name].upper()}")
            return _macro("SG_COUNT", what, called)
        return _macro("SG_CALL", _macro(name, *arguments))

    def _size(self, node: c_ast.Node) -> c_ast.Node:
        """A size as the target sees it, where pointers may be shorter than the host's."""
        typed = self.typed
        found = evaluate(node, typed.unit.known, typed.type_of, typed.size_operand).number
        return node if found is None or not typed.is_literal(node) else _int(found)


def _macro(name: str, *arguments: c_ast.Node) -> c_ast.FuncCall:
    return c_ast.FuncCall(c_ast.ID(name), c_ast.ExprList(list(arguments)))


def _int(number: int) -> c_ast.Constant:
    return c_ast.Constant("int", str(number))


def _copy(kind: CType, value: c_ast.Node) -> c_ast.Node:
    reals, others = elements(kind)
    return _macro("SG_COPY", _int(reals), _int(others), value)
