"""What every check is given: the emitted packages of one project and the calls that drive them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.precision import Precision
from servogen.sil.player import Play
from servogen.wcet.package import PackageCount


@dataclass(frozen=True)
class Subject:
    """One emitted package, as it is shipped.

    Attributes:
        package: the C.
        precision: its scalar type.
        counts: the static worst case of every entry point.
        suite: edges and random calls of every controller, as ``servogen sil`` makes them; the
            argument is how many random steps each.
        closed_loops: the calls of the controllers that users call, each around its plant, for so
            many periods or (None) to the end.
    """

    package: CPackage
    precision: Precision
    counts: PackageCount
    suite: Callable[[int], list[Play]]
    closed_loops: Callable[[int | None], list[Play]]

    @property
    def digest(self) -> str:
        """sha-256 of the C: names and texts of all sources and headers."""
        files = self.package.files
        text = "\0".join(f"{n}\0{files[n]}" for n in sorted(files) if n.endswith((".c", ".h")))
        return hashlib.sha256(text.encode()).hexdigest()

    def write(self, folder: Path) -> list[Path]:
        """All files of the package into ``folder``; paths of the sources to compile."""
        self.package.write(folder)
        return [folder / name for name in self.package.sources]


@dataclass(frozen=True)
class Bench:
    """One project on the bench: ``subjects`` in its own precision first, then in the other."""

    name: str
    subjects: tuple[Subject, ...]

    @property
    def digests(self) -> dict[str, str]:
        """For ``Finding.subjects``."""
        return {s.precision.name: s.digest for s in self.subjects}

    @property
    def own_digest(self) -> dict[str, str]:
        """The same for a check of what is shipped alone."""
        own = self.subjects[0]
        return {own.precision.name: own.digest}
