"""Three quick checks that planted faults are held against: what gcc alone can say.

Each is made for one bench, the sound one, and then run on benches with a fault in them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from servogen.errors import CheckFailed
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.flags import IEEE, WARNINGS
from servogen.evidence.same_bits import first_difference
from servogen.evidence.tools import demand, run_bytes, run_tool
from servogen.sil.player import Play, encode, player_source
from servogen.wcet.package import count_package

PATIENCE_S = 300  # a loop without an end is a fault too

# What a check says against a bench; empty where it has nothing to say.
Quick = Callable[[Bench], list[str]]


def warnings(bench: Bench) -> list[str]:
    """The warnings of the strict build, optimised: gcc looks for uninitialised values only then."""
    faults = []
    for subject in bench.subjects:
        with tempfile.TemporaryDirectory() as folder:
            for source in subject.write(Path(folder)):
                command = ["gcc", *IEEE, "-O2", *WARNINGS, "-c"]
                done = run_tool([*command, source, "-o", "/dev/null"], Path(folder))
                if done.returncode != 0:
                    said = (x for x in done.stderr.splitlines() if "error" in x)
                    faults.append(next(said, "it does not compile").replace(f"{folder}/", ""))
    return faults


@dataclass
class Equivalence:
    """Answers to recorded calls, bit for bit those of the sound package.

    Attributes:
        plays: per precision, the calls.
        level: optimisation of the build.
    """

    plays: Mapping[str, Sequence[Play]]
    level: str = "-O1"
    _sound: dict[str, bytes] = field(default_factory=dict)
    _objects: dict[tuple[str, str], bytes] = field(default_factory=dict)

    def learn(self, bench: Bench) -> None:
        """Take the sound bench's answers as right.

        Raises:
            CheckFailed: it does not compile or does not answer.
        """
        for subject in bench.subjects:
            self._sound[subject.precision.name] = self._answers(subject)

    def __call__(self, bench: Bench) -> list[str]:
        faults = []
        for subject in bench.subjects:
            try:
                told = self._answers(subject)
            except CheckFailed as fault:
                faults.append(str(fault))
                continue
            found = first_difference(
                subject.package.declarations,
                self.plays[subject.precision.name],
                self._sound[subject.precision.name],
                told,
            )
            faults += [found] if found else []
        return faults

    def _answers(self, subject: Subject) -> bytes:
        plays = self.plays[subject.precision.name]
        declarations = subject.package.declarations
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            sources = subject.write(folder)
            (folder / "player.c").write_text(player_source(declarations), encoding="utf-8")
            objects = [self._object(folder, s) for s in (*sources, folder / "player.c")]
            demand(["gcc", *objects, "-o", folder / "player"], "linking the player")
            calls = encode(declarations, plays)
            done = run_bytes([folder / "player"], folder, calls, PATIENCE_S)
        if done.returncode != 0:
            raise CheckFailed(f"the player ends with status {done.returncode}")
        return done.stdout

    def _object(self, folder: Path, source: Path) -> Path:
        """The object of a source; made once for the same text after the preprocessor."""
        out = source.with_suffix(".o")
        flags = [*IEEE, self.level]
        text = demand(["gcc", "-E", "-P", *flags, source], f"reading {source.name}")
        key = (source.name, text)
        if key not in self._objects:
            demand(["gcc", *flags, "-c", source, "-o", out], f"compiling {source.name}", folder)
            self._objects[key] = out.read_bytes()
        out.write_bytes(self._objects[key])
        return out


@dataclass
class StaticCount:
    """The worst case of every entry point, counted anew, is what the sound package states."""

    _sound: dict[str, object] = field(default_factory=dict)

    def learn(self, bench: Bench) -> None:
        """Take the sound bench's counts as right."""
        for subject in bench.subjects:
            self._sound[subject.precision.name] = _counted(subject)

    def __call__(self, bench: Bench) -> list[str]:
        faults = []
        for subject in bench.subjects:
            try:
                same = _counted(subject) == self._sound[subject.precision.name]
            except CheckFailed as refused:
                faults.append(str(refused))
                continue
            if not same:
                faults.append(f"{subject.precision.name}: the counts are not those of the head")
        return faults


def _counted(subject: Subject) -> object:
    entries = [f"{d.prefix}_{op.name}" for d in subject.package.declarations for op in d.operations]
    entries += [f"{d.prefix}_init" for d in subject.package.declarations]
    with tempfile.TemporaryDirectory() as folder:
        counts = count_package(subject.write(Path(folder)), [Path(folder)], entries)
    return {n: (c.total().as_dict(), c.stack_bytes) for n, c in counts.entry_points.items()}
