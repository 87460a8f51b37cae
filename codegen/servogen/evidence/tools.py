"""Outside tools: found, or missed with the name of the package that has them."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from servogen.errors import CheckFailed, InputError

# Ten times what the slowest of them takes: an emulator that waits for ever is not waited for.
PATIENCE_S = 3600.0


class ToolMissing(InputError):
    """A check cannot run here: one of its tools is not installed (exit status 3).

    Args:
        tool: the command looked for.
        remedy: what to do, ``apt-get install qemu-system-arm``.
    """

    exit_status = 3

    def __init__(self, tool: str, remedy: str) -> None:
        super().__init__(None, tool, "missing", f"it on the PATH: {remedy}")


def find_tool(tool: str, remedy: str) -> Path:
    """The tool's path.

    Raises:
        ToolMissing: it is not on the PATH.
    """
    found = shutil.which(tool)
    if found is None:
        raise ToolMissing(tool, remedy)
    return Path(found)


def version_of(command: Sequence[str | Path]) -> str:
    """First line that a tool prints about its version, e.g. of ``["gcc", "--version"]``."""
    done = run_tool(command)
    lines = (done.stdout or done.stderr).strip().splitlines()
    return lines[0].strip() if lines else "unknown"


def run_tool(
    command: Sequence[str | Path], folder: Path | None = None, given: bytes | None = None
) -> subprocess.CompletedProcess[str]:
    """Run to the end, output kept as text, no exception for a non-zero status.

    ``LC_ALL=C``, so that messages are the same everywhere; ``PWD``, because some tools
    believe it.

    Raises:
        CheckFailed: it has not ended after ``PATIENCE_S``; it is killed.
    """
    try:
        done = subprocess.run(
            [str(part) for part in command],
            cwd=folder,
            input=given,
            capture_output=True,
            check=False,
            env=os.environ | {"LC_ALL": "C", "PWD": str((folder or Path.cwd()).resolve())},
            timeout=PATIENCE_S,
        )
    except subprocess.TimeoutExpired as late:
        name = Path(str(command[0])).name
        raise CheckFailed(f"{name} has not ended after {PATIENCE_S / 60:.0f} minutes") from late
    return subprocess.CompletedProcess(
        done.args,
        done.returncode,
        done.stdout.decode("utf-8", "replace"),
        done.stderr.decode("utf-8", "replace"),
    )


def demand(command: Sequence[str | Path], what: str, folder: Path | None = None) -> str:
    """Run a tool that has to succeed; its standard output.

    Raises:
        CheckFailed: it did not, with the first lines of what it said.
    """
    done = run_tool(command, folder)
    if done.returncode != 0:
        said = " / ".join((done.stderr or done.stdout).strip().splitlines()[:5])
        raise CheckFailed(f"{what}: {said}")
    return done.stdout


def cache_dir() -> Path:
    """Where what is built once is kept: ``SERVOGEN_CACHE``, or ``~/.cache/servogen``."""
    chosen = os.environ.get("SERVOGEN_CACHE")
    return Path(chosen) if chosen else Path.home() / ".cache" / "servogen"
