"""``servogen build``: the C package in a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from servogen.emit.package import CPackage
from servogen.outputs import write_tree
from servogen.steps.prepare import Prepared

SCHEMA = "servogen.build/1"


@dataclass(frozen=True)
class BuildResult:
    """What was written, and where."""

    package: CPackage
    out: Path
    cap: int
    passed: bool = True

    def lines(self) -> list[str]:
        size = sum(d.table_bytes for d in self.package.declarations)
        return [
            f"build     {len(self.package.files)} files in {self.out}, "
            f"{self.package.declarations[0].precision.name}, {size} bytes of tables, "
            f"design {self.package.hash[:16]}"
        ]

    def to_json(self) -> dict[str, object]:
        return {
            "schema": SCHEMA,
            "passed": self.passed,
            "package": self.package.name,
            "design_hash": self.package.hash,
            "precision": self.package.declarations[0].precision.name,
            "iteration_cap": self.cap,
            "files": {name: len(text.encode()) for name, text in self.package.files.items()},
            "table_bytes": {d.prefix: d.table_bytes for d in self.package.declarations},
        }


def build(prepared: Prepared, out: Path) -> BuildResult:
    """Emit and write, whole or not at all."""
    package = prepared.package
    write_tree(out, package.files)
    cap = prepared.tuning.solver.cap if prepared.tuning.horizon else 0
    return BuildResult(package, out, cap)
