"""The C6000 cross compiler: built once from Debian's source packages, then kept."""

from __future__ import annotations

from pathlib import Path

from servogen.errors import CheckFailed
from servogen.evidence.tools import ToolMissing, cache_dir, run_tool
from servogen.progress import Progress
from servogen.resources import resource_dir

COMPILER = "tic6x-elf-gcc"


def toolchain(progress: Progress, home: Path | None = None) -> Path:
    """Folder of ``tic6x-elf-gcc`` and its companions; about six minutes the first time.

    Args:
        home: where it is kept, ``cache_dir()/tic6x-elf`` by default.

    Raises:
        ToolMissing: it is not built and what it is built from is not installed.
        CheckFailed: building failed; nothing of it is left where it would be taken for whole.
    """
    home = cache_dir() / "tic6x-elf" if home is None else home
    found = home / "bin" / COMPILER
    if found.is_file():
        return found.parent
    script = resource_dir("c_runtime") / "dsp" / "build_toolchain.sh"
    asked = run_tool(["sh", script, "--missing"])
    if asked.returncode != 0:
        raise ToolMissing(COMPILER, asked.stdout.strip())
    with progress.task("Building the C6000 compiler, once (six minutes on two cores)"):
        done = run_tool(["sh", script, home])
    if done.returncode != 0 or not found.is_file():
        said = (done.stderr or done.stdout).strip().splitlines() or ["it says nothing"]
        raise CheckFailed(f"the C6000 compiler could not be built: {said[-1]}")
    return found.parent
