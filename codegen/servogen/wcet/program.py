"""All translation units together: who calls whom, each call counted once per constant argument."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pycparser import c_ast

from servogen.wcet.constants import Value, fits
from servogen.wcet.ctype import CType, Record, Scalar, size_of
from servogen.wcet.frame import CallCost, Frame
from servogen.wcet.operations import Cost
from servogen.wcet.parse import parse, preprocess
from servogen.wcet.refusal import CountRefused, refuse
from servogen.wcet.typed import TypedFunction
from servogen.wcet.unit import Unit
from servogen.wcet.walk import count_body

_Known = tuple[int | None, str | None]


@dataclass
class _Counted:
    """A counted call: what the decisive arguments were, and what came out."""

    arguments: dict[int, _Known]
    result: CallCost


@dataclass(eq=False)
class Definition:
    """A function with a body, and the file it stands in."""

    unit: Unit
    node: c_ast.FuncDef
    typed: TypedFunction | None = None
    counted: list[_Counted] = field(default_factory=list)


class Program:
    """The parsed package.

    Args:
        source_files: C files.
        include_dirs: folders of their headers.
        defines: ``NAME`` or ``NAME=VALUE`` for the preprocessor.

    Attributes:
        definitions: every function, by number of its unit and name.
        turns: (file, line) of every loop counted so far -> numbers of turns it was seen to take.

    Raises:
        InputError: no gcc, or a missing file.
        CheckFailed: C that cannot be parsed.
    """

    def __init__(
        self,
        source_files: Sequence[Path],
        include_dirs: Sequence[Path],
        defines: Sequence[str] = (),
    ) -> None:
        self.units = [
            Unit(path, parse(path, preprocess(path, include_dirs, defines)))
            for path in source_files
        ]
        self.definitions: dict[tuple[int, str], Definition] = {}
        self._external: dict[str, Definition] = {}
        for number, unit in enumerate(self.units):
            for name, node in unit.functions.items():
                found = Definition(unit, node)
                self.definitions[number, name] = found
                if "static" not in node.decl.storage:
                    self._external.setdefault(name, found)
        self._active: list[Definition] = []
        self.turns: dict[tuple[str, int], set[int]] = {}

    @property
    def real_type(self) -> CType:
        """Type behind ``sg_real``; double where no unit has it."""
        for unit in self.units:
            if "sg_real" in unit.typedefs:
                return unit.typedefs["sg_real"]
        return Scalar("double", 8)

    def cost(self, entry_point: str) -> Cost:
        """Worst case of a call from outside, nothing known of its arguments.

        Raises:
            CountRefused: no such function, or something without a bound.
        """
        found = self.entry(entry_point)
        return self._count(found, [Value()] * len(_signature(found))).cost

    def stack_bytes(self, entry_point: str) -> int:
        """Bytes of the parameters and locals along the deepest chain of calls.

        Of the C objects, with natural alignment: the compiler adds return addresses, saved
        registers and temporaries, and takes away what it keeps in registers.
        """
        return self._stack(self.entry(entry_point))

    def type_bytes(self, name: str) -> int:
        """Size of a structure on the target, with natural alignment.

        Raises:
            CountRefused: no unit defines it.
        """
        for unit in self.units:
            kind = unit.typedefs.get(name)
            if isinstance(kind, Record) and kind.members is not None:
                return size_of(kind)
        raise CountRefused(f"cannot count: the structure '{name}' is not defined")

    def typed(self, found: Definition) -> TypedFunction:
        if found.typed is None:
            found.typed = TypedFunction(found.unit, found.node)
        return found.typed

    def entry(self, name: str) -> Definition:
        """The function that callers outside know by this name, or a static one of a single file.

        Raises:
            CountRefused: there is none.
        """
        own = [found for (_, called), found in self.definitions.items() if called == name]
        if name not in self._external and len(own) != 1:
            raise CountRefused(f"cannot count: the entry point '{name}' is not defined")
        return self._external.get(name, own[0])

    def lookup(self, unit: Unit, node: c_ast.Node, name: str) -> Definition:
        """The function that a call of ``name`` in ``unit`` means.

        Raises:
            CountRefused: it has no body here.
        """
        own = self.definitions.get((self.units.index(unit), name))
        found = own if own is not None else self._external.get(name)
        if found is None:
            raise refuse(node, f"the function '{name}' has no body here")
        return found

    def _count(self, found: Definition, arguments: Sequence[Value]) -> CallCost:
        for earlier in found.counted:
            if all(
                (arguments[i].number, arguments[i].cap) == k for i, k in earlier.arguments.items()
            ):
                return earlier.result
        typed = self.typed(found)

        def callee(node: c_ast.Node, name: str, values: Sequence[Value]) -> CallCost:
            wanted = self.lookup(found.unit, node, name)
            if wanted in self._active:
                raise refuse(node, f"the function '{name}' calls itself")
            return self._count(wanted, values)

        real = self.real_type
        kind = real.kind if isinstance(real, Scalar) else "double"
        frame = Frame(typed, callee, kind, note=self._note)
        known = _parameters(typed, arguments)
        frame.values.update({n: v for n, v in known.items() if n not in typed.in_memory})
        self._active.append(found)
        cost = Cost()
        count_body(frame, cost)
        self._active.pop()
        decisive = frozenset(i for i, n in enumerate(typed.parameters) if n in frame.used)
        result = CallCost(cost, decisive)
        key = {i: (arguments[i].number, arguments[i].cap) for i in decisive}
        found.counted.append(_Counted(key, result))
        return result

    def _note(self, node: c_ast.For, turns: int) -> None:
        place = (str(node.coord.file), int(node.coord.line))
        self.turns.setdefault(place, set()).add(turns)

    def _stack(self, found: Definition) -> int:
        if found in self._active:
            raise refuse(found.node, f"the function '{found.node.decl.name}' calls itself")
        typed = self.typed(found)
        own = sum(max(4, size_of(kind)) for kind in typed.signature.parameters)
        for declaration, kind in typed.locals:
            if "static" not in declaration.storage:
                own += -(-size_of(kind) // 4) * 4
        self._active.append(found)
        names = [n for n in called_names(found.node) if not typed.is_library(n.name.name)]
        below = [self._stack(self.lookup(found.unit, n, n.name.name)) for n in names]
        self._active.pop()
        return own + max(below, default=0)


def called_names(node: c_ast.Node) -> list[c_ast.FuncCall]:
    """Calls inside a function, the first of each name, in order of appearance."""
    found: dict[str, c_ast.FuncCall] = {}

    def visit(item: c_ast.Node) -> None:
        if isinstance(item, c_ast.FuncCall) and isinstance(item.name, c_ast.ID):
            found.setdefault(item.name.name, item)
        for _, child in item.children():
            visit(child)

    visit(node)
    return list(found.values())


def _signature(found: Definition) -> tuple[CType, ...]:
    return found.unit.prototypes[found.node.decl.name].parameters


def _parameters(typed: TypedFunction, arguments: Sequence[Value]) -> dict[str, Value]:
    """What the parameters hold; also an unknown one is named, so that its use is noticed."""
    known = {}
    for name, kind, value in zip(
        typed.parameters, typed.signature.parameters, arguments, strict=False
    ):
        number = value.number if fits(value.number, kind) else None
        known[name] = Value(number, frozenset({name}), value.cap if number is not None else None)
    return known
