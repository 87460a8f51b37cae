"""Compiling a peer, counting the instructions of its solves, sizing what was linked."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from qp.sequence import Array, Sequence

HERE = Path(__file__).parent / "c"
COMPILER, PLUS = "gcc", "g++"
# Unused functions of a library are no code of a controller that does not call them.
FLAGS = ("-O3", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections")
# Of one peer on one sequence under callgrind, which is fifty times slower than without.
LIMIT_S = 180.0
# Of the clock, the least of which is taken.
PASSES = 3
LINK = ("-Wl,--gc-sections", "-lm")
HARNESS = {
    "main", "must", "now", "clocked", "answered", "peer_load", "peer_answer", "peer_bytes",
    "answer", "__wrap_malloc", "__wrap_calloc", "asked_bytes", "asked_counting",
}  # fmt: skip
# C++ names begin with _Z
RUNTIME = re.compile(r"^(_(?!Z)|deregister_tm|register_tm|frame_dummy|completed|data_start|_?_dso)")
TOTAL = re.compile(r"^(?:totals|summary): (\d+)", re.MULTILINE)


class PeerFailed(RuntimeError):
    """A peer that cannot be built, does not run or is not there; the text says which."""


@dataclass(frozen=True)
class Measured:
    """What one solver did on one sequence.

    Attributes:
        part: the programs of the sequence that were solved.
        cost: (k,) instructions per solve, or seconds where ``unit`` says so.
        error: (k,) largest distance to the reference optimum, by the range of z over the sequence.
        residual: (k,) largest violation of a row.
        solved: (k,) whether the solver says so. iterations: (k,), -1: not told.
        seconds: (k,) per solve without callgrind, or none.
        code, kept, written: bytes of functions; of tables and problem data; of workspace; -1: not
            known.
    """

    solver: str
    unit: str
    part: slice
    cost: Array
    error: Array
    residual: Array
    solved: Array
    iterations: Array
    code: int = -1
    kept: int = -1
    written: int = -1
    note: str = ""
    seconds: Array = field(default_factory=lambda: np.zeros(0))


def run(words: Iterable[str | Path], folder: Path, limit_s: float = LIMIT_S) -> str:
    """Standard output of a command.

    Raises:
        PeerFailed: it ends with a status, is missing or takes longer than ``limit_s``.
    """
    command = [str(word) for word in words]
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=limit_s, check=False
        )
    except subprocess.TimeoutExpired as slow:
        raise PeerFailed(f"{Path(command[0]).name}: stopped after {limit_s:.0f} s") from slow
    except OSError as missing:
        raise PeerFailed(f"{command[0]}: {missing}") from missing
    if done.returncode != 0:
        told = (done.stderr.strip() or done.stdout.strip()).splitlines()
        errors = [line for line in told if "error" in line] or told[-1:]
        raise PeerFailed(f"{Path(command[0]).name} ends with {done.returncode}: {errors[:1]}")
    return done.stdout


def compile_peer(
    folder: Path, sources: Iterable[Path], includes: Iterable[Path] = (), extra: Iterable[str] = ()
) -> Path:
    """The harness with a peer; ``peer`` in the folder. C and C++ each by their compiler, with the
    same options; a standard that is asked for is that of the peer's own language."""
    program, objects = folder / "peer", []
    given, plus = list(extra), False
    standard = [word for word in given if word.startswith("-std=")]
    libraries = [word for word in given if word.startswith(("-l", "-L", "-Wl"))]
    options = [word for word in given if word not in (*standard, *libraries)]
    for i, source in enumerate([HERE / "harness.c", *sources]):
        if source.suffix == ".o":
            objects.append(source)
            continue
        is_plus = source.suffix == ".cpp"
        plus |= is_plus
        own = [word for word in standard if ("++" in word) == is_plus and i > 0]
        objects.append(folder / f"{i}_{source.stem}.o")
        run(
            [PLUS if is_plus else COMPILER, *FLAGS, *own, f"-I{HERE}", f"-I{folder}",
             *(f"-I{i}" for i in includes), *options, "-c", source, "-o", objects[-1]],
            folder,
        )  # fmt: skip
    run([PLUS if plus else COMPILER, *objects, "-o", program, *libraries, *LINK], folder)
    return program


def instructions(dump: str) -> int | None:
    """Instructions of one dump of callgrind; None for one that says nothing."""
    found = TOTAL.search(dump)
    return int(found[1]) if found else None


def count(program: Path, sequence: Sequence, part: slice) -> tuple[Array, Array, dict[str, int]]:
    """Instructions per solve, (k,); answers (k, n + 2); what the peer tells of its bytes."""
    folder = program.parent
    for old in folder.glob("dump*"):
        old.unlink()
    sequence.write(folder / "programs", part)
    told = run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=dump", "--collect-atstart=no",
         "--toggle-collect=solve_one", "--dump-after=solve_one", program, "programs", "answers"],
        folder,
    )  # fmt: skip
    dumps = sorted(folder.glob("dump.*"), key=lambda place: int(place.suffix[1:]))
    found = [instructions(place.read_text()) for place in dumps]
    for place in [*dumps, folder / "dump"]:
        place.unlink(missing_ok=True)
    answers = np.fromfile(folder / "answers").reshape(-1, sequence.variables + 2)
    cost = np.array([value for value in found if value], dtype=float)
    if len(cost) != len(answers):
        raise PeerFailed(f"callgrind counted {len(cost)} of {len(answers)} solves")
    return cost, answers, json.loads(told.splitlines()[-1])


def sizes(program: Path) -> dict[str, int]:
    """Bytes of functions, constants and variables in the linked program, the harness's not."""
    found = {"code": 0, "constant": 0, "variable": 0}
    kinds = {"t": "code", "w": "code", "r": "constant", "d": "variable", "b": "variable"}
    for line in run(["nm", "-S", program], program.parent).splitlines():
        words = line.split()
        if len(words) != 4 or words[2].lower() not in kinds:
            continue
        base = words[3].split(".")[0]
        if base in HARNESS or RUNTIME.match(base):
            continue
        found[kinds[words[2].lower()]] += int(words[1], 16)
    return found


def clock(program: Path, sequence: Sequence, part: slice, passes: int = PASSES) -> Array:
    """Seconds per solve, (k,): the least of a few passes, as what else the machine does adds."""
    folder = program.parent
    sequence.write(folder / "programs", part)
    run([program, "programs", "times", str(passes)], folder)
    return np.fromfile(folder / "times")


def counted_peer(
    name: str, program: Path, sequence: Sequence, part: slice, static: bool = False,
    note: str = "", sized: bool = True,
) -> Measured:  # fmt: skip
    """Counted under callgrind, then clocked without it.

    Args:
        static: tables and workspace are variables of the linked program.
        sized: its code is in the linked program, and not in a library beside it.
    """
    cost, answers, told = count(program, sequence, part)
    found = sizes(program) if sized else {"code": -1}
    kept, written = told["kept"], told["written"]
    if static:
        kept, written = kept + found["constant"], written + found["variable"]
    done = judged(
        name, "instructions", sequence, part, cost, answers, found["code"], kept, written, note
    )
    return replace(done, seconds=clock(program, sequence, part))


def judged(
    solver: str, unit: str, sequence: Sequence, part: slice, cost: Array, answers: Array,
    code: int = -1, kept: int = -1, written: int = -1, note: str = "",
) -> Measured:  # fmt: skip
    """Answers (k, n + 2) against the reference and the rows."""
    n = sequence.variables
    z = answers[:, :n]
    span = float(np.ptp(sequence.optimum))
    at = z @ sequence.rows.T
    over = np.maximum(at - sequence.high[part], sequence.low[part] - at)
    return Measured(
        solver, unit, part, cost,
        error=np.max(np.abs(z - sequence.optimum[part]), axis=1) / span,
        residual=np.max(over, axis=1, initial=0.0),
        solved=answers[:, n] == 0.0,
        iterations=answers[:, n + 1].astype(int),
        code=code, kept=kept, written=written, note=note,
    )  # fmt: skip
