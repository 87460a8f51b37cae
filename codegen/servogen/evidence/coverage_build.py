"""Run the calls twice, under gcov and with probes, and put both tallies together."""

from __future__ import annotations

import json
import struct
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.errors import CheckFailed
from servogen.evidence.bench import Subject
from servogen.evidence.coverage_decisions import ProbedUnit, Site, probe
from servogen.evidence.flags import IEEE
from servogen.evidence.tools import demand, find_tool, run_tool
from servogen.sil.player import player_source

FLAGS = (*IEEE, "-O0")
PLAYER = ("-DSG_PLAYER_FILES",)
GCC = "apt-get install gcc"

Pairs = Counter[tuple[int, int]]  # how often which two counts stand side by side


@dataclass(frozen=True)
class Tally:
    """How often one decision of one translation unit went which way."""

    unit: str
    site: Site
    false: int
    true: int


@dataclass(frozen=True)
class Measured:
    """What a package's calls reached.

    Attributes:
        tallies: every decision of every unit; those of a shared kernel once for each unit.
        gcov_branches, gcov_taken: over all units, as gcov counts them.
        faults: what the two runs say differently, and what keeps this from being MC/DC.
    """

    tallies: tuple[Tally, ...]
    gcov_branches: int
    gcov_taken: int
    faults: tuple[str, ...]


def measure(subject: Subject, stream: bytes, folder: Path) -> Measured:
    """Compile the package twice in ``folder`` and play ``stream`` on both.

    Raises:
        CheckFailed: something does not compile or run.
        ToolMissing: no gcc, or no gcov beside it.
    """
    find_tool("gcc", GCC)
    plain, probed = folder / "gcov", folder / "probed"
    for place in (plain, probed):
        place.mkdir(parents=True)
        subject.write(place)
        text = player_source(subject.package.declarations)
        (place / "player.c").write_text(text, encoding="utf-8")
    units = [
        probe(plain / name, index, subject.package.declarations)
        for index, name in enumerate(subject.package.sources)
    ]
    answers = _play_gcov(plain, subject.package.sources, stream)
    told, counts = _play_probed(probed, units, stream)
    faults = [fault for unit in units for fault in unit.faults]
    if told != answers:
        faults.append("the C answers differently with probes than without")
    tallies = _tallies(units, counts)
    branches = taken = 0
    for unit in units:
        pairs = _gcov(plain, unit.name)
        faults += _disagreements(unit.name, pairs, [t for t in tallies if t.unit == unit.name])
        branches += 2 * sum(sum(found.values()) for found in pairs.values())
        taken += sum(n * ((a > 0) + (b > 0)) for f in pairs.values() for (a, b), n in f.items())
    return Measured(tuple(tallies), branches, taken, tuple(dict.fromkeys(faults)))


def _play_gcov(folder: Path, sources: Sequence[str], stream: bytes) -> bytes:
    for name in sources:
        demand(["gcc", *FLAGS, "--coverage", "-c", name], f"gcc --coverage {name}", folder)
    demand(["gcc", *FLAGS, *PLAYER, "-c", "player.c"], "gcc player.c", folder)  # not counted
    objects = [f"{Path(name).stem}.o" for name in ("player.c", *sources)]
    demand(["gcc", "--coverage", "-o", "player", *objects], "gcc --coverage", folder)
    return _play(folder, stream)


def _play_probed(
    folder: Path, units: Sequence[ProbedUnit], stream: bytes
) -> tuple[bytes, list[bytes]]:
    for unit in units:
        (folder / unit.name).write_text(unit.text, encoding="utf-8")
    (folder / "sg_probes.c").write_text(_writer(len(units)), encoding="utf-8")
    sources = ["player.c", "sg_probes.c", *(unit.name for unit in units)]
    demand(["gcc", *FLAGS, *PLAYER, "-w", "-o", "player", *sources], "gcc of the probed C", folder)
    told = _play(folder, stream)
    return told, [(folder / f"probes_{i}.bin").read_bytes() for i in range(len(units))]


def _writer(units: int) -> str:
    """C that writes the counts of every unit when the program ends."""
    lines = ["#include <stdio.h>"]
    for i in range(units):
        lines.append(f"extern unsigned long sg_probes_{i}[][2], sg_probes_{i}_rows;")
    lines.append("__attribute__((destructor)) static void write_probes(void)\n{\n    FILE *to;")
    for i in range(units):
        lines.append(f'    to = fopen("probes_{i}.bin", "wb");')
        lines.append(f"    fwrite(sg_probes_{i}, sizeof sg_probes_{i}[0], sg_probes_{i}_rows, to);")
        lines.append("    fclose(to);")
    return "\n".join([*lines, "}", ""])


def _play(folder: Path, stream: bytes) -> bytes:
    (folder / "calls.bin").write_bytes(stream)
    done = run_tool([folder / "player"], folder)
    if done.returncode != 0:
        raise CheckFailed(f"the player ends with status {done.returncode}: {done.stderr[:300]}")
    return (folder / "results.bin").read_bytes()


def _tallies(units: Sequence[ProbedUnit], counts: Sequence[bytes]) -> list[Tally]:
    found = []
    for unit, data in zip(units, counts, strict=True):
        numbers = struct.unpack(f"@{2 * len(unit.sites)}L", data)
        for i, site in enumerate(unit.sites):
            found.append(Tally(unit.name, site, numbers[2 * i], numbers[2 * i + 1]))
    return found


def _gcov(folder: Path, source: str) -> dict[tuple[str, str], Pairs]:
    """(file, function) -> pairs of branch counts, as gcov has them for one translation unit."""
    find_tool("gcov", GCC)
    command = ["gcov", "--json-format", "--stdout", "--branch-probabilities", Path(source).stem]
    text = demand(command, f"gcov {source}", folder)
    found: dict[tuple[str, str], Pairs] = {}
    for file in json.loads(text)["files"]:
        for line in file["lines"]:
            counts = [int(branch["count"]) for branch in line["branches"]]
            for first, second in zip(counts[::2], counts[1::2], strict=True):
                key = Path(file["file"]).name, str(line["function_name"])
                found.setdefault(key, Counter())[min(first, second), max(first, second)] += 1
    return found


def _disagreements(
    unit: str, gcov: Mapping[tuple[str, str], Pairs], tallies: Iterable[Tally]
) -> list[str]:
    """Functions where gcov counts what the probes do not, whatever the order of the branches.

    The probes may count more: gcc makes a maximum, or a truth value, of some ``?:`` even at -O0,
    and gcov sees no branch there.
    """
    own: dict[tuple[str, str], Pairs] = {}
    for t in tallies:
        key = t.site.file, t.site.function
        own.setdefault(key, Counter())[min(t.true, t.false), max(t.true, t.false)] += 1
    if own and not gcov:
        return [f"{unit}: gcov has no branch at all, the probes have some in {len(own)}"]
    return [
        f"{unit}: gcov and the probes count {function} of {file} differently"
        for (file, function), pairs in sorted(gcov.items())
        if pairs - own.get((file, function), Counter())
    ]
