"""Compile fuzz targets, for libFuzzer with clang or for the replay of a corpus with gcc."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from servogen.controllers.design import Declaration
from servogen.evidence.bench import Subject
from servogen.evidence.flags import IEEE
from servogen.evidence.fuzz_target import HARNESS, target_source
from servogen.evidence.tools import demand
from servogen.resources import resource_dir

LANGUAGE = (*IEEE, "-g", "-O1", "-fno-omit-frame-pointer")
CHECKS = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)


def build_replay(subject: Subject, folder: Path, prefixes: Sequence[str] = ()) -> dict[str, Path]:
    """Programs that play corpus files given as arguments, by prefix of the controller; of all
    controllers, or of those named.

    Raises:
        CheckFailed: something does not compile.
    """
    chosen = [d for d in subject.package.declarations if not prefixes or d.prefix in prefixes]
    return _build(subject, chosen, folder, "gcc", (), ("sg_replay.c",))


def build_fuzzers(subject: Subject, folder: Path) -> dict[str, Path]:
    """Programs of libFuzzer, by prefix of the controller.

    Raises:
        CheckFailed: something does not compile.
    """
    declarations = subject.package.declarations
    return _build(subject, declarations, folder, "clang", ("-fsanitize=fuzzer",), ())


def _build(
    subject: Subject,
    declarations: Sequence[Declaration],
    folder: Path,
    compiler: str,
    instrument: tuple[str, ...],
    mains: tuple[str, ...],
) -> dict[str, Path]:
    """The emitted C with sanitizers, once; the harness without: it is not what is judged."""
    folder.mkdir(parents=True, exist_ok=True)
    subject.write(folder)
    harness = resource_dir("c_runtime") / "fuzz"
    no_link = tuple(f"{flag}-no-link" for flag in instrument)
    for source in subject.package.sources:
        command = [compiler, *LANGUAGE, *CHECKS, *no_link, "-c", source]
        demand(command, f"{compiler} {source}", folder)
    for source in (*HARNESS, *mains):
        command = [compiler, *LANGUAGE, f"-I{harness}", "-c", str(harness / source)]
        demand(command, f"{compiler} {source}", folder)
    objects = [f"{Path(s).stem}.o" for s in (*subject.package.sources, *HARNESS, *mains)]
    programs: dict[str, Path] = {}
    for d in declarations:
        name = f"fuzz_{d.prefix}"
        (folder / f"{name}.c").write_text(target_source(d), encoding="utf-8")
        command = [compiler, *LANGUAGE, *CHECKS, *instrument, f"-I{harness}", f"{name}.c"]
        demand([*command, *objects, "-lm", "-o", name], f"{compiler} {name}.c", folder)
        programs[d.prefix] = folder / name
    return programs
