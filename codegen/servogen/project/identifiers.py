"""Names that may stand in C99 as they are: the project's name prefixes every emitted one."""

from __future__ import annotations

import re

C_KEYWORDS = frozenset(
    (
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double"),
        *("else", "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long"),
        *("register", "restrict", "return", "short", "signed", "sizeof", "static", "struct"),
        *("switch", "typedef", "union", "unsigned", "void", "volatile", "while"),
        *("_Bool", "_Complex", "_Imaginary"),
    )
)
MAX_LENGTH = 31  # what C99 guarantees to be told apart in an external name

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def is_c_identifier(name: str) -> bool:
    """Whether a name may prefix the emitted names: a C identifier, not a keyword, not reserved."""
    fits = _IDENTIFIER.fullmatch(name) is not None and len(name) <= MAX_LENGTH
    return fits and name not in C_KEYWORDS
