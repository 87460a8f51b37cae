"""The one error of the counter: C that it cannot bound, named by file and line."""

from __future__ import annotations

from pycparser import c_ast

from servogen.errors import CheckFailed


class CountRefused(CheckFailed):
    """The emitted C holds something without a provable worst case (exit status 1)."""


def refuse(node: c_ast.Node, reason: str) -> CountRefused:
    """The error to raise for ``node``; file and line are those of the original source."""
    coord = node.coord
    where = f"{coord.file}:{coord.line}: " if coord is not None else ""
    return CountRefused(f"{where}cannot count: {reason}")
