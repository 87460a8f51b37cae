"""What the emitted C tells TI's compiler, held to what the C does.

TI's compiler is not at hand, so its text is judged: preprocessed with its macros, every
MUST_ITERATE has to stand right before a loop and cover the turns that the counter sees it take,
every DATA_ALIGN right before the object that it names.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pycparser import c_ast

from servogen.evidence.tools import run_tool
from servogen.wcet.parse import parse, preprocess
from servogen.wcet.program import Program

# As TI's C6000 compiler 8.3 defines them.
TI_MACROS = ("__TI_COMPILER_VERSION__=8003000", "_TMS320C6X=1", "__TI_EABI__=1")
_ITERATE = re.compile(r"MUST_ITERATE\((\d+)(?:, (\d+))?\)")
_ALIGN = re.compile(r"DATA_ALIGN\((\w+), (\d+)\)")

Place = tuple[str, int]
Turns = Mapping[Place, set[int]]


@dataclass
class Told:
    """``loops``: that an entry point reaches; ``tables``: constant arrays of the sources."""

    faults: list[str] = field(default_factory=list)
    loops: int = 0
    loops_told: int = 0
    tables: int = 0
    tables_aligned: int = 0


def examine_pragmas(sources: Sequence[Path], folder: Path, entry_points: Sequence[str]) -> Told:
    """Judge the pragmas of a package written to ``folder``.

    Raises:
        CheckFailed: the C cannot be parsed.
        CountRefused: a loop without a bound.
    """
    program = Program(sources, [folder])  # as it is compiled elsewhere: same loops, same lines
    for name in entry_points:
        program.cost(name)
    told = Told(loops=len(program.turns))
    seen: set[Place] = set()
    for source in sources:
        refused = _still_compiles(source, folder)
        if refused:
            told.faults += refused
            continue
        tree = parse(source, preprocess(source, [folder], TI_MACROS))
        for pragma, following in _pragmas(tree):
            told.faults += _judge(pragma, following, program.turns, seen)
        _count_tables(tree, told)
    told.faults = list(dict.fromkeys(told.faults))  # of a header, once
    told.loops_told = len(seen & set(program.turns))
    if not told.loops_told:
        told.faults.append("no loop is told to TI's compiler")
    if told.tables_aligned < told.tables:
        told.faults.append(f"{told.tables - told.tables_aligned} tables are not aligned")
    return told


def _pragmas(node: c_ast.Node) -> Iterator[tuple[c_ast.Pragma, c_ast.Node | None]]:
    """Every pragma with what stands right behind it in its block."""
    items = [child for _, child in node.children()]
    for position, item in enumerate(items):
        if isinstance(item, c_ast.Pragma):
            yield item, items[position + 1] if position + 1 < len(items) else None
        yield from _pragmas(item)


def _judge(
    pragma: c_ast.Pragma, following: c_ast.Node | None, turns: Turns, seen: set[Place]
) -> list[str]:
    place = f"{Path(str(pragma.coord.file)).name}:{pragma.coord.line}"
    iterate, align = _ITERATE.fullmatch(pragma.string), _ALIGN.fullmatch(pragma.string)
    if align is not None:
        named = isinstance(following, c_ast.Decl) and following.name == align[1]
        return [] if named else [f"{place}: {pragma.string} is not before what it names"]
    if iterate is None:
        return [f"{place}: the pragma {pragma.string} is not one of ours"]
    if not isinstance(following, c_ast.For):
        return [f"{place}: {pragma.string} is not before a loop"]
    where = (str(following.coord.file), int(following.coord.line))
    seen.add(where)
    least, most = int(iterate[1]), int(iterate[2]) if iterate[2] else None
    taken = turns.get(where, set()) | ({1} if _may_leave(following.stmt) else set())
    wrong = sorted(n for n in taken if n < least or (most is not None and n > most))
    return [f"{place}: {pragma.string}, but the loop turns {n} times" for n in wrong]


def _may_leave(node: c_ast.Node, inner: bool = False) -> bool:
    """Whether the loop with this body may end before its bound."""
    if isinstance(node, c_ast.Return) or (isinstance(node, c_ast.Break) and not inner):
        return True
    within = inner or isinstance(node, c_ast.For | c_ast.Switch)
    return any(_may_leave(child, within) for _, child in node.children())


def _count_tables(tree: c_ast.FileAST, told: Told) -> None:
    """Constant arrays at file scope, and those with an alignment before them."""
    for before, item in zip([None, *tree.ext], tree.ext, strict=False):
        if not (isinstance(item, c_ast.Decl) and isinstance(item.type, c_ast.ArrayDecl)):
            continue
        if "const" not in item.quals + item.type.type.quals or "extern" in item.storage:
            continue
        told.tables += 1
        told.tables_aligned += isinstance(before, c_ast.Pragma)


def _still_compiles(source: Path, folder: Path) -> list[str]:
    """gcc ignores the pragmas; what stands around them has to be C all the same."""
    macros = [f"-D{m}" for m in TI_MACROS]
    flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-Wno-unknown-pragmas"]
    done = run_tool(["gcc", *flags, *macros, f"-I{folder}", "-fsyntax-only", source], folder)
    if done.returncode == 0:
        return []
    first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr[:200])
    return [f"with TI's macros: {first.replace(f'{folder}/', '')}"]
