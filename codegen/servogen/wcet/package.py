"""Counts of an emitted package: the one call other rooms use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from servogen.wcet.constants import CAP_SUFFIX, DEPTH_SUFFIX
from servogen.wcet.ctype import Scalar, size_of
from servogen.wcet.operations import OperationCounts
from servogen.wcet.program import Program
from servogen.wcet.refusal import CountRefused
from servogen.wcet.unit import Unit, static_constants


@dataclass(frozen=True)
class Count:
    """Worst case of one entry point: ``fixed + sum over caps of cap * part``.

    Attributes:
        fixed: operations that depend on no named bound.
        per_iteration: iteration cap -> operations of one iteration, of all loops up to that cap.
        caps: named bound -> its value in the emitted C.
        stack_bytes: parameters and locals along the deepest chain of calls, of the C objects.
        per_level: tree depth -> operations of one level, of all walks to that depth.
        exact: classes that every run, whatever its data, does just as often as counted.
    """

    fixed: OperationCounts
    per_iteration: Mapping[str, OperationCounts]
    caps: Mapping[str, int]
    stack_bytes: int
    per_level: Mapping[str, OperationCounts] = field(default_factory=dict)
    exact: tuple[str, ...] = ()

    @property
    def base(self) -> OperationCounts:
        """What depends on no iteration cap: the fixed part and all levels of the trees."""
        result = self.fixed
        for name, part in self.per_level.items():
            result = result + part * self.caps[name]
        return result

    @property
    def iteration_caps(self) -> dict[str, int]:
        return {name: self.caps[name] for name in self.per_iteration}

    def total(self, cap: int | None = None) -> OperationCounts:
        """Operations with all iteration caps at ``cap``, or as emitted."""
        result = self.base
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
            "per_tree_level": {n: p.as_dict() for n, p in self.per_level.items()},
            "caps": dict(self.caps),
            "total": self.total().as_dict(),
            "exact": list(self.exact),
            "stack_bytes": self.stack_bytes,
        }


@dataclass(frozen=True)
class PackageCount:
    """Counts per entry point, in the order asked for.

    Attributes:
        precision: ``float32`` or ``float64``, of ``sg_real``.
        entry_points: name -> worst case.
        table_bytes: name of each constant object with storage -> bytes, in order of appearance.
        source_table_bytes: C file -> bytes of the tables that have storage in it.
        type_bytes: name of each structure asked for -> its size on the target.
    """

    precision: str
    entry_points: Mapping[str, Count]
    table_bytes: Mapping[str, int]
    source_table_bytes: Mapping[str, int] = field(default_factory=dict)
    type_bytes: Mapping[str, int] = field(default_factory=dict)

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
    types: Sequence[str] = (),
) -> PackageCount:
    """Worst-case operations of the emitted C, read from the C itself.

    A loop runs as often as its constant bounds say, of a decision the costlier way is taken class
    by class. A loop up to an enumeration constant named ``..._ITERATION_CAP`` is told apart, and
    one up to ``..._TREE_DEPTH``, the walk from a tree's root to a leaf.
    What is a load, a store and a free operation stands in ``servogen.wcet.expressions``.

    Args:
        source_files: the package's C files, tables included.
        include_dirs: folders of its headers.
        entry_points: names of functions; static ones too, where one file alone has them.
        defines: ``NAME`` or ``NAME=VALUE`` for the preprocessor.
        types: names of structures whose size is wanted.

    Raises:
        CountRefused: something without a provable bound, named by file and line.
        CheckFailed: C that cannot be parsed.
        InputError: no gcc, or a missing file.
    """
    program = Program(source_files, include_dirs, defines)
    real = program.real_type
    single = isinstance(real, Scalar) and real.kind == "float"
    by_source = {unit.source.name: _tables(unit) for unit in program.units}
    tables: dict[str, int] = {}
    for found in by_source.values():
        for name, size in found.items():
            tables[name] = size + tables.get(name, 0)
    return PackageCount(
        "float32" if single else "float64",
        {name: _count(program, name) for name in entry_points},
        tables,
        {name: sum(found.values()) for name, found in by_source.items()},
        {name: program.type_bytes(name) for name in types},
    )


def _count(program: Program, name: str) -> Count:
    cost = program.cost(name)
    fixed, parts = cost.counts()
    names = [cap.name for cap in parts]
    if len(set(names)) < len(names):
        raise CountRefused(f"cannot count: {name} meets a bound with two values: {names}")
    return Count(
        fixed,
        {cap.name: part for cap, part in parts.items() if cap.name.endswith(CAP_SUFFIX)},
        {cap.name: cap.number for cap in parts},
        program.stack_bytes(name),
        {cap.name: part for cap, part in parts.items() if cap.name.endswith(DEPTH_SUFFIX)},
        cost.exact(),
    )


def _tables(unit: Unit) -> dict[str, int]:
    """Constant objects with storage in a unit; a static one in a shared header is in every unit."""
    tables: dict[str, int] = {}
    for name, item in unit.globals.items():
        if item.constant and item.defined:
            tables[name] = size_of(item.type)
    for function in unit.functions.values():
        for declaration in static_constants(function.body):
            label = f"{function.decl.name}.{declaration.name}"
            tables[label] = size_of(unit.declared_type(declaration)) + tables.get(label, 0)
    return tables
