"""The emitted C under gcc's sanitizers: the suite, the closed loop and the kept corpus.

The suite and the closed loop are played a second time with ``SG_OWN_DIVISION``, the division that
C6000 builds have: the same bits as with the processor's, and nothing undefined in it either.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from servogen.evidence.answers import answers, misjudged
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.complaints import complaint
from servogen.evidence.finding import Finding
from servogen.evidence.flags import IEEE, OWN_DIVISION
from servogen.evidence.fuzz_build import CHECKS, LANGUAGE, build_replay
from servogen.evidence.fuzz_corpus import corpus_dir, kept_files
from servogen.evidence.same_bits import first_difference
from servogen.evidence.tools import demand, find_tool, run_tool, version_of
from servogen.progress import Progress
from servogen.sil.player import Play, encode, player_source

STEPS = 100  # random steps per controller; the edges come on top
PERIODS = 300  # of the closed loop
PLAIN = (*IEEE, "-O2")
DIVISION = "sg_division.h"  # in the packages that divide


def run(bench: Bench, progress: Progress) -> Finding:
    """See ``evidence.catalogue``.

    Raises:
        ToolMissing: no gcc.
        CheckFailed: something does not compile.
    """
    find_tool("gcc", "apt-get install gcc")
    figures: dict[str, dict[str, object]] = {}
    faults: list[str] = []
    with progress.task("Sanitizers", total=len(bench.subjects)) as task:
        for subject in bench.subjects:
            name = subject.precision.name
            plays = [*subject.suite(STEPS), *subject.closed_loops(PERIODS)]
            calls = sum(times for play in plays for _, times in play.counted())
            with tempfile.TemporaryDirectory(prefix="servogen-sanitizers-") as folder:
                found = play_sanitized(subject, plays, Path(folder, "player"))
                replayed, wrong = replay(subject, Path(folder, "replay"), corpus_dir())
            own = DIVISION in subject.package.files
            figures[name] = {"calls": calls, "own_division": own, "sequences": replayed}
            faults += [f"{name}: {fault}" for fault in (*found, *wrong)]
            task.advance()
    return Finding(
        check="sanitizers",
        passed=not faults,
        summary=", ".join(_summary(name, figure) for name, figure in figures.items()),
        tools={"gcc": version_of(["gcc", "--version"])},
        subjects=bench.digests,
        figures=figures,
        faults=tuple(faults),
    )


def _summary(name: str, figure: dict[str, object]) -> str:
    again = ", again with the own division" if figure["own_division"] else ""
    return f"{name}: {figure['calls']} calls{again}, {sum_of(figure['sequences'])} kept sequences"


def play_sanitized(subject: Subject, plays: Sequence[Play], folder: Path) -> list[str]:
    """Faults of the calls under sanitizers, whose answers must be those without them, and those
    with the package's own division."""
    folder.mkdir(parents=True)
    declarations, sources = subject.package.declarations, subject.package.sources
    subject.write(folder)
    (folder / "player.c").write_text(player_source(declarations), encoding="utf-8")
    stream = encode(declarations, plays)
    if not stream:
        return ["no call to play"]
    (folder / "calls.bin").write_bytes(stream)
    builds = {"sanitized": (*LANGUAGE, *CHECKS), "plain": PLAIN}
    if DIVISION in subject.package.files:
        builds["own division"] = (*LANGUAGE, *CHECKS, OWN_DIVISION)
    right = b""
    for name, flags in builds.items():
        command = ["gcc", *flags, "-DSG_PLAYER_FILES", "-o", name, "player.c", *sources]
        demand(command, f"gcc of the player, {name}", folder)
        done = run_tool([folder / name], folder)
        if done.returncode != 0 or done.stderr:
            return [f"suite, {name}: {complaint(done.stderr, folder)}"]
        told = (folder / "results.bin").read_bytes()
        right = right or told
        different = first_difference(declarations, plays, right, told)
        if different is not None:
            return [f"suite, {name}: {different}"]
    return [f"suite: {fault}" for fault in misjudged(answers(declarations, plays, right))]


def replay(
    subject: Subject, folder: Path, corpus: Path, prefixes: Sequence[str] = ()
) -> tuple[dict[str, int], list[str]]:
    """Every kept sequence through the target of its controller; all of them, or those named.

    Returns:
        sequences by prefix, and faults; a controller without any is one.
    """
    replayed: dict[str, int] = {}
    faults: list[str] = []
    programs = build_replay(subject, folder, prefixes)
    for d in subject.package.declarations:
        if d.prefix not in programs:
            continue
        files = kept_files(corpus / d.kind)
        replayed[d.prefix] = len(files)
        if not files:
            faults.append(f"{d.prefix}: no kept sequences of the kind {d.kind}: run make fuzz")
            continue
        done = run_tool([programs[d.prefix], *files], folder)
        begun = done.stdout.splitlines()
        if done.returncode != 0 or len(begun) != len(files):
            culprit = Path(begun[-1]).name if begun else "none"
            faults.append(f"{d.prefix}: sequence {culprit}: {complaint(done.stderr, folder)}")
    return replayed, faults


def sum_of(counts: object) -> int:
    """Of the values of a mapping."""
    return sum(counts.values()) if isinstance(counts, dict) else 0
