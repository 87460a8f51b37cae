"""The decisions of a C file, by name, and the file again with a probe in each of them.

gcov counts branches by line and does not say which way is which (gcc turns some conditions round,
even with -O0). So each decision is found in the syntax tree, and a twin of the file counts how
often it was true and how often false.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pycparser import c_ast, c_generator

from servogen.controllers.design import Declaration
from servogen.errors import CheckFailed
from servogen.wcet.parse import parse, preprocess

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
_DECIDING = (c_ast.If, c_ast.For, c_ast.While, c_ast.DoWhile, c_ast.TernaryOp)
_UNREAD = (c_ast.Switch, c_ast.Goto)


@dataclass(frozen=True, order=True)
class Decision:
    """One condition that the flow of control depends on, named without prefix and line.

    Attributes:
        where: kind of the controller (``mpc``), or name of a shared file (``sg_kernels.h``).
        function: without the controller's prefix.
        condition: as C, names without prefix; literals of the precision at hand.
        occurrence: 1 for the first decision of the function with this condition, 2, ...
    """

    where: str
    function: str
    condition: str
    occurrence: int


@dataclass(frozen=True)
class Site:
    """Where a decision stands in a translation unit: file, C function and line of the emitted C."""

    decision: Decision
    file: str
    function: str
    line: int


@dataclass(frozen=True)
class ProbedUnit:
    """A translation unit with probes.

    Attributes:
        name: its source file.
        sites: in the order of the probes' numbers.
        text: C of the twin; ``sg_probes_<index>`` holds (sites, 2) counts, [0] false, [1] true.
        faults: why branch coverage would not be MC/DC here; empty where it is.
        unused: inline functions that it includes and does not call; they have no code here.
    """

    name: str
    sites: tuple[Site, ...]
    text: str
    faults: tuple[str, ...]
    unused: tuple[str, ...]


def probe(source: Path, index: int, declarations: Sequence[Declaration]) -> ProbedUnit:
    """Read an emitted file with all that it includes and put a probe into every decision.

    Args:
        source: in a folder with the headers; numbers of its tables are kept.
        index: of the unit in its package; names the array of counts.

    Raises:
        CheckFailed: C that cannot be parsed, or a statement whose branches are not read here.
    """
    text = preprocess(source, [source.parent])
    tree = parse(source, text, keep_tables=True)
    walk = _Walk(_Names(declarations))
    functions = {n.decl.name: n for n in tree.ext if isinstance(n, c_ast.FuncDef)}
    compiled = _compiled(functions)
    for name, node in functions.items():
        if name in compiled:
            walk.function(node)
    array = f"sg_probes_{index}"
    head = (
        f"unsigned long {array}[{max(len(walk.sites), 1)}][2];\n"
        f"const unsigned long {array}_rows = {len(walk.sites)};\n"
        "static int sg_probe(int site, int way)\n"
        f"{{\n    {array}[site][way]++;\n    return way;\n}}\n"
    )
    body = c_generator.CGenerator().visit(tree)
    unused = tuple(sorted(functions.keys() - compiled))
    return ProbedUnit(source.name, tuple(walk.sites), head + body, tuple(walk.faults), unused)


def _compiled(functions: Mapping[str, c_ast.FuncDef]) -> set[str]:
    """Functions that the compiler makes code of: all but the inline ones that nothing calls."""
    waiting = [n for n, node in functions.items() if "inline" not in node.decl.funcspec]
    found: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            named = {n.name for n in _below(functions[name].body) if isinstance(n, c_ast.ID)}
            waiting += [called for called in named if called in functions]
    return found


class _Names:
    """C names as the list has them: the same for every prefix."""

    def __init__(self, declarations: Sequence[Declaration]) -> None:
        prefixes = sorted((d.prefix for d in declarations), key=len, reverse=True)
        either = "|".join(re.escape(p) for p in (*prefixes, *(p.upper() for p in prefixes)))
        self._prefix = re.compile(rf"\b(?:{either})_")
        self._kinds = [(d.prefix, d.kind) for p in prefixes for d in declarations if d.prefix == p]

    def where(self, file: str) -> str:
        stem = file.rpartition(".")[0]
        for prefix, kind in self._kinds:
            if stem == prefix or stem.startswith(f"{prefix}_"):
                return kind
        return file

    def short(self, text: str) -> str:
        return self._prefix.sub("", text)


@dataclass
class _Walk:
    """Numbers the decisions of one unit in the order of the text and changes the tree."""

    names: _Names
    sites: list[Site] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    _seen: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    _generator: c_generator.CGenerator = field(default_factory=c_generator.CGenerator)

    def function(self, node: c_ast.FuncDef) -> None:
        self._place = Path(node.decl.coord.file).name, node.decl.name
        self._visit(node.body, free=True)

    def _visit(self, node: c_ast.Node, free: bool) -> None:
        """``free``: a comparison here would not decide anything."""
        if isinstance(node, _UNREAD):
            raise CheckFailed(f"{self._at(node)}: branches of a {type(node).__name__} are not read")
        if isinstance(node, c_ast.BinaryOp):
            if node.op in ("&&", "||"):
                self.faults.append(f"{self._at(node)}: {node.op} joins two conditions")
            elif node.op in COMPARISONS and free:
                self.faults.append(
                    f"{self._at(node)}: a comparison decides nothing: {self._c(node)}"
                )
        deciding = isinstance(node, _DECIDING) and node.cond is not None
        if deciding:
            self._decide(node)
        for name, child in node.children():
            if not (deciding and name == "cond"):
                self._visit(child, free=True)

    def _decide(self, node: c_ast.Node) -> None:
        condition = node.cond
        file, function = self._place
        for inner in _below(condition):
            if isinstance(inner, c_ast.TernaryOp | c_ast.Assignment):
                self.faults.append(
                    f"{self._at(node)}: more than a comparison: {self._c(condition)}"
                )
        key = (
            self.names.where(file),
            self.names.short(function),
            self.names.short(self._c(condition)),
        )
        self._seen[key] += 1
        number = len(self.sites)
        self.sites.append(
            Site(Decision(*key, self._seen[key]), file, function, condition.coord.line)
        )
        self._visit(_core(condition), free=False)
        way = c_ast.BinaryOp("!=", condition, c_ast.Constant("int", "0"))
        site = c_ast.Constant("int", str(number))
        node.cond = c_ast.FuncCall(c_ast.ID("sg_probe"), c_ast.ExprList([site, way]))

    def _c(self, node: c_ast.Node) -> str:
        text: str = self._generator.visit(node)
        return text

    def _at(self, node: c_ast.Node) -> str:
        line = node.coord.line if node.coord is not None else "?"
        return f"{self._place[0]}:{line} ({self._place[1]})"


def _core(condition: c_ast.Node) -> c_ast.Node:
    """The condition without a negation around it."""
    while isinstance(condition, c_ast.UnaryOp) and condition.op == "!":
        condition = condition.expr
    return condition


def _below(node: c_ast.Node) -> Iterator[c_ast.Node]:
    for _, child in node.children():
        yield child
        yield from _below(child)
