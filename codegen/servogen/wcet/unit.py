"""One translation unit: its types, enumeration constants, globals and functions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pycparser import c_ast

from servogen.wcet.constants import UNKNOWN, Value, evaluate, named_bound
from servogen.wcet.ctype import (
    INT,
    Array,
    CType,
    Function,
    Pointer,
    Record,
    Scalar,
    builtin,
    decay,
    size_of,
)
from servogen.wcet.refusal import refuse


@dataclass(frozen=True)
class Global:
    """A file-scope object: its type, whether other units see it, whether this one stores it."""

    type: CType
    constant: bool
    external: bool
    defined: bool


class Unit:
    """Declarations of one parsed file, in order of appearance.

    Raises:
        CountRefused: a type that the emitted C does not use (bit fields, unknown names).
    """

    def __init__(self, source: Path, tree: c_ast.FileAST) -> None:
        self.source = source
        self.tree = tree
        self.typedefs: dict[str, CType] = {}
        self.records: dict[str, Record] = {}
        self.enums: dict[str, int] = {}
        self.globals: dict[str, Global] = {}
        self.constants: dict[str, Value] = {}
        self.prototypes: dict[str, Function] = {}
        self.functions: dict[str, c_ast.FuncDef] = {}
        for node in tree.ext:
            self._declare(node)

    def _declare(self, node: c_ast.Node) -> None:
        if isinstance(node, c_ast.Typedef):
            self.typedefs[node.name] = self.resolve(node.type)
        elif isinstance(node, c_ast.FuncDef):
            self.functions[node.decl.name] = node
            self.prototypes[node.decl.name] = self._prototype(node.decl)
        elif isinstance(node, c_ast.Decl):
            self._declare_name(node)

    def _declare_name(self, node: c_ast.Decl) -> None:
        if isinstance(node.type, c_ast.FuncDecl):
            self.prototypes[node.name] = self._prototype(node)
            return
        kind = self.declared_type(node)
        if node.name is None:
            return
        constant = "const" in object_qualifiers(node.type)
        self.globals[node.name] = Global(
            kind,
            constant,
            external="static" not in node.storage,
            defined="extern" not in node.storage,
        )
        changing = "volatile" in object_qualifiers(node.type)
        if changing or node.init is None:
            return
        if constant and isinstance(kind, Scalar) and kind.kind == "int":
            self.constants[node.name] = self.literal(node.init)

    def _prototype(self, node: c_ast.Decl) -> Function:
        kind = self.resolve(node.type)
        assert isinstance(kind, Function)
        return kind

    def declared_type(self, node: c_ast.Decl) -> CType:
        """Type of a declaration; an open array takes its length from its initialiser."""
        kind = self.resolve(node.type)
        if isinstance(kind, Array) and kind.length is None and node.init is not None:
            if isinstance(node.init, c_ast.InitList):
                return Array(kind.element, len(node.init.exprs))
            raise refuse(node, "an array whose length is not a constant")
        return kind

    def resolve(self, node: c_ast.Node) -> CType:
        """Type that a declarator, specifier or type name denotes."""
        if isinstance(node, c_ast.TypeDecl | c_ast.Typename):
            return self.resolve(node.type)
        if isinstance(node, c_ast.IdentifierType):
            known = self.typedefs.get(node.names[0]) if len(node.names) == 1 else None
            found = known if known is not None else builtin(node.names)
            if found is None:
                raise refuse(node, f"the type '{' '.join(node.names)}' is not known")
            return found
        if isinstance(node, c_ast.PtrDecl):
            return Pointer(self.resolve(node.type))
        if isinstance(node, c_ast.ArrayDecl):
            return self._array(node)
        if isinstance(node, c_ast.Struct | c_ast.Union):
            return self._record(node)
        if isinstance(node, c_ast.Enum):
            self._enum(node)
            return INT
        if isinstance(node, c_ast.FuncDecl):
            listed = node.args.params if node.args is not None else []
            kinds = [self.resolve(p.type) for p in listed if not isinstance(p, c_ast.EllipsisParam)]
            taken = tuple(decay(k) for k in kinds if not _is_void(k))
            return Function(self.resolve(node.type), taken)
        raise refuse(node, f"a {type(node).__name__} as a type")

    def _array(self, node: c_ast.ArrayDecl) -> Array:
        if node.dim is None:
            return Array(self.resolve(node.type), None)
        length = self.literal(node.dim).number
        if length is None or length < 0:
            raise refuse(node, "an array whose length is not a constant")
        return Array(self.resolve(node.type), length)

    def _record(self, node: c_ast.Struct | c_ast.Union) -> Record:
        tag = node.name or f"anonymous at {node.coord}"
        record = self.records.setdefault(tag, Record(tag, isinstance(node, c_ast.Union)))
        if node.decls is not None and record.members is None:
            members: dict[str, CType] = {}
            for member in node.decls:
                if member.bitsize is not None or member.name is None:
                    raise refuse(member, "a bit field or an unnamed member")
                members[member.name] = self.resolve(member.type)
            record.members = members
        return record

    def _enum(self, node: c_ast.Enum) -> None:
        following = 0
        for item in node.values.enumerators if node.values is not None else []:
            if item.value is not None:
                number = self.literal(item.value).number
                if number is None:
                    raise refuse(item, "an enumeration value that is not a constant")
                following = number
            self.enums[item.name] = following
            following += 1

    def known(self, name: str) -> Value:
        """Value of an enumeration constant or of a constant file-scope integer."""
        if name in self.enums:
            cap = name if named_bound(name) else None
            return Value(self.enums[name], cap=cap)
        return self.constants.get(name, UNKNOWN)

    def literal(self, node: c_ast.Node) -> Value:
        """Value of a constant expression at file scope."""
        return evaluate(node, self.known, lambda _: Scalar("int", 8), self.size_operand)

    def size_operand(self, node: c_ast.Node) -> int:
        """Bytes of a type name; of an expression only the typing of its function knows."""
        if not isinstance(node, c_ast.Typename):
            raise refuse(node, "sizeof of an expression in a constant")
        return size_of(self.resolve(node))


def static_constants(node: c_ast.Node) -> list[c_ast.Decl]:
    """Declarations of static constant objects inside a function."""
    found: list[c_ast.Decl] = []
    for _, child in node.children():
        if isinstance(child, c_ast.Decl) and "static" in child.storage:
            if "const" in object_qualifiers(child.type):
                found.append(child)
        else:
            found.extend(static_constants(child))
    return found


def object_qualifiers(node: c_ast.Node) -> list[str]:
    """Qualifiers of the object itself: those of the elements of an array, not of a pointee."""
    while isinstance(node, c_ast.ArrayDecl):
        node = node.type
    quals: list[str] = node.quals
    return quals


def _is_void(kind: CType) -> bool:
    return isinstance(kind, Scalar) and kind.kind == "void"
