"""The compiler matrix: no warning, nothing from outside, and the same bits from every compiler."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from servogen.emit.package import CPackage
from servogen.evidence import compilers_objects, compilers_strict
from servogen.evidence.bench import Bench
from servogen.evidence.compilers_found import Compiler, find_compilers
from servogen.evidence.compilers_play import Comparison, compare
from servogen.evidence.finding import Finding
from servogen.progress import Progress

RANDOM_CALLS = 100
# Where the objects are looked into: nm reads those of its own machine.
_LOOKED_INTO = ("gcc", "clang", "zig 64-bit")


class Tally:
    """What was compiled, what went wrong."""

    def __init__(self) -> None:
        self.compiled: dict[str, int] = {}
        self.faults: list[str] = []

    def add(self, what: str, faults: Sequence[str]) -> None:
        self.compiled[what] = self.compiled.get(what, 0) + 1
        self.faults += [f"{what}: {fault}" for fault in faults]


def run(bench: Bench, progress: Progress) -> Finding:
    """Both precisions through every compiler that is found.

    Raises:
        ToolMissing: there is no gcc.
    """
    found = find_compilers()
    tally = Tally()
    not_run = list(found.missing)
    played: dict[str, Comparison] = {}
    faults: list[str] = []
    with (
        TemporaryDirectory(prefix="servogen-compilers-") as name,
        progress.task("Compilers", len(bench.subjects) * (len(found.compilers) + 1)) as task,
    ):
        for subject in bench.subjects:
            folder = Path(name) / subject.precision.name
            before = len(tally.faults)
            for compiler in found.compilers:
                compile_all(subject.package, compiler, folder, tally)
                task.advance()
            tally.add("tables", compilers_objects.misplaced_tables(subject.package))
            faults += [f"{subject.precision.name}: {f}" for f in tally.faults[before:]]
            plays = [*subject.suite(RANDOM_CALLS), *subject.closed_loops(None)]
            told = compare(subject.package, plays, found.compilers, folder)
            faults += [f"{subject.precision.name}: {f}" for f in told.faults]
            not_run += [text for text in told.not_run if text not in not_run]
            played[subject.precision.name] = told
            task.advance()
    if not any(c.family == "clang" for c in found.compilers):
        faults.append("no clang was run: pip install ziglang, or apt-get install clang")
    compilations = sum(n for what, n in tally.compiled.items() if what != "tables")
    versions = {c.name.split(" ")[0]: c.version for c in reversed(found.compilers)}
    return Finding(
        check="compilers",
        passed=not faults,
        summary=f"{len(found.compilers)} compilers and targets, {compilations} compilations, "
        f"{len(faults)} faults; {sum(p.calls for p in played.values())} calls, the same bits from "
        f"{min(len(p.same) for p in played.values())} builds",
        tools=dict(sorted(versions.items())),
        subjects=bench.digests,
        figures={
            "compilations": tally.compiled,
            "calls": {name: p.calls for name, p in played.items()},
            "same bits": {name: list(p.same) for name, p in played.items()},
        },
        faults=tuple(faults),
        not_run=tuple(sorted(not_run)),
    )


def compile_all(package: CPackage, compiler: Compiler, folder: Path, tally: Tally) -> None:
    """Sources at all levels, headers, C++; the objects looked into where nm can."""
    compilers_strict.write(package, folder)
    for level in ("-O2",) if compiler.further else compilers_strict.LEVELS:
        said = compilers_strict.sources(package, compiler, level, folder)
        tally.add(f"{compiler.name} {level}", said)
        if not said and compiler.name in _LOOKED_INTO:
            found = compilers_objects.faults(package, folder)
            tally.faults += [f"{compiler.name} {level}: {fault}" for fault in found]
    if not compiler.further:
        tally.add(f"{compiler.name} headers", compilers_strict.headers(package, compiler, folder))
    for standard in compilers_strict.STANDARDS if compiler.plus else ():
        said = compilers_strict.from_cpp(compiler, standard, folder)
        tally.add(f"{compiler.name} {standard}", said)
