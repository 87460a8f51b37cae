"""From a C file to pycparser's tree: preprocess with gcc, keep the line markers."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pycparser import c_ast, c_parser

from servogen.errors import CheckFailed, InputError
from servogen.wcet.headers import HEADERS

# Numbers between braces after a bracketed dimension: the values of a table. Parsing them costs
# more than the rest of the package, and only the declared dimension matters to a count.
_TABLE = re.compile(r"(\[[^\]=;{}]+\]\s*)=\s*\{([\s0-9a-fA-FxXpPuUlL.,+\-{}]*)\}\s*;")
_LARGE = 400  # characters; a local array that is set to values stays far below
_PLAIN = ("__attribute__(x)=", "__extension__=", "__inline=inline", "__restrict=restrict")


def preprocess(source: Path, include_dirs: Sequence[Path], defines: Sequence[str] = ()) -> str:
    """Text of ``source`` after gcc's preprocessor, with small standard headers of our own.

    Raises:
        InputError: gcc is not on the PATH, or the file is missing.
        CheckFailed: the preprocessor rejects the file.
    """
    if shutil.which("gcc") is None:
        raise InputError(None, "gcc", "missing", "a C compiler on the PATH")
    if not source.is_file():
        raise InputError(source, "source", "missing", "a C file to count")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in HEADERS.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        command = ["gcc", "-E", "-std=c99", "-nostdinc", "-isystem", folder]
        command += [f"-D{d}" for d in (*_PLAIN, *defines)]
        command += [f"-I{d}" for d in include_dirs]
        done = subprocess.run([*command, str(source)], capture_output=True, text=True, check=False)
    if done.returncode:
        first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip())
        raise CheckFailed(f"{source}: gcc cannot preprocess it: {first}")
    return done.stdout


def parse(source: Path, text: str, keep_tables: bool = False) -> c_ast.FileAST:
    """Tree of preprocessed ``text``; without the values of large tables unless they are wanted.

    Raises:
        CheckFailed: the text is not C99 as pycparser understands it.
    """
    try:
        return c_parser.CParser().parse(text if keep_tables else _slim(text), str(source))
    except c_parser.ParseError as error:
        raise CheckFailed(f"{source}: cannot be read as C99: {error}") from error


def _slim(text: str) -> str:
    def shorten(found: re.Match[str]) -> str:
        if len(found[2]) < _LARGE:
            return found[0]
        return found[1] + "\n" * found[0][len(found[1]) :].count("\n") + ";"

    return _TABLE.sub(shorten, text)
