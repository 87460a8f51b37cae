"""QP back ends on the same sequences of programs: servogen's, and everyone else's.

    python benchmarks/qp_solvers.py [--quick] [--only NAME ...] [-o FOLDER]

Counts instructions per solve with valgrind's callgrind where a solver is C of its own process,
times the others beside DAQP, judges every answer against a reference optimum, and writes a table,
qp.json, qp.md and qp_growth.html. Status 1 where a promise is broken; docs/benchmarks.md says what
each number is. ``--quick`` and ``--only`` are for trying it out: then no promise is judged.
"""

from __future__ import annotations

import argparse
import platform
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from qp.counted import COMPILER, FLAGS, Measured, PeerFailed
from qp.peers import COUNTED, DAQP, TOLERANCE
from qp.promises import promises
from qp.sequence import Sequence
from qp.suite import TIGHT, suite
from qp.timed import TIMED, timed
from qp.told import as_json, growth, markdown, plot, show, show_promises, write_json
from rich.console import Console

PACKAGES = ("daqp", "osqp", "casadi", "piqp", "proxsuite", "quadprog")
NOT_RUN = {
    "TinyMPC": "not run: below Python 3.13 its package asks for SciPy below 1.12, which does not "
    "go with NumPy 2",
    "HPIPM": "not run: CasADi has it for programs that keep their states, not for condensed ones",
    "acados": "not run: no package on the index",
    "LinearMPC.jl": "not run: its generator of C is Julia's",
}


def measure(
    sequence: Sequence, folder: Path, quick: bool
) -> tuple[dict[str, Measured], dict[str, str]]:
    """Results by solver, and why the others gave none."""
    found: dict[str, Measured] = {}
    failed: dict[str, str] = {}
    for name, peer, most in COUNTED:
        work = folder / "".join(c if c.isalnum() else "_" for c in name)
        work.mkdir(parents=True, exist_ok=True)
        steps = min(most or sequence.length, sequence.length, 30 if quick else sequence.length)
        try:
            found[name] = peer(sequence, sequence.window(steps), work)
        except PeerFailed as why:
            failed[name] = str(why)
    for name, start in TIMED:
        try:
            found[name] = timed(name, start, sequence, sequence.window(min(200, sequence.length)))
        except PeerFailed as why:
            failed[name] = str(why)
    return found, failed


def versions() -> dict[str, str]:
    told = {"python": platform.python_version(), "machine": platform.machine()}
    for name in PACKAGES:
        try:
            told[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            told[name] = "not installed"
    for tool in (COMPILER, "valgrind"):
        said = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True)
        told[tool] = said.stdout.splitlines()[0]
    return told


def main() -> int:
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("-o", "--output", type=Path, default=Path("out/bench"))
    reader.add_argument("--quick", action="store_true", help="short sequences")
    reader.add_argument("--only", nargs="+", default=[], help="sequences whose names begin so")
    given = reader.parse_args()
    for tool, package in ((COMPILER, "gcc"), ("valgrind", "valgrind"), ("nm", "binutils")):
        if shutil.which(tool) is None:
            print(f"this benchmark needs {tool}: apt-get install {package}")
            return 1
    given.output.mkdir(parents=True, exist_ok=True)
    console = Console(width=max(160, Console().width))
    told: list[dict[str, Any]] = []
    results: dict[str, dict[str, Measured]] = {}
    for sequence in suite(given.quick):
        if given.only and not sequence.name.startswith(tuple(given.only)):
            continue
        found, failed = measure(sequence, given.output.resolve() / "work", given.quick)
        results[sequence.name] = found
        told.append(as_json(sequence, found, failed | NOT_RUN))
        show(told[-1], console)
    whole = not (given.quick or given.only)
    made = promises(results, tuple(f"tight_{velocity:g}" for velocity in TIGHT)) if whole else []
    show_promises(made, console)
    write_json(
        {
            "schema": "servogen.bench.qp/1",
            "versions": versions(),
            "flags": list(FLAGS),
            "tolerance": TOLERANCE,
            "sequences": told,
            "promises": [
                {"promise": p.told, "limit": p.limit, "found": p.found, "kept": p.kept}
                for p in made
            ],
        },
        given.output / "qp.json",
    )
    (given.output / "qp.md").write_text(markdown(told))
    lines = growth(told, "two_stage_x_")
    if lines.get(DAQP):
        plot(lines, given.output / "qp_growth.html")
    return 0 if all(promise.kept for promise in made) else 1


if __name__ == "__main__":
    sys.exit(main())
