"""Which members of a controller a function reads and writes, and whatever it calls.

Read from the syntax tree, without regard to what is decided where: what stands in the C counts, an
array as a whole. A pointer that may point to several members points to all of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from pycparser import c_ast

from servogen.wcet.ctype import Array, Pointer, decay
from servogen.wcet.program import Definition, Program
from servogen.wcet.refusal import refuse
from servogen.wcet.typed import TypedFunction
from servogen.wcet.unit import object_qualifiers

Place = tuple[str, ...]  # names of members, from the controller inwards; () is all of it
Places = frozenset[Place]
NOWHERE: Places = frozenset()


@dataclass(frozen=True)
class Accesses:
    """Members by their paths, ``fast.path_x``; the controller as a whole is the empty text."""

    reads: frozenset[str]
    writes: frozenset[str]


def accesses(program: Program, entry_point: str) -> Accesses:
    """What a call of the entry point may do to the object that its first parameter points to.

    Raises:
        CountRefused: a pointer goes where it cannot be followed, or a function has no body.
    """
    found = program.entry(entry_point)
    first = program.typed(found).parameters[:1]
    walk = _Walk(program)
    walk.call(found, {name: frozenset({()}) for name in first})
    return Accesses(_named(walk.reads), _named(walk.writes))


def shared(one: Accesses, other: Accesses) -> frozenset[str]:
    """Members that one of the two writes and the other writes or reads, as ``one`` names them; a
    structure holds its members."""
    return frozenset(
        mine
        for mine in one.reads | one.writes
        for theirs in other.reads | other.writes
        if (mine in one.writes or theirs in other.writes) and _overlap(mine, theirs)
    )


def _overlap(a: str, b: str) -> bool:
    return a == b or not a or not b or a.startswith(f"{b}.") or b.startswith(f"{a}.")


def _named(places: Iterable[Place]) -> frozenset[str]:
    return frozenset(".".join(place) for place in places)


@dataclass
class _Walk:
    program: Program
    reads: set[Place] = field(default_factory=set)
    writes: set[Place] = field(default_factory=set)
    _done: set[tuple[int, tuple[tuple[str, Places], ...]]] = field(default_factory=set)

    def call(self, found: Definition, pointers: dict[str, Places]) -> None:
        """Follow a function whose parameters point to these places; once for the same ones."""
        key = (id(found), tuple(sorted(pointers.items())))
        if key not in self._done:
            self._done.add(key)
            _Function(self, found, self.program.typed(found), dict(pointers)).follow()


@dataclass
class _Function:
    """One function with what its pointers may point to."""

    walk: _Walk
    found: Definition
    typed: TypedFunction
    pointers: dict[str, Places]

    def follow(self) -> None:
        """Until no pointer has gained a place: a loop's end comes before its beginning."""
        before = None
        while before != self.pointers:
            before = dict(self.pointers)
            self._statement(self.found.node.body)

    def _statement(self, node: c_ast.Node) -> None:
        if isinstance(node, c_ast.Decl):
            if node.init is not None:
                self._assign_pointer(node, node.name, self._value(node.init))
        elif isinstance(node, _EXPRESSIONS):
            self._value(node)
        else:
            for _, child in node.children():
                self._statement(child)

    def _value(self, node: c_ast.Node) -> Places:
        """Go through an expression whose value is used; where it points to, if it is a pointer."""
        if isinstance(node, c_ast.ID):
            return self.pointers.get(node.name, NOWHERE)
        if isinstance(node, c_ast.StructRef | c_ast.ArrayRef) or _is_dereference(node):
            places = self._lvalue(node)
            kind = self.typed.type_of(node)
            if not isinstance(kind, Array):
                self.walk.reads |= places
                self._no_pointer_kept(node, places, isinstance(kind, Pointer))
            return places if isinstance(kind, Array) else NOWHERE
        if isinstance(node, c_ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, c_ast.Assignment):
            return self._assignment(node)
        if isinstance(node, c_ast.FuncCall):
            self._call(node)
            return NOWHERE
        if isinstance(node, c_ast.TernaryOp):
            self._value(node.cond)
            return self._value(node.iftrue) | self._value(node.iffalse)
        value = NOWHERE.union(*(self._value(child) for _, child in node.children()))
        self._no_pointer_kept(node, value, isinstance(node, c_ast.InitList))
        return value

    def _unary(self, node: c_ast.UnaryOp) -> Places:
        if node.op == "&":
            return self._lvalue(node.expr)
        if node.op == "sizeof":
            return NOWHERE
        if node.op in ("++", "--", "p++", "p--"):
            self.walk.writes |= self._lvalue(node.expr)
        return self._value(node.expr)

    def _assignment(self, node: c_ast.Assignment) -> Places:
        value = self._value(node.rvalue)
        if isinstance(node.lvalue, c_ast.ID):
            self._assign_pointer(node, node.lvalue.name, value)
            return value
        places = self._lvalue(node.lvalue)
        self.walk.writes |= places
        if node.op != "=":
            self.walk.reads |= places
        pointer = isinstance(decay(self.typed.type_of(node.lvalue)), Pointer)
        self._no_pointer_kept(node, value, pointer)
        return NOWHERE

    def _assign_pointer(self, node: c_ast.Node, name: str, value: Places) -> None:
        if value:
            self.pointers[name] = self.pointers.get(name, NOWHERE) | value

    def _no_pointer_kept(self, node: c_ast.Node, value: Places, pointer: bool) -> None:
        if value and pointer:
            raise refuse(node, "a pointer into the controller that cannot be followed")

    def _lvalue(self, node: c_ast.Node) -> Places:
        """The places that an object is or is part of; its subscripts are values."""
        if isinstance(node, c_ast.ID):
            return self.pointers.get(node.name, NOWHERE)
        if isinstance(node, c_ast.ArrayRef):
            self._value(node.subscript)
            return self._base(node.name)
        if isinstance(node, c_ast.StructRef):
            base = self._value(node.name) if node.type == "->" else self._base(node.name)
            return frozenset((*place, node.field.name) for place in base)
        if isinstance(node, c_ast.UnaryOp) and node.op == "*":
            return self._value(node.expr)
        if isinstance(node, c_ast.Cast):
            return self._lvalue(node.expr)
        raise refuse(node, f"a {type(node).__name__} as the place of an object")

    def _base(self, node: c_ast.Node) -> Places:
        """What is indexed, or has a member: an object in place, or where a pointer points."""
        pointer = isinstance(self.typed.type_of(node), Pointer)
        return self._value(node) if pointer else self._lvalue(node)

    def _call(self, node: c_ast.FuncCall) -> None:
        given = [self._value(a) for a in (node.args.exprs if node.args is not None else [])]
        name = node.name.name
        if self.typed.is_library(name):
            self.walk.writes |= NOWHERE.union(*given)
            self.walk.reads |= NOWHERE.union(*given)
            return
        callee = self.walk.program.lookup(self.found.unit, node, name)
        result = isinstance(self.found.unit.prototypes[name].result, Pointer)
        self._no_pointer_kept(node, NOWHERE.union(*given), result)
        named = self.walk.program.typed(callee).parameters
        self.walk.call(callee, {n: v for n, v in zip(named, given, strict=False) if v})


def _is_dereference(node: c_ast.Node) -> bool:
    return isinstance(node, c_ast.UnaryOp) and node.op == "*"


_EXPRESSIONS = (
    c_ast.ID,
    c_ast.StructRef,
    c_ast.ArrayRef,
    c_ast.UnaryOp,
    c_ast.BinaryOp,
    c_ast.Assignment,
    c_ast.FuncCall,
    c_ast.TernaryOp,
    c_ast.Cast,
    c_ast.Constant,
    c_ast.ExprList,
)


def kept_outside(program: Program) -> list[str]:
    """Objects that outlive a call and can be written, other than the controller: nothing that is
    written to them is among the ``accesses``. ``file: name`` of each."""
    found = [
        f"{unit.source.name}: {name}"
        for unit in program.units
        for name, each in unit.globals.items()
        if not each.constant
    ]
    for definition in program.definitions.values():
        found += [
            f"{definition.unit.source.name}: {name} of {definition.node.decl.name}"
            for name in _static_variables(definition.node.body)
        ]
    return sorted(set(found))


def _static_variables(node: c_ast.Node) -> list[str]:
    found = []
    for _, child in node.children():
        if isinstance(child, c_ast.Decl) and "static" in child.storage:
            if "const" not in object_qualifiers(child.type):
                found.append(child.name)
        else:
            found += _static_variables(child)
    return found
