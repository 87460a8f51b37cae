"""Which of the bounds that are in the C for the proof's sake ever change a value, and when."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.errors import CheckFailed
from servogen.evidence.bench import Subject
from servogen.evidence.tools import demand, run_tool
from servogen.sil.player import Play, encode, player_source

KERNELS = "sg_kernels.h"
RANDOM_STEPS = 100
_BOUNDS = re.compile(r"\bsg_bound(?:_below|_count)?\(")
_DEFINED = re.compile(r"^static inline \w+ sg_bound\w*\(", re.MULTILINE)
_AFTER = "static inline sg_status sg_worse("
_COUNTING = """
#include <stdio.h>
static inline sg_real sg_seen(sg_real x, sg_real kept, const char *file, int line)
{
    if (!(kept == x)) { fprintf(stderr, "bound %s:%d\\n", file, line); }
    return kept;
}
static inline sg_real sg_bound_at(sg_real x, sg_real low, sg_real high, const char *f, int l)
{
    return sg_seen(x, sg_bound(x, low, high), f, l);
}
static inline sg_real sg_bound_below_at(sg_real x, sg_real low, const char *f, int l)
{
    return sg_seen(x, sg_bound_below(x, low), f, l);
}
static inline int32_t sg_bound_count_at(int32_t x, int32_t low, int32_t high, const char *f, int l)
{
    const int32_t kept = sg_bound_count(x, low, high);
    if (kept != x) { fprintf(stderr, "bound %s:%d\\n", f, l); }
    return kept;
}
#define sg_bound(x, low, high) sg_bound_at(x, low, high, __FILE__, __LINE__)
#define sg_bound_below(x, low) sg_bound_below_at(x, low, __FILE__, __LINE__)
#define sg_bound_count(x, low, high) sg_bound_count_at(x, low, high, __FILE__, __LINE__)

"""


def bound_places(package: CPackage) -> int:
    """How many places of the C call one of the bounds."""
    text = "".join(t for f, t in package.files.items() if f in package.sources or f.endswith(".h"))
    return len(_BOUNDS.findall(text)) - len(_DEFINED.findall(text))


def binding(subject: Subject, plays: Sequence[Play], folder: Path) -> dict[str, int]:
    """Play calls on a copy of the package that counts: ``file:line`` -> values changed.

    Raises:
        CheckFailed: the copy does not compile or run, or there is no place for the counting.
    """
    package = subject.package
    if _AFTER not in package.files[KERNELS]:
        raise CheckFailed(f"{KERNELS}: the bounds have moved, they cannot be counted")
    sources = [path.name for path in subject.write(folder)]
    kernels = package.files[KERNELS].replace(_AFTER, _COUNTING + _AFTER, 1)
    (folder / KERNELS).write_text(kernels, encoding="utf-8")
    (folder / "player.c").write_text(player_source(package.declarations), encoding="utf-8")
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-DSG_PLAYER_FILES"]
    demand(
        ["gcc", *flags, "-o", "player", "player.c", *sources], "gcc of the counting copy", folder
    )
    (folder / "calls.bin").write_bytes(encode(package.declarations, plays))
    done = run_tool([folder / "player"], folder)
    if done.returncode != 0:
        raise CheckFailed(f"the counting copy ends with status {done.returncode}")
    places = (line.removeprefix("bound ") for line in done.stderr.splitlines())
    return dict(sorted(Counter(places).items()))


def judge_bounds(subject: Subject, folder: Path) -> tuple[dict[str, object], list[str]]:
    """Figures and faults: none may bind in the closed loop, some may on garbage."""
    loops, suite = subject.closed_loops(None), subject.suite(RANDOM_STEPS)
    bound = binding(subject, loops, folder / "loop")
    figures: dict[str, object] = {
        "places": bound_places(subject.package),
        "closed_loop_calls": sum(times for play in loops for _, times in play.counted()),
        "closed_loop": bound,
        "suite_calls": sum(times for play in suite for _, times in play.counted()),
        "suite": binding(subject, suite, folder / "suite"),
    }
    faults = [
        f"the bound at {place} binds {n} times in the closed loop" for place, n in bound.items()
    ]
    if figures["places"] == 0 or figures["closed_loop_calls"] == 0:
        faults.append("no bound or no closed loop to look at")
    return figures, faults
