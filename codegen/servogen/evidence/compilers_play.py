"""The same calls through the same C, compiled otherwise: every bit of every answer is compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.evidence.compilers_found import Compiler
from servogen.evidence.same_bits import first_difference
from servogen.evidence.tools import run_bytes, run_tool
from servogen.sil.player import Play, encode, player_source


@dataclass(frozen=True)
class Build:
    """One way to compile: the first one's answers are what the others' are held to."""

    compiler: Compiler
    level: str

    @property
    def name(self) -> str:
        return f"{self.compiler.name} {self.level}"


def builds(compilers: Sequence[Compiler]) -> list[Build]:
    """gcc -O2 first; then every level of gcc, -O2 of whatever else runs here."""
    runs = [c for c in compilers if c.runs]
    levels = {"gcc": ("-O2", "-O0", "-O1", "-O3", "-Os")}
    return [Build(c, level) for c in runs for level in levels.get(c.name, ("-O2",))]


class NotLinked(Exception):
    """The program cannot be linked here: no library for its target."""


def answers(package: CPackage, build: Build, calls: bytes, folder: Path) -> bytes:
    """What the package says to the calls.

    Raises:
        NotLinked: the compiler compiles for this target and cannot link.
        RuntimeError: the program fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    package.write(folder)
    (folder / "player.c").write_text(player_source(package.declarations), encoding="utf-8")
    # the player is the test's own and needs a library: its header too
    hosted = [part for part in build.compiler.command if part != "-ffreestanding"]
    command = [*hosted, "-std=c99", build.level, "-o", "player", "player.c", *package.sources]
    linked = run_tool(command, folder)
    if linked.returncode != 0:
        raise NotLinked((linked.stderr.strip().splitlines() or ["no message"])[0])
    done = run_bytes(["./player"], folder, calls)
    if done.returncode != 0:
        raise RuntimeError(f"the player ended with status {done.returncode}")
    return done.stdout


@dataclass(frozen=True)
class Comparison:
    """``same``: builds whose answers are those of the first; ``calls``: how many were made."""

    same: tuple[str, ...]
    calls: int
    faults: tuple[str, ...]
    not_run: tuple[str, ...]


def compare(
    package: CPackage, plays: Sequence[Play], compilers: Sequence[Compiler], folder: Path
) -> Comparison:
    """Play the calls through every build."""
    data = encode(package.declarations, plays)
    calls = sum(times for play in plays for _, times in play.counted())
    first, *others = builds(compilers)
    told = answers(package, first, data, folder / "first")
    same, faults, not_run = [first.name], [], []
    for number, build in enumerate(others):
        try:
            other = answers(package, build, data, folder / str(number))
        except NotLinked as error:
            not_run.append(f"{build.name}, calls: {error}")
            continue
        except (RuntimeError, OSError) as error:
            faults.append(f"{build.name}: {error}")
            continue
        difference = first_difference(package.declarations, plays, told, other)
        if difference is None:
            same.append(build.name)
        else:
            faults.append(f"{build.name} against {first.name}: {difference}")
    if not calls or not told:
        faults.append("no call was played")
    return Comparison(tuple(same), calls, tuple(faults), tuple(not_run))
