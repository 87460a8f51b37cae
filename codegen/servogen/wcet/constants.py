"""Integer values known while counting, and the evaluation of C expressions over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pycparser import c_ast

from servogen.wcet.ctype import CType, Scalar

# Enumeration constants with these endings bound loops whose turns are told apart in a count: the
# iterations of a solver, whose number may be traded for time, and the levels of a search tree.
CAP_SUFFIX = "_ITERATION_CAP"
DEPTH_SUFFIX = "_TREE_DEPTH"


def named_bound(name: str) -> bool:
    """True for the name of a bound whose turns are told apart."""
    return name.endswith((CAP_SUFFIX, DEPTH_SUFFIX))


@dataclass(frozen=True)
class Value:
    """An integer as far as it is known.

    Attributes:
        number: the value, or None.
        deps: parameters and loop counters it was computed from.
        cap: name of the iteration cap or tree depth whose value this is, unchanged.
    """

    number: int | None = None
    deps: frozenset[str] = frozenset()
    cap: str | None = None


UNKNOWN = Value()

_ARITHMETIC: dict[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "<<": lambda a, b: a << b,
    ">>": lambda a, b: a >> b,
    "&": lambda a, b: a & b,
    "|": lambda a, b: a | b,
    "^": lambda a, b: a ^ b,
    "<": lambda a, b: int(a < b),
    "<=": lambda a, b: int(a <= b),
    ">": lambda a, b: int(a > b),
    ">=": lambda a, b: int(a >= b),
    "==": lambda a, b: int(a == b),
    "!=": lambda a, b: int(a != b),
}


def integer_literal(text: str) -> int:
    """Value of a C integer literal with its suffix."""
    digits = text.rstrip("uUlL")
    if len(digits) > 1 and digits[0] == "0" and digits[1] not in "xXbB":
        return int(digits, 8)
    return int(digits, 0)


def evaluate(
    node: c_ast.Node,
    variable: Callable[[str], Value],
    type_of: Callable[[c_ast.Node], CType],
    size: Callable[[c_ast.Node], int],
) -> Value:
    """Value of an integer expression.

    Args:
        node: the expression.
        variable: what is known of an identifier (an enumeration constant, a variable).
        type_of: type of an expression; a result outside its type is unknown.
        size: operand of ``sizeof`` -> bytes.
    """

    def visit(n: c_ast.Node) -> Value:
        if isinstance(n, c_ast.Constant):
            return Value(integer_literal(n.value)) if "int" in n.type else UNKNOWN
        if isinstance(n, c_ast.ID):
            return variable(n.name)
        if isinstance(n, c_ast.Cast):
            inner = visit(n.expr)
            return inner if fits(inner.number, type_of(n)) else Value(None, inner.deps)
        if isinstance(n, c_ast.UnaryOp):
            return unary(n)
        if isinstance(n, c_ast.BinaryOp):
            return binary(n)
        if isinstance(n, c_ast.TernaryOp):
            chosen = visit(n.cond)
            if chosen.number is None:
                return Value(None, chosen.deps)
            branch = visit(n.iftrue if chosen.number else n.iffalse)
            return Value(branch.number, chosen.deps | branch.deps)
        return UNKNOWN

    def unary(n: c_ast.UnaryOp) -> Value:
        if n.op == "sizeof":
            return Value(size(n.expr))
        if n.op not in ("-", "+", "~", "!"):
            return UNKNOWN
        inner = visit(n.expr)
        if n.op == "+" or inner.number is None:
            return inner
        result = {"-": -inner.number, "~": ~inner.number, "!": int(not inner.number)}[n.op]
        return Value(result if fits(result, type_of(n)) else None, inner.deps)

    def binary(n: c_ast.BinaryOp) -> Value:
        left, right = visit(n.left), visit(n.right)
        deps = left.deps | right.deps
        if n.op in ("&&", "||"):
            decisive = int(n.op == "||")
            if left.number is not None and int(bool(left.number)) == decisive:
                return Value(decisive, left.deps)
            if left.number is None or right.number is None:
                return Value(None, deps)
            return Value(int(bool(right.number)), deps)
        if left.number is None or right.number is None:
            return Value(None, deps)
        result = _divide(n.op, left.number, right.number)
        return Value(result if fits(result, type_of(n)) else None, deps)

    return visit(node)


def _divide(op: str, a: int, b: int) -> int | None:
    """Binary operators, of which division truncates towards zero as C's does."""
    if op in ("<<", ">>") and not 0 <= b < 32:
        return None
    if op not in ("/", "%"):
        return _ARITHMETIC[op](a, b)
    if b == 0:
        return None
    quotient = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
    return quotient if op == "/" else a - quotient * b


def fits(number: int | None, kind: CType) -> bool:
    """True when the integer type holds the number, so that C computes just this value."""
    if number is None or not isinstance(kind, Scalar) or kind.kind != "int":
        return False
    bits = 8 * kind.bytes
    low, high = (-(1 << (bits - 1)), 1 << (bits - 1)) if kind.signed else (0, 1 << bits)
    return low <= number < high
