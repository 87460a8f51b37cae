"""Small C files, counted from their text and while they run."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "sil"))  # the small cascades

from servogen.wcet.dynamic import CountedLibrary, build_counted
from servogen.wcet.package import Count, count_package

PRELUDE = "typedef double sg_real;\n"


@pytest.fixture
def c_file(tmp_path: Path) -> Callable[[str], Path]:
    """Write C text to a new file ``unit<n>.c``; line 1 of it is the text's first line."""
    numbers: Iterator[int] = count()

    def write(text: str) -> Path:
        path = tmp_path / f"unit{next(numbers)}.c"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def counts(c_file: Callable[[str], Path]) -> Callable[..., Count]:
    """Static count of function ``f`` (or another) in C text."""

    def run(text: str, entry: str = "f", prelude: str = PRELUDE) -> Count:
        return count_package([c_file(prelude + text)], [], [entry]).entry_points[entry]

    return run


@pytest.fixture
def counted(c_file: Callable[[str], Path], tmp_path: Path) -> Callable[[str], CountedLibrary]:
    """The same text built to count while it runs."""

    def run(text: str, prelude: str = PRELUDE) -> CountedLibrary:
        source = c_file(prelude + text)
        return build_counted([source], [], tmp_path / source.stem)

    return run
