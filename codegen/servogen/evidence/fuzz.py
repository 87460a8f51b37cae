"""libFuzzer on every controller of a project, from its declared interface, for a bounded time."""

from __future__ import annotations

import os
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

from servogen.controllers.design import Declaration
from servogen.errors import InputError
from servogen.evidence.bench import Bench
from servogen.evidence.complaints import complaint
from servogen.evidence.finding import Finding
from servogen.evidence.fuzz_build import build_fuzzers
from servogen.evidence.fuzz_corpus import corpus_dir, first_sequences, may_grow
from servogen.evidence.tools import ToolMissing, demand, find_tool, run_tool, version_of
from servogen.progress import Progress

PACKAGES = "apt-get install clang libclang-rt-14-dev"
SECONDS = 60  # per project; FUZZ_SECONDS changes it
LONGEST = 400  # bytes of a sequence
SEED = 20260
_EMPTY_TARGET = (
    "int LLVMFuzzerTestOneInput(const char *p, long n) { (void)p; (void)n; return 0; }\n"
)


@dataclass(frozen=True)
class Fuzzed:
    """One target's run: sequences tried, edges of the C that were seen, what went wrong."""

    executions: int
    edges: int
    fault: str


def run(bench: Bench, progress: Progress) -> Finding:
    """See ``evidence.catalogue``. In a checkout, sequences that reach something new are kept.

    Raises:
        ToolMissing: no clang, or none with libFuzzer.
        CheckFailed: a target does not compile.
        InputError: FUZZ_SECONDS is no number of seconds.
    """
    require_libfuzzer()
    targets = [(s, d) for s in bench.subjects for d in s.package.declarations]
    share = max(1, seconds() // len(targets))
    figures: dict[str, dict[str, object]] = {}
    faults: list[str] = []
    with (
        tempfile.TemporaryDirectory(prefix="servogen-fuzz-") as scratch,
        progress.task("Fuzzing", total=len(targets)) as task,
    ):
        for subject in bench.subjects:
            name = subject.precision.name
            folder = Path(scratch, name)
            figures[name] = {}
            for prefix, program in build_fuzzers(subject, folder).items():
                d = next(d for d in subject.package.declarations if d.prefix == prefix)
                result = fuzz(program, d, share, folder / f"new_{prefix}")
                figures[name][prefix] = {"executions": result.executions, "edges": result.edges}
                faults += [f"{name}: {prefix}: {result.fault}"] if result.fault else []
                task.advance()
    total = sum(_executions(by_prefix) for by_prefix in figures.values())
    return Finding(
        check="fuzz",
        passed=not faults and bool(targets),
        summary=f"{total} sequences of calls on {len(targets)} targets, {share} s each",
        tools={"clang": version_of(["clang", "--version"])},
        subjects=bench.digests,
        figures={"seconds_per_target": share, **figures},
        faults=tuple(faults),
    )


def fuzz(program: Path, declaration: Declaration, share: int, new: Path) -> Fuzzed:
    """Run one target for ``share`` seconds from the kept corpus; keep what reaches new code."""
    new.mkdir()
    for number, sequence in enumerate(first_sequences(declaration)):
        (new / f"first_{number}").write_bytes(sequence)
    kept = corpus_dir() / declaration.kind
    folders = [str(new), *([str(kept)] if kept.is_dir() else [])]
    options = [f"-max_total_time={share}", f"-max_len={LONGEST}", f"-seed={SEED}"]
    options += ["-len_control=10", "-timeout=60", "-rss_limit_mb=4096", "-print_final_stats=1"]
    done = run_tool([program, *options, f"-artifact_prefix={new.parent}/", *folders], new.parent)
    executions = re.search(r"number_of_executed_units: (\d+)", done.stderr)
    edges = re.findall(r"cov: (\d+)", done.stderr)
    tried = int(executions[1]) if executions else 0
    if done.returncode != 0:
        return Fuzzed(tried, int(edges[-1]) if edges else 0, _fault(done.stderr, new.parent))
    if may_grow(kept):
        kept.mkdir(exist_ok=True)
        merge: list[str | Path] = [program, "-merge=1", "-use_counters=0", str(kept), str(new)]
        demand(merge, f"merging the corpus of {declaration.prefix}", new.parent)
    seen = int(edges[-1]) if edges else 0
    return Fuzzed(tried, seen, "" if tried and seen else "libFuzzer tried nothing")


def _fault(said: str, folder: Path) -> str:
    """The first complaint, and the bytes that lead to it."""
    what = complaint(said, folder)
    for file in sorted((*folder.glob("crash-*"), *folder.glob("timeout-*"), *folder.glob("oom-*"))):
        what += f"; sequence {file.read_bytes().hex()}"
        file.unlink()
    return what


def seconds() -> int:
    """Time of one project, in seconds.

    Raises:
        InputError: FUZZ_SECONDS is no whole number from 1 on.
    """
    chosen = os.environ.get("FUZZ_SECONDS", str(SECONDS))
    if not chosen.isdigit() or int(chosen) < 1:
        raise InputError(None, "FUZZ_SECONDS", chosen, "a number of seconds, 1 or more")
    return int(chosen)


def require_libfuzzer() -> None:
    """Raise ``ToolMissing`` unless clang can link with libFuzzer."""
    find_tool("clang", PACKAGES)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "empty.c").write_text(_EMPTY_TARGET, encoding="utf-8")
        command = ["clang", "-fsanitize=fuzzer,address,undefined", "-o", "empty", "empty.c"]
        if run_tool(command, Path(folder)).returncode != 0:
            raise ToolMissing("clang's libFuzzer", PACKAGES)


def _executions(by_prefix: dict[str, object]) -> int:
    return sum(int(item["executions"]) for item in by_prefix.values() if isinstance(item, dict))
