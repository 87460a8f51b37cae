"""What is known while one call of one function is counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from pycparser import c_ast

from servogen.wcet.constants import UNKNOWN, Value, evaluate, fits
from servogen.wcet.ctype import CType, Record, Scalar
from servogen.wcet.operations import Cost
from servogen.wcet.typed import TypedFunction


@dataclass(frozen=True)
class CallCost:
    """Cost of a callee for the given arguments, and the positions that decided it."""

    cost: Cost
    decisive: frozenset[int]


# (node of the call, name, arguments) -> cost of the callee
Callee = Callable[[c_ast.Node, str, Sequence[Value]], CallCost]


@dataclass
class Frame:
    """One activation.

    Attributes:
        typed: the function.
        callee: counts a called function.
        real_kind: ``float`` or ``double``, the package's scalar type.
        values: local integer variables in registers, as far as known.
        used: parameters and loop counters on whose values the cost depended so far.
        note: told of every loop that is counted, with the number of its turns.
    """

    typed: TypedFunction
    callee: Callee
    real_kind: str
    values: dict[str, Value] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    note: Callable[[c_ast.For, int], None] = lambda node, turns: None

    def value(self, node: c_ast.Node) -> Value:
        """Integer value of an expression as far as it is known here."""
        return evaluate(node, self._variable, self.typed.type_of, self.typed.size_operand)

    def decide(self, node: c_ast.Node) -> Value:
        """As ``value``, for a value that the cost is about to depend on."""
        found = self.value(node)
        self.used |= found.deps
        return found

    def combined(self, node: c_ast.Assignment) -> Value:
        """Value that ``a op= b`` leaves in a."""
        kind = self.typed.type_of(node.lvalue)
        twin = c_ast.BinaryOp(node.op[:-1], node.lvalue, node.rvalue, node.coord)
        return evaluate(
            twin,
            self._variable,
            lambda n: kind if n is twin else self.typed.type_of(n),
            self.typed.size_operand,
        )

    def assign(self, name: str, value: Value, kind: CType) -> None:
        """Record what a variable holds now; one in memory may change behind our back."""
        if name in self.typed.in_memory or not fits(value.number, kind):
            self.values.pop(name, None)
        else:
            self.values[name] = value

    def forget(self, names: set[str]) -> None:
        """Nothing is known any more of these variables."""
        for name in names:
            self.values.pop(name, None)

    def merge(self, one: dict[str, Value], other: dict[str, Value]) -> None:
        """After a decision: keep what both ways agree on."""
        self.values = {
            name: Value(value.number, value.deps | other[name].deps, value.cap)
            for name, value in one.items()
            if name in other and (other[name].number, other[name].cap) == (value.number, value.cap)
        }

    def is_record(self, node: c_ast.Node) -> bool:
        return isinstance(self.typed.type_of(node), Record)

    def is_real(self, node: c_ast.Node) -> bool:
        kind = self.typed.type_of(node)
        return isinstance(kind, Scalar) and kind.is_real

    def _variable(self, name: str) -> Value:
        found = self.values.get(name)
        return found if found is not None else self._file_scope(name)

    def _file_scope(self, name: str) -> Value:
        return UNKNOWN if self.typed.is_local(name) else self.typed.unit.known(name)
