"""Operations counted while the emitted C runs: the check that the static count holds.

gcc alone suffices: the C is parsed, each operation wrapped in a counting macro, written back and
compiled. What is counted is what ran, with reals and integers told apart by the compiler.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.errors import CheckFailed, InputError
from servogen.resources import resource_dir
from servogen.wcet.instrument import instrument, prelude
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.parse import parse, preprocess
from servogen.wcet.turns import watched_bounds
from servogen.wcet.unit import Unit

COUNTING_FLAGS = ("-std=gnu11", "-O1", "-ffp-contract=off", "-w")
_TALLY = """\
unsigned long long sg_tally[SG_N_CLASSES];
unsigned long long sg_turns[SG_N_TURNS + 1];
"""


def counting_dir() -> Path:
    """Where ``sg_counting.h`` is."""
    return resource_dir("c_runtime") / "counting"


class CountedLibrary:
    """A shared library of the package that counts.

    Attributes:
        path: the library; cffi may open it as well, by its path.
        functions: the same, open in ctypes.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.functions = ctypes.CDLL(str(path))
        self._tally = (ctypes.c_ulonglong * len(CLASSES)).in_dll(self.functions, "sg_tally")

    def reset(self) -> None:
        """Set all counters to zero."""
        ctypes.memset(self._tally, 0, ctypes.sizeof(self._tally))

    def read(self) -> OperationCounts:
        """Operations since the last reset."""
        return OperationCounts(*(int(n) for n in self._tally))


@dataclass(frozen=True)
class CountedSources:
    """Counting twins of a package's sources: ``files`` to compile, and the named bounds of which
    the array ``sg_turns`` holds, in this order, how many turns their longest loop did."""

    files: tuple[Path, ...]
    watched: tuple[str, ...]


def write_counted_sources(
    source_files: Sequence[Path],
    include_dirs: Sequence[Path],
    folder: Path,
    defines: Sequence[str] = (),
) -> CountedSources:
    """Write the counting twin of each source, and the counters, into ``folder``.

    The twins hold everything they include; to compile them, ``counting_dir()`` must be on the
    include path and gcc must allow C11 with GNU extensions.

    Raises:
        CheckFailed: C that cannot be parsed or counted.
        InputError: no gcc, or a missing file.
    """
    folder.mkdir(parents=True, exist_ok=True)
    texts = [preprocess(source, include_dirs, defines) for source in source_files]
    units = [
        Unit(source, parse(source, text, keep_tables=True))
        for source, text in zip(source_files, texts, strict=True)
    ]
    watched = watched_bounds(units)
    written = [folder / "sg_tally.c"]
    written[0].write_text(f'{prelude(watched)}#include "sg_counting.h"\n{_TALLY}', encoding="utf-8")
    for source, unit in zip(source_files, units, strict=True):
        twin = folder / f"counted_{source.name}"
        twin.write_text(instrument(unit, watched), encoding="utf-8")
        written.append(twin)
    return CountedSources(tuple(written), watched)


def build_counted(
    source_files: Sequence[Path],
    include_dirs: Sequence[Path],
    folder: Path,
    defines: Sequence[str] = (),
) -> CountedLibrary:
    """Compile the counting twins into a shared library in ``folder``.

    Raises:
        CheckFailed: C that cannot be parsed, counted or compiled.
        InputError: no gcc, or a missing file.
    """
    sources = write_counted_sources(source_files, include_dirs, folder, defines).files
    library = folder / "counted.so"
    gcc = shutil.which("gcc")
    if gcc is None:
        raise InputError(None, "gcc", "missing", "a C compiler on the PATH")
    command = [gcc, *COUNTING_FLAGS, "-shared", "-fPIC", f"-I{counting_dir()}", "-o", str(library)]
    done = subprocess.run(
        [*command, *map(str, sources), "-lm"], capture_output=True, text=True, check=False
    )
    if done.returncode:
        first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip())
        raise CheckFailed(f"the counting build of the emitted C does not compile: {first}")
    return CountedLibrary(library)
