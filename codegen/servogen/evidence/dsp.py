"""The emitted C through the C6000 cross compiler: no warning, no call outside, and its sizes.

GCC's own default on this processor replaces a division by a reciprocal and Newton steps, which is
not IEEE 754. Without that, a division calls the ABI's run-time routine, as it does with TI's own
compiler. The package is therefore compiled twice: as it is, where those two routines are the only
names that may be missing, and with ``SG_OWN_DIVISION``, where nothing may.

No cycles: GCC does not pipeline loops for this processor in software, TI's compiler does.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.errors import CheckFailed
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.dsp_pragmas import Told, examine_pragmas
from servogen.evidence.dsp_toolchain import toolchain
from servogen.evidence.finding import Finding
from servogen.evidence.flags import IEEE, OWN_DIVISION, WARNINGS
from servogen.evidence.tools import demand, run_tool, version_of
from servogen.progress import Progress

FLAGS = (
    "-march=c674x",
    "-O2",
    "-ffreestanding",
    *IEEE,
    "-fno-reciprocal-math",
    # A fill or copy loop stays a loop; without it GCC may call memset and memcpy.
    "-fno-tree-loop-distribute-patterns",
)
# Division of float and double in TI's C6000 embedded application binary interface (SPRAB89).
ABI_DIVISION = frozenset({"__c6xabi_divf", "__c6xabi_divd"})
# Sections by what they hold; whatever else an object has is of no weight on the target.
KINDS = {
    "text": (".text",),
    "rodata": (".rodata", ".const"),
    "data": (".data", ".fardata", ".neardata"),
    "bss": (".bss", ".far", ".common"),
}


@dataclass
class _Built:
    """One way of compiling a package: faults, bytes per file and kind, names not its own."""

    faults: list[str]
    sizes: dict[str, dict[str, int]]
    foreign: set[str]


def run(bench: Bench, progress: Progress) -> Finding:
    """Compile every controller in both precisions.

    Raises:
        ToolMissing: there is no cross compiler and nothing to build it from.
        CheckFailed: it could not be built, or cannot read its own objects.
    """
    bin_dir = toolchain(progress)
    faults: list[str] = []
    figures: dict[str, object] = {}
    details: list[str] = []
    with progress.task("Compiling for the C6000", len(bench.subjects)) as task:
        for subject in bench.subjects:
            found, line, kept = _subject(bin_dir, subject)
            faults += found
            figures[subject.precision.name] = kept
            details.append(line)
            task.advance()
    return Finding(
        check="dsp",
        passed=not faults,
        summary=_summary(bench, faults),
        tools={"tic6x-elf-gcc": version_of([bin_dir / "tic6x-elf-gcc", "--version"])},
        subjects=bench.digests,
        figures={"flags": list(FLAGS), **figures},
        faults=tuple(faults),
        details=tuple(details),
    )


def _subject(bin_dir: Path, subject: Subject) -> tuple[list[str], str, dict[str, object]]:
    """Faults, a line for people, and the figures."""
    name = subject.precision.name
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        sources = subject.write(folder)
        plain = compile_all(bin_dir, folder, sources, [])
        alone = compile_all(bin_dir, folder, sources, [OWN_DIVISION])
        entries = [
            f"{d.prefix}_{o.name}" for d in subject.package.declarations for o in d.operations
        ]
        try:
            told = examine_pragmas(sources, folder, entries)
        except CheckFailed as refused:  # C that cannot be counted cannot be promised anything
            told = Told([str(refused).replace(f"{folder}/", "")])
    faults = [f"{name}: {fault}" for fault in (*plain.faults, *alone.faults, *told.faults)]
    faults += [f"{name}: {x} is called" for x in sorted(plain.foreign - ABI_DIVISION)]
    faults += [f"{name}: {x} is called with {OWN_DIVISION}" for x in sorted(alone.foreign)]
    kept: dict[str, object] = {
        "division_by": sorted(plain.foreign & ABI_DIVISION),
        "foreign_with_own_division": sorted(alone.foreign),
        "bytes": plain.sizes,
        "bytes_with_own_division": alone.sizes,
        "loops": told.loops,
        "loops_told": told.loops_told,
        "tables": told.tables,
        "tables_aligned": told.tables_aligned,
    }
    return faults, _line(subject, plain, told), kept


def compile_all(
    bin_dir: Path, folder: Path, sources: Sequence[Path], extra: Sequence[str]
) -> _Built:
    """Objects of all sources: warnings, sizes, and the names that none of them defines."""
    built = _Built([], {}, set())
    defined: set[str] = set()
    if not sources:
        built.faults.append("there is no source to compile")
    for source in sources:
        out = source.with_suffix(".o")
        command: list[str | Path] = [
            bin_dir / "tic6x-elf-gcc",
            *FLAGS,
            *WARNINGS,
            *extra,
            f"-I{folder}",
        ]
        done = run_tool([*command, "-c", source, "-o", out], folder)
        if done.returncode != 0:
            said = (x for x in done.stderr.splitlines() if "error" in x or "warning" in x)
            first = next(said, done.stderr.strip()[:200]).replace(f"{folder}/", "")
            built.faults.append(f"{source.name} does not compile: {first}")
            continue
        listed = demand([bin_dir / "tic6x-elf-nm", out], f"symbols of {source.name}")
        for line in listed.splitlines():
            *_, kind, symbol = line.split()
            (built.foreign if kind in "Uvw" else defined).add(symbol)
        built.sizes[source.name] = section_bytes(bin_dir, out)
    built.foreign -= defined
    return built


def section_bytes(bin_dir: Path, out: Path) -> dict[str, int]:
    """Bytes of an object by ``KINDS``."""
    sizes = dict.fromkeys(KINDS, 0)
    for line in demand([bin_dir / "tic6x-elf-size", "-A", out], f"size of {out.name}").splitlines():
        words = line.split()
        for kind, prefixes in KINDS.items():
            if len(words) == 3 and words[0].startswith(prefixes):
                sizes[kind] += int(words[1])
                break
    return sizes


def _line(subject: Subject, plain: _Built, told: Told) -> str:
    total = {kind: sum(file[kind] for file in plain.sizes.values()) for kind in KINDS}
    parts = ", ".join(f"{kind} {total[kind]}" for kind in KINDS)
    division = ", ".join(sorted(plain.foreign & ABI_DIVISION)) or "none"
    return (
        f"{subject.precision.name}: bytes {parts}; division by {division}; "
        f"{told.loops_told} of {told.loops} loops and {told.tables_aligned} of {told.tables} "
        "tables told to TI's compiler"
    )


def _summary(bench: Bench, faults: Sequence[str]) -> str:
    if faults:
        return f"{len(faults)} faults with gcc for c674x"
    count = sum(len(s.package.sources) for s in bench.subjects)
    return (
        f"{count} files for c674x in {len(bench.subjects)} precisions, no warning, no library call "
        "with the package's own division"
    )
