"""QP back ends on the same sequences of programs: servogen's, and everyone else's.

    python benchmarks/qp_solvers.py [--quick] [--only NAME ...] [-o FOLDER]

Counts instructions per solve with valgrind's callgrind, clocks the same program without it, judges
every answer against a reference optimum, and writes a table, qp.json, qp.md and qp_growth.html.
Status 0 where all promises are kept, 3 where those are broken that ``qp/unreached.py`` admits and
none is worse than it says, 1 where another one is or was not measured or a tool is missing, 2 where
nothing was measured or has the name given; docs/benchmarks.md says what each number is. ``--quick``
and ``--only`` are for trying it out: then no promise is judged, and the files are named qp_part.
"""

from __future__ import annotations

import argparse
import platform
import shutil
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from qp.chosen import UnknownName
from qp.counted import COMPILER, FLAGS, PLUS, Measured, PeerFailed
from qp.document import qp_parts
from qp.libraries import TINYMPC, TINYMPC_VERSION, replaced_by
from qp.peers import COUNTED, DAQP
from qp.promises import as_rows, promises, status
from qp.sequence import Sequence
from qp.suite import FULL, Missing, suite
from qp.timed import TIMED, timed
from qp.told import as_json, growth, plot, show, show_promises, write, write_json
from qp.tolerance import TOLERANCE
from qp.unreached import UNREACHED
from rich.console import Console

PACKAGES = ("daqp", "osqp", "casadi", "piqp", "proxsuite", "quadprog", "qpmpc")
NOT_RUN = {
    "HPIPM": "not run: CasADi has it for programs that keep their states, not for condensed ones",
    "acados": "not run: no package on the index",
    "LinearMPC.jl": "not run: its package on the index (lmpc) calls Julia, which is not there",
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
    told[TINYMPC] = f"{TINYMPC_VERSION}, sources"
    for tool in (COMPILER, "valgrind"):
        said = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True)
        told[tool] = said.stdout.splitlines()[0]
    return told


def main() -> int:
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("-o", "--output", type=Path, default=Path("out/bench"))
    reader.add_argument("--quick", action="store_true", help="short sequences")
    reader.add_argument(
        "--only",
        nargs="+",
        default=[],
        metavar="NAME",
        help="sequences: whole names, or what names begin with before an underscore",
    )
    given = reader.parse_args()
    for tool, package in (
        (COMPILER, "gcc"),
        (PLUS, "g++"),
        ("valgrind", "valgrind"),
        ("nm", "binutils"),
    ):
        if shutil.which(tool) is None:
            print(f"this benchmark needs {tool}: apt-get install {package}")
            return 1
    given.output.mkdir(parents=True, exist_ok=True)
    try:
        return compare(given.output, given.quick, tuple(given.only))
    except UnknownName as unknown:
        print(f"{reader.prog}: {unknown}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("broken off: nothing written")
        return 130


def compare(output: Path, quick: bool, only: tuple[str, ...]) -> int:
    begin, work = time.monotonic(), output.resolve() / "work"
    console = Console(width=max(170, Console().width))
    told: list[dict[str, Any]] = []
    results: dict[str, dict[str, Measured]] = {}
    for sequence in suite(work, quick, only):
        if isinstance(sequence, Missing):
            told.append({"name": sequence.name, "missing": sequence.why})
        else:
            found, failed = measure(sequence, work, quick)
            results[sequence.name] = found
            told.append(as_json(sequence, found, failed | NOT_RUN))
        show(told[-1], console)
    if not results:
        print("no sequence could be measured")
        return 2
    whole = not (quick or only)
    made = promises(results, FULL, UNREACHED) if whole else []
    show_promises(made, console)
    seconds = time.monotonic() - begin
    written = {
        "schema": "servogen.bench.qp/3",
        "whole": whole,
        "seconds": round(seconds),
        "versions": versions(),
        "flags": list(FLAGS),
        "tolerance": TOLERANCE,
        "tinympc_would_replace": replaced_by("tinympc"),
        "sequences": told,
        "promises": as_rows(made),
    }
    name = "qp" if whole else "qp_part"
    write_json(written, output / f"{name}.json")
    write("\n\n".join(qp_parts(written).values()) + "\n", output / f"{name}.md")
    lines = growth(told, "two_stage_x_")
    if lines.get(DAQP):
        plot(lines, output / f"{name}_growth.html")
    console.print(f"{output / name}.json, .md: {seconds / 60.0:.1f} minutes", highlight=False)
    return status(made)


if __name__ == "__main__":
    sys.exit(main())
