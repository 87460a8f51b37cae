"""Types of every expression of one function, and which names live in memory."""

from __future__ import annotations

from pycparser import c_ast

from servogen.wcet.ctype import (
    DOUBLE,
    FLOAT,
    INT,
    UNSIGNED,
    VOID,
    Array,
    CType,
    Function,
    Pointer,
    Record,
    Scalar,
    arithmetic,
    builtin,
    decay,
    promote,
    size_of,
)
from servogen.wcet.refusal import refuse
from servogen.wcet.unit import Unit, object_qualifiers

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
LOGICAL = ("&&", "||")

# Functions of math.h with a class of their own; any other function without a body is refused.
MATH_CLASSES = {
    **dict.fromkeys(("fabs", "fabsf"), "neg"),
    **dict.fromkeys(("sqrt", "sqrtf"), "sqrt"),
    **dict.fromkeys(("fmin", "fminf", "fmax", "fmaxf"), "cmp"),
    **dict.fromkeys(("floor", "floorf", "ceil", "ceilf"), "other_fp"),
    **dict.fromkeys(("isfinite", "isnan", "isinf", "signbit"), "other_fp"),
}


# Of string.h: (loads, stores) of a word of four bytes for each four bytes of their last argument.
MEMORY_FUNCTIONS = {"memset": (0, 1), "memcpy": (1, 1)}


class TypedFunction:
    """A function definition with the type of each expression in it.

    Attributes:
        node: the definition.
        signature: its type.
        parameters: names of its parameters.
        locals: declarations with their types, in order (scopes are flattened).
        in_memory: local names that are volatile or whose address is taken, so that reading one is a
            load.

    Raises:
        CountRefused: a name that hides another, a goto, a function pointer, an unknown name.
    """

    def __init__(self, unit: Unit, node: c_ast.FuncDef) -> None:
        self.unit = unit
        self.node = node
        self.signature = unit.prototypes[node.decl.name]
        listed = node.decl.type.args.params if node.decl.type.args is not None else []
        named = [p for p in listed if getattr(p, "name", None) is not None]
        self.parameters = tuple(p.name for p in named)
        self.locals: list[tuple[c_ast.Decl, CType]] = []
        self.in_memory: set[str] = set()
        self.in_memory |= {p.name for p in named if "volatile" in object_qualifiers(p.type)}
        self._types: dict[int, CType] = {}
        self._literal: dict[int, bool] = {}
        self._names = set(self.parameters)
        self._scopes: list[dict[str, CType]] = [
            dict(zip(self.parameters, self.signature.parameters, strict=False))
        ]
        self._statement(node.body)

    def type_of(self, node: c_ast.Node) -> CType:
        """Type of an expression of this function, arrays not yet decayed."""
        found = self._types.get(id(node))
        if found is None:
            raise refuse(node, f"a {type(node).__name__} without a known type")
        return found

    def reads_memory(self, node: c_ast.Node) -> bool:
        """True when the scalar lvalue ``node`` lives in memory and not in a register."""
        if isinstance(node, c_ast.ID):
            if node.name in self.unit.enums:
                return False
            return node.name in self.in_memory or not self.is_local(node.name)
        return isinstance(node, c_ast.ArrayRef | c_ast.StructRef) or (
            isinstance(node, c_ast.UnaryOp) and node.op == "*"
        )

    def is_literal(self, node: c_ast.Node) -> bool:
        """True for what every compiler folds: literals, enumeration constants, sizeof."""
        known = self._literal.get(id(node))
        if known is None:
            known = self._is_literal(node)
            if id(node) in self._types:  # of the function itself, which lives as long as this
                self._literal[id(node)] = known
        return known

    def _is_literal(self, node: c_ast.Node) -> bool:
        if isinstance(node, c_ast.Constant):
            return True
        if isinstance(node, c_ast.ID):
            return node.name in self.unit.enums and not self.is_local(node.name)
        if isinstance(node, c_ast.UnaryOp):
            return node.op == "sizeof" or (
                node.op in ("-", "+", "~", "!") and self.is_literal(node.expr)
            )
        if isinstance(node, c_ast.BinaryOp):
            return self.is_literal(node.left) and self.is_literal(node.right)
        return isinstance(node, c_ast.Cast) and self.is_literal(node.expr)

    def size_operand(self, node: c_ast.Node) -> int:
        """Bytes of the operand of sizeof."""
        if isinstance(node, c_ast.Typename):
            return self.unit.size_operand(node)
        return size_of(self.type_of(node))

    def is_library(self, name: str) -> bool:
        """True for a function of the C library that the counter knows the cost of."""
        return name not in self.unit.functions and (
            name in MATH_CLASSES or name in MEMORY_FUNCTIONS
        )

    def is_local(self, name: str) -> bool:
        """True for a parameter or a variable declared inside the function."""
        return name in self._names

    # -- statements ------------------------------------------------------------------------

    def _statement(self, node: c_ast.Node) -> None:
        if isinstance(node, c_ast.Goto | c_ast.Label):
            raise refuse(node, "goto")
        if isinstance(node, c_ast.Compound | c_ast.For):
            self._scopes.append({})
            for _, child in node.children():
                self._statement(child)
            self._scopes.pop()
        elif isinstance(node, c_ast.Decl):
            self._declaration(node)
        elif isinstance(node, _STATEMENTS):
            for _, child in node.children():
                self._statement(child)
        else:
            self._expression(node)

    def _declaration(self, node: c_ast.Decl) -> None:
        if any(node.name in scope for scope in self._scopes):
            raise refuse(node, f"the name '{node.name}' hides another of the same function")
        kind = self.unit.declared_type(node)
        if isinstance(kind, Function):
            raise refuse(node, "a function declared inside a function")
        self._scopes[-1][node.name] = kind
        self.locals.append((node, kind))
        self._names.add(node.name)
        if "volatile" in object_qualifiers(node.type):
            self.in_memory.add(node.name)  # another may change it at any time
        if node.init is not None:
            self._expression(node.init)

    # -- expressions -----------------------------------------------------------------------

    def _expression(self, node: c_ast.Node) -> CType:
        kind = self._infer(node)
        self._types[id(node)] = kind
        return kind

    def _infer(self, node: c_ast.Node) -> CType:
        if isinstance(node, c_ast.Constant):
            return _literal_type(node)
        if isinstance(node, c_ast.ID):
            return self._name(node)
        if isinstance(node, c_ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, c_ast.BinaryOp):
            sides = self._expression(node.left), self._expression(node.right)
            return INT if node.op in COMPARISONS + LOGICAL else arithmetic(*sides)
        if isinstance(node, c_ast.Assignment):
            self._expression(node.rvalue)
            return self._expression(node.lvalue)
        if isinstance(node, c_ast.TernaryOp):
            self._expression(node.cond)
            then, other = self._expression(node.iftrue), self._expression(node.iffalse)
            return then if isinstance(then, Record) else arithmetic(then, other)
        if isinstance(node, c_ast.Cast):
            self._expression(node.expr)
            return self.unit.resolve(node.to_type)
        if isinstance(node, c_ast.ArrayRef):
            self._expression(node.subscript)
            return self._pointee(node, self._expression(node.name))
        if isinstance(node, c_ast.StructRef):
            return self._member(node)
        if isinstance(node, c_ast.FuncCall):
            return self._call(node)
        if isinstance(node, c_ast.ExprList | c_ast.InitList):
            kinds = [self._expression(e) for e in node.exprs]
            return kinds[-1] if kinds else VOID
        if isinstance(node, c_ast.NamedInitializer):
            return self._expression(node.expr)
        raise refuse(node, f"a {type(node).__name__}")

    def _name(self, node: c_ast.ID) -> CType:
        for scope in reversed(self._scopes):
            if node.name in scope:
                return scope[node.name]
        if node.name in self.unit.enums:
            return INT
        if node.name in self.unit.globals:
            return self.unit.globals[node.name].type
        if node.name in self.unit.prototypes:
            raise refuse(node, f"the function '{node.name}' used as a pointer")
        raise refuse(node, f"the name '{node.name}' is not declared")

    def _unary(self, node: c_ast.UnaryOp) -> CType:
        if node.op == "sizeof":
            if not isinstance(node.expr, c_ast.Typename):
                self._expression(node.expr)
            return UNSIGNED
        kind = self._expression(node.expr)
        if node.op == "&":
            if isinstance(node.expr, c_ast.ID):
                self.in_memory.add(node.expr.name)
            return Pointer(kind)
        if node.op == "*":
            return self._pointee(node, kind)
        if node.op == "!":
            return INT
        if node.op in ("-", "+", "~") and isinstance(kind, Scalar):
            return promote(kind)
        return kind

    def _pointee(self, node: c_ast.Node, kind: CType) -> CType:
        pointer = decay(kind)
        if not isinstance(pointer, Pointer):
            raise refuse(node, "what is indexed or dereferenced is no pointer")
        return pointer.target

    def _member(self, node: c_ast.StructRef) -> CType:
        base = self._expression(node.name)
        record = self._pointee(node, base) if node.type == "->" else base
        if not isinstance(record, Record) or node.field.name not in (record.members or {}):
            raise refuse(node, f"no member '{node.field.name}' is known")
        return (record.members or {})[node.field.name]

    def _call(self, node: c_ast.FuncCall) -> CType:
        for argument in node.args.exprs if node.args is not None else []:
            self._expression(argument)
        name = node.name.name if isinstance(node.name, c_ast.ID) else None
        if name is None or any(name in scope for scope in self._scopes):
            raise refuse(node, "a call through a function pointer")
        if name not in self.unit.prototypes:
            if name in self.unit.globals:
                raise refuse(node, "a call through a function pointer")
            raise refuse(node, f"the function '{name}' is not declared")
        return self.unit.prototypes[name].result


_STATEMENTS = (
    c_ast.If,
    c_ast.While,
    c_ast.DoWhile,
    c_ast.Switch,
    c_ast.Case,
    c_ast.Default,
    c_ast.Return,
    c_ast.Break,
    c_ast.Continue,
    c_ast.EmptyStatement,
    c_ast.DeclList,
)


def _literal_type(node: c_ast.Constant) -> CType:
    if node.type == "string":
        return Array(Scalar("int", 1), len(node.value) - 1)
    if node.type == "char":
        return INT
    if node.type == "float" or (node.type == "double" and node.value[-1] in "fF"):
        return FLOAT
    if "double" in node.type:
        return DOUBLE
    return builtin(node.type.split()) or INT
