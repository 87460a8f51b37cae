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
C_HEADERS = frozenset(
    (
        *("assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits"),
        *("locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio"),
        *("stdlib", "string", "tgmath", "time", "wchar", "wctype"),
    )
)
# The state is <name>_t: these are types of the standard library's, or of POSIX's.
C_TYPES = frozenset(
    (
        *("size", "ssize", "ptrdiff", "wchar", "wint", "wctype", "wctrans", "mbstate", "fpos"),
        *("div", "ldiv", "lldiv", "imaxdiv", "time", "clock", "fenv", "fexcept", "float", "double"),
        *("sig_atomic", "off", "mode", "pid", "uid", "gid", "dev", "ino", "intmax", "uintmax"),
        *(f"{sign}int{kind}{bits}" for sign in ("", "u") for kind in ("", "_least", "_fast")
          for bits in (8, 16, 32, 64)),
        *("intptr", "uintptr"),
    )
)  # fmt: skip
RUNTIME_PREFIX = "sg"  # of the names and files in c_runtime/
MAX_LENGTH = 31  # what C99 guarantees to be told apart in an external name

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def is_c_identifier(name: str) -> bool:
    """Whether a name is a C identifier of reasonable length, and no keyword."""
    fits = _IDENTIFIER.fullmatch(name) is not None and len(name) <= MAX_LENGTH
    return fits and name not in C_KEYWORDS


def is_free_prefix(name: str) -> bool:
    """Whether the emitted names and files (``<name>.h``, ``<name>_step``) can begin with it.

    A file called math.h beside the sources would be found instead of the library's own, and a
    project called size would define size_t.
    """
    lower = name.lower()  # some file systems do not tell cases apart
    own = lower == RUNTIME_PREFIX or lower.startswith(RUNTIME_PREFIX + "_")
    return is_c_identifier(name) and lower not in C_HEADERS | C_TYPES and not own
