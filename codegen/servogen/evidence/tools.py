"""Outside tools: found, or missed with the name of the package that has them."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from servogen.errors import CheckFailed, InputError
from servogen.evidence.children import run_child

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
    """``run_bytes`` with the output as text.

    Raises:
        CheckFailed: it has not ended after ``PATIENCE_S``; it is killed.
    """
    done = run_bytes(command, folder, given)
    return subprocess.CompletedProcess(
        done.args,
        done.returncode,
        done.stdout.decode("utf-8", "replace"),
        done.stderr.decode("utf-8", "replace"),
    )


def run_bytes(
    command: Sequence[str | Path],
    folder: Path | None = None,
    given: bytes | None = None,
    patience_s: float = PATIENCE_S,
) -> subprocess.CompletedProcess[bytes]:
    """Run to the end, output kept, no exception for a non-zero status.

    ``LC_ALL=C``, so that messages are the same everywhere; ``PWD``, because some tools
    believe it.

    Raises:
        CheckFailed: it has not ended after ``patience_s``; it is killed.
    """
    parts = [str(part) for part in command]
    try:
        own = {"LC_ALL": "C", "PWD": str((folder or Path.cwd()).resolve())}
        return run_child(parts, folder, given, os.environ | own, patience_s)
    except subprocess.TimeoutExpired as late:
        waited = f"{patience_s / 60:.0f} minutes" if patience_s >= 60 else f"{patience_s:g} s"
        raise CheckFailed(f"{Path(parts[0]).name} has not ended after {waited}") from late


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
