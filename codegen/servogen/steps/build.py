"""``servogen build``: the C package in a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.outputs import write_tree
from servogen.steps.prepare import Prepared
from servogen.steps.system import Simulated, Studied

SCHEMA = "servogen.build/1"


@dataclass(frozen=True)
class BuildResult:
    """What was written, and where; ``figures``: what the system says about its design;
    ``notes``: what its user should know."""

    package: CPackage
    out: Path
    figures: Mapping[str, object] = field(default_factory=dict)
    notes: Sequence[str] = ()
    passed: bool = True

    def lines(self) -> list[str]:
        size = sum(d.table_bytes for d in self.package.declarations)
        return [
            f"build     {len(self.package.files)} files in {self.out}, "
            f"{self.package.declarations[0].precision.name}, {size} bytes of tables, "
            f"design {self.package.hash[:16]}",
            *(f"          note: {note}" for note in self.notes),
        ]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "package": self.package.name,
            "design_hash": self.package.hash,
            "precision": self.package.declarations[0].precision.name,
            **self.figures,
            "notes": list(self.notes),
            "files": {name: len(text.encode()) for name, text in self.package.files.items()},
            "table_bytes": {d.prefix: d.table_bytes for d in self.package.declarations},
        }


def build(prepared: Prepared[Simulated, Studied], out: Path) -> BuildResult:
    """Emit and write, whole or not at all."""
    package = prepared.package
    write_tree(out, package.files)
    return BuildResult(package, out, prepared.system.figures, prepared.system.notes)
