"""What the objects hold: names from outside, data that can be written; where tables stand."""

from __future__ import annotations

import re
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.evidence.tools import demand

# What C asks of a freestanding implementation too: compilers call it for loops that fill and copy.
ALLOWED = frozenset({"memset", "memcpy", "memmove"})
# Set by the linker or the compiler, for position-independent code.
_LINKER = frozenset({"_GLOBAL_OFFSET_TABLE_"})
_NUMBER = r"[-+]?[0-9.][0-9a-fA-FxXeEpP.+\-]*[fFuUlL]*"
_INITIALISER = re.compile(rf"=\s*\{{((?:\s*{_NUMBER}\s*,?)+)\}}")
LARGE = 8  # numbers; a larger initialiser is a table


def faults(package: CPackage, folder: Path) -> list[str]:
    """Of the objects that were last compiled in ``folder``.

    Raises:
        CheckFailed: nm cannot read them.
    """
    objects = [source.replace(".c", ".o") for source in package.sources]
    said = demand(["nm", *objects], "nm", folder)
    symbols = re.findall(r"^[0-9a-fA-F ]*\s([A-Za-z]) (\S+)$", said, flags=re.M)
    own = {name for kind, name in symbols if kind in "TR"}
    found = [
        f"{name} is called, which is no part of the package"
        for name in sorted({n for kind, n in symbols if kind == "U"} - own - ALLOWED - _LINKER)
    ]
    found += [
        f"{name} can be written and is global" for kind, name in symbols if kind in "dDbBcCsSgG"
    ]
    found += [
        f"{name} does not begin with {package.name}_"
        for name in sorted(own)
        if not name.startswith(f"{package.name}_")
    ]
    return found if own else ["the objects define nothing"]


def misplaced_tables(package: CPackage) -> list[str]:
    """Tables that do not stand in a ``_tables.h``, and declared ones that stand nowhere."""
    found = []
    for name, text in package.code.items():
        if not name.endswith("_tables.h"):
            for initialiser in _INITIALISER.findall(text):
                if len(initialiser.split(",")) > LARGE:
                    found.append(f"{name} holds a table of {len(initialiser.split(','))} numbers")
    for d in package.declarations:
        text = package.files.get(f"{d.prefix}_tables.h", "")
        for table in d.tables:
            if table.values.size and f" {d.prefix}_{table.name}[" not in text:
                found.append(f"the table {table.name} is not in {d.prefix}_tables.h")
    return found
