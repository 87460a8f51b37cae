"""G-code text to words, line by line.

gcodeparser turns single words into numbers here. Its line reader is not used: it drops lines
without a G, M or T (so modal moves), reads words inside parentheses, takes any word it does not
know as a parameter, and fails on numbers such as ``5.``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gcodeparser import parse_parameters

from servogen.errors import InputError
from servogen.paths.text import read_text

LETTERS = "G M F S T N X Y Z I J R"
_WORD = re.compile(r"([A-Z])([+-]?(?:\d+(?:\.\d*)?|\.\d+))")
_COMMENT = re.compile(r"\([^()]*\)")
_SPACE = re.compile(r"\s+")
_LONGEST = 40


@dataclass(frozen=True)
class Block:
    """One line: its number in the file (from 1) and its words in order."""

    line: int
    words: tuple[tuple[str, float], ...]

    @property
    def label(self) -> str:
        """The line's name in messages."""
        return f"line {self.line}"


def read_blocks(file: Path) -> Iterator[Block]:
    """Lines that hold words, without comments, ``%`` and deleted blocks (``/``).

    Raises:
        InputError: naming the line that cannot be read, or a word of a letter not in ``LETTERS``.
    """
    known = set(LETTERS.split())
    for number, raw in enumerate(read_text(file, "a G-code file").splitlines(), start=1):
        text = _SPACE.sub("", _COMMENT.sub("", raw).split(";")[0]).upper()
        if not text or text == "%" or text.startswith("/"):
            continue
        words = _words(text, file, f"line {number}")
        for letter, value in words:
            if letter not in known:
                expected = f"only words of a path: {LETTERS}"
                raise InputError(file, f"line {number}", f"{letter}{value:g}", expected)
        yield Block(number, words)


def _words(text: str, file: Path, where: str) -> tuple[tuple[str, float], ...]:
    words: list[tuple[str, float]] = []
    at = 0
    while at < len(text):
        match = _WORD.match(text, at)
        if match is None or len(match[2]) > _LONGEST:
            rest = text[at : at + _LONGEST]
            expected = "words of a letter and a number, and comments in () or after ;"
            raise InputError(file, where, f'unreadable at "{rest}"', expected)
        letter, number = match.groups()
        value = parse_parameters(letter + number + ("0" if number.endswith(".") else ""))[letter]
        words.append((letter, float(value)))
        at = match.end()
    return tuple(words)
