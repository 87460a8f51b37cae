"""Plays calls into the counting twin of a package and keeps, per entry point, what was counted.

A small C file stands between the player and the twin: before each call it clears the counters,
after it compares them with the static count, so that every single call is held to it at C speed.
Of a loop up to a named bound, the static count is taken for the turns that this call did.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from servogen.errors import CheckFailed
from servogen.evidence.bench import Subject
from servogen.evidence.tools import demand, find_tool, run_bytes
from servogen.sil.player import Play, encode, player_source
from servogen.wcet.dynamic import COUNTING_FLAGS, counting_dir, write_counted_sources
from servogen.wcet.instrument import prelude
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.package import Count

REMEDY = "apt-get install gcc"
_N = len(CLASSES)


@dataclass(frozen=True)
class Offence:
    """The first call that did not keep to the count: its number among all calls, the class, what
    was counted in it and what the static count says (of that many turns of the bounded loops)."""

    call: int
    kind: str
    ran: int
    static: int


@dataclass(frozen=True)
class EntryRuns:
    """What the calls of one entry point did.

    Attributes:
        calls: how many there were.
        largest, least: class by class over all calls.
        closest: largest share of its own static count that a call did, all classes added up.
        turns: bound -> most turns that a loop up to it did.
        above: the first call that did more than counted, if any.
        unequal: the first that did not do what every run does, if any.
    """

    calls: int
    largest: OperationCounts
    least: OperationCounts
    closest: float
    turns: dict[str, int]
    above: Offence | None
    unequal: Offence | None


@dataclass(frozen=True)
class Runs:
    """Entry point -> its runs, and the bounds whose turns were seen call by call."""

    entries: dict[str, EntryRuns]
    watched: tuple[str, ...]


def entry_names(subject: Subject) -> list[str]:
    """All entry points as ``which`` numbers them: operations in the player's order, then init."""
    declarations = subject.package.declarations
    names = [f"{d.prefix}_{op.name}" for d in declarations for op in d.operations]
    return names + [f"{d.prefix}_init" for d in declarations]


def count_runs(subject: Subject, plays: Sequence[Play]) -> Runs:
    """Compile the twin, play everything, read what was kept.

    Raises:
        CheckFailed: it does not compile, or the player failed.
        ToolMissing: no gcc.
    """
    gcc = find_tool("gcc", REMEDY)
    folder = Path(tempfile.mkdtemp(prefix="servogen-counts-"))
    try:
        sources = subject.write(folder)
        twins = write_counted_sources(sources, [folder], folder)
        declarations = subject.package.declarations
        (folder / "player.c").write_text(player_source(declarations), encoding="utf-8")
        (folder / "marks.c").write_text(_marks(subject, twins.watched), encoding="utf-8")
        # The player calls init where nobody marks it: by another name, which marks.c gives it.
        renamed = [f"-D{d.prefix}_init=sg_marked_{d.prefix}_init" for d in declarations]
        base: list[str | Path] = [gcc, *COUNTING_FLAGS, f"-I{folder}", f"-I{counting_dir()}"]
        what = "the counting build of the emitted C does not compile"
        player = [*base, *renamed, "-DSG_PLAYER_MARKS", "-c", "player.c", "-o", "player.o"]
        demand(player, what, folder)
        rest: list[str | Path] = [*twins.files, "marks.c", "player.o"]
        demand([*base, "-o", "player", *rest, "-lm"], what, folder)
        _play(folder, encode(declarations, plays))
        return Runs(_read(subject, folder / "counts.bin", twins.watched), twins.watched)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _play(folder: Path, stream: bytes) -> None:
    done = run_bytes([folder / "player"], folder, stream)
    if done.returncode != 0:
        raise CheckFailed(f"the counting player ended with status {done.returncode}")


def _marks(subject: Subject, watched: Sequence[str]) -> str:
    names = entry_names(subject)
    counts = [subject.counts.entry_points[name] for name in names]
    first = len(names) - len(subject.package.declarations)
    lines = [
        "#include <stdio.h>",
        "#include <string.h>",
        *(f'#include "{d.prefix}.h"' for d in subject.package.declarations),
        prelude(watched) + '#include "sg_counting.h"',
        f"enum {{ ENTRIES = {len(names)}, FIRST_INIT = {first} }};",
        _array("fixed", [_bounded(count, watched) for count in counts]),
        _array("exact", [[int(name in count.exact) for name in CLASSES] for count in counts]),
        "static const unsigned long long part[ENTRIES][SG_N_TURNS + 1][SG_N_CLASSES] = {",
        ",\n".join(_parts(count, watched) for count in counts),
        "};",
        _RECORD,
    ]
    for number, d in enumerate(subject.package.declarations):
        lines.append(
            f"void sg_marked_{d.prefix}_init({d.prefix}_t *self)\n"
            f"{{ sg_player_begin({first + number}); {d.prefix}_init(self); sg_player_end(); }}"
        )
    return "\n".join([*lines, ""])


def _bounded(count: Count, watched: Sequence[str]) -> list[int]:
    """The count but for the turns of the watched bounds."""
    result = count.fixed
    for bound, part in {**count.per_iteration, **count.per_level}.items():
        if bound not in watched:
            result = result + part * count.caps[bound]
    return list(result.as_dict().values())


def _parts(count: Count, watched: Sequence[str]) -> str:
    parts = {**count.per_iteration, **count.per_level}
    rows = [parts.get(bound, OperationCounts()).as_dict().values() for bound in watched]
    return "{" + ", ".join(_row(row) for row in [*map(list, rows), [0]]) + "}"


def _array(name: str, rows: Sequence[Sequence[int]]) -> str:
    inside = ",\n".join(_row(row) for row in rows)
    return f"static const unsigned long long {name}[ENTRIES][SG_N_CLASSES] = {{\n{inside}\n}};"


def _row(row: Sequence[int]) -> str:
    return "{" + ", ".join(f"{n}ull" for n in row) + "}"


def _read(subject: Subject, path: Path, watched: Sequence[str]) -> dict[str, EntryRuns]:
    names, turns = entry_names(subject), len(watched)
    data = np.fromfile(path, dtype=np.uint64).reshape(len(names), 11 + 2 * _N + turns + 1)
    found = {}
    for name, row in zip(names, data, strict=True):
        values = iter(int(v) for v in row)
        calls, ran, bound = (next(values) for _ in range(3))
        offences = [next(values) for _ in range(8)]
        found[name] = EntryRuns(
            calls=calls,
            closest=ran / bound if bound else 1.0,
            above=_offence(offences[:4]),
            unequal=_offence(offences[4:]),
            largest=OperationCounts(*islice(values, _N)),
            least=OperationCounts(*islice(values, _N)),
            turns=dict(zip(watched, values, strict=False)),
        )
    return found


def _offence(values: Sequence[int]) -> Offence | None:
    """``values``: number of the call plus one (0: none), class, counted, static."""
    call, kind, ran, static = values
    return Offence(call - 1, CLASSES[kind], ran, static) if call else None


# Numbers of calls start at 0 for the first call after the instances were made; init has none.
_RECORD = """
typedef unsigned long long number;
typedef struct {
    number calls;
    number closest[2]; /* counted and static, all classes added up */
    number above[4];
    number unequal[4];
    number largest[SG_N_CLASSES];
    number least[SG_N_CLASSES];
    number turns[SG_N_TURNS + 1];
} record;

static record records[ENTRIES];
static number made;
static int current;

static void keep(number *offence, int kind, number bound)
{
    if (offence[0] == 0) {
        offence[0] = made + 1;
        offence[1] = (number)kind;
        offence[2] = sg_tally[kind];
        offence[3] = bound;
    }
}

void sg_player_begin(int which)
{
    current = which;
    memset(sg_turns, 0, sizeof sg_turns);
    memset(sg_tally, 0, sizeof sg_tally);
}

void sg_player_end(void)
{
    record *r = &records[current];
    number ran_in_all = 0;
    number bound_in_all = 0;
    for (int i = 0; i < SG_N_CLASSES; i++) {
        const number ran = sg_tally[i];
        number bound = fixed[current][i];
        for (int t = 0; t < SG_N_TURNS; t++) {
            bound += sg_turns[t] * part[current][t][i];
        }
        if (r->calls == 0 || ran < r->least[i]) { r->least[i] = ran; }
        if (ran > r->largest[i]) { r->largest[i] = ran; }
        if (ran > bound) { keep(r->above, i, bound); }
        if (exact[current][i] != 0 && ran != bound) { keep(r->unequal, i, bound); }
        ran_in_all += ran;
        bound_in_all += bound;
    }
    if (r->closest[1] == 0 || ran_in_all * r->closest[1] > bound_in_all * r->closest[0]) {
        r->closest[0] = ran_in_all;
        r->closest[1] = bound_in_all;
    }
    for (int t = 0; t < SG_N_TURNS; t++) {
        if (sg_turns[t] > r->turns[t]) { r->turns[t] = sg_turns[t]; }
    }
    r->calls++;
    if (current < FIRST_INIT) { made++; }
}

__attribute__((destructor)) static void write_records(void)
{
    FILE *to = fopen("counts.bin", "wb");
    if (to != NULL) {
        fwrite(records, sizeof records, 1, to);
        fclose(to);
    }
}
"""
