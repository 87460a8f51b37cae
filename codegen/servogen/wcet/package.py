"""Counts of an emitted package: the one call other rooms use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from servogen.wcet.ctype import Scalar, size_of
from servogen.wcet.operations import OperationCounts
from servogen.wcet.program import Program
from servogen.wcet.unit import static_constants


@dataclass(frozen=True)
class Count:
    """Worst case of one entry point: ``fixed + sum over caps of cap * per_iteration``.

    Attributes:
        fixed: operations that do not depend on an iteration cap.
        per_iteration: cap name -> operations of one iteration, of all loops up to that cap.
        caps: cap name -> its value in the emitted C.
        stack_bytes: parameters and locals along the deepest chain of calls, of the C objects.
    """

    fixed: OperationCounts
    per_iteration: Mapping[str, OperationCounts]
    caps: Mapping[str, int]
    stack_bytes: int

    def total(self, cap: int | None = None) -> OperationCounts:
        """Operations with all caps at ``cap``, or as emitted."""
        result = self.fixed
        for name, part in self.per_iteration.items():
            result = result + part * (self.caps[name] if cap is None else cap)
        return result

    def one_iteration(self) -> OperationCounts:
        """Operations that one more iteration adds when all caps are equal."""
        result = OperationCounts()
        for part in self.per_iteration.values():
            result = result + part
        return result

    def to_json(self) -> dict[str, object]:
        return {
            "fixed": self.fixed.as_dict(),
            "per_iteration": {n: p.as_dict() for n, p in self.per_iteration.items()},
            "caps": dict(self.caps),
            "total": self.total().as_dict(),
            "stack_bytes": self.stack_bytes,
        }


@dataclass(frozen=True)
class PackageCount:
    """Counts per entry point, in the order asked for.

    Attributes:
        precision: ``float32`` or ``float64``, of ``sg_real``.
        entry_points: name -> worst case.
        table_bytes: name of each constant object with storage -> bytes, in order of appearance.
    """

    precision: str
    entry_points: Mapping[str, Count]
    table_bytes: Mapping[str, int]

    @property
    def total_table_bytes(self) -> int:
        return sum(self.table_bytes.values())

    def to_json(self) -> dict[str, object]:
        return {
            "precision": self.precision,
            "entry_points": {n: c.to_json() for n, c in self.entry_points.items()},
            "table_bytes": dict(self.table_bytes),
            "total_table_bytes": self.total_table_bytes,
        }


def count_package(
    source_files: Sequence[Path],
    include_dirs: Sequence[Path],
    entry_points: Sequence[str],
    defines: Sequence[str] = (),
) -> PackageCount:
    """Worst-case operations of the emitted C, read from the C itself.

    A loop runs as often as its constant bounds say, of a decision the costlier way is taken class
    by class, and a loop up to an enumeration constant named ``..._ITERATION_CAP`` is told apart.
    What is a load, a store and a free operation stands in ``servogen.wcet.expressions``.

    Args:
        source_files: the package's C files, tables included.
        include_dirs: folders of its headers.
        entry_points: names of functions.
        defines: ``NAME`` or ``NAME=VALUE`` for the preprocessor.

    Raises:
        CountRefused: something without a provable bound, named by file and line.
        CheckFailed: C that cannot be parsed.
        InputError: no gcc, or a missing file.
    """
    program = Program(source_files, include_dirs, defines)
    real = program.real_type
    single = isinstance(real, Scalar) and real.kind == "float"
    return PackageCount(
        "float32" if single else "float64",
        {name: _count(program, name) for name in entry_points},
        _tables(program),
    )


def _count(program: Program, name: str) -> Count:
    fixed, per_iteration = program.cost(name).counts()
    enums = {n: v for unit in program.units for n, v in unit.enums.items()}
    caps = {cap: enums[cap] for cap in per_iteration}
    return Count(fixed, per_iteration, caps, program.stack_bytes(name))


def _tables(program: Program) -> dict[str, int]:
    """Constant objects; a static one in a shared header has storage in every unit."""
    tables: dict[str, int] = {}
    for unit in program.units:
        for name, item in unit.globals.items():
            if item.constant and item.defined:
                tables[name] = size_of(item.type) + (0 if item.external else tables.get(name, 0))
        for function in unit.functions.values():
            for declaration in static_constants(function.body):
                label = f"{function.decl.name}.{declaration.name}"
                tables[label] = size_of(unit.declared_type(declaration)) + tables.get(label, 0)
    return tables
